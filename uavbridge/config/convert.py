"""From a TOML document's dicts to a ``Mission``: types, ranges and unknown keys."""

from __future__ import annotations

import re
from difflib import get_close_matches
from typing import Any

import msgspec

from uavbridge.config.field_error import FieldError, KeyPath, parse_path, value_at
from uavbridge.config.mission import Mission
from uavbridge.config.schema import part_at

_WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a string",
    "bool": "true or false",
    "array": "an array",
    "object": "a table",
    "null": "nothing",
}


def convert(data: dict[str, Any]) -> Mission:
    """The mission that a TOML document describes, its single values checked.

    Raises:
        FieldError: the first thing wrong.
    """
    try:
        return msgspec.convert(data, Mission)
    except msgspec.ValidationError as error:
        what, _, place = str(error).partition(" - at `")
        raise _field_error(data, what, parse_path(place.rstrip("`"))) from None


def _field_error(data: dict[str, Any], what: str, path: KeyPath) -> FieldError:
    if missing := re.fullmatch(r"Object missing required field `(.*)`", what):
        return FieldError((*path, missing[1]), "is missing")
    if unknown := re.fullmatch(r"Object contains unknown field `(.*)`", what, re.DOTALL):
        return _unknown(path, unknown[1])
    path = _inside_table(data, path)
    try:
        got = value_at(data, path)
    except LookupError:
        return FieldError(path, what)
    return FieldError(path, _in_words(what, path), got)


def _unknown(path: KeyPath, key: str) -> FieldError:
    known = list(part_at(path).get("properties", ()))
    near = get_close_matches(key, known, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else f"known here: {', '.join(known)}"
    return FieldError((*path, key), f"unknown key; {hint}")


def _inside_table(data: dict[str, Any], path: KeyPath) -> KeyPath:
    """The key of a free table of numbers that is not a number; msgspec does not say which."""
    if path != ("simulator", "parameters"):
        return path
    table = value_at(data, path)
    if not isinstance(table, dict):
        return path
    wrong = [key for key, value in table.items() if type(value) not in (int, float)]
    return (*path, wrong[0]) if wrong else path


def _in_words(what: str, path: KeyPath) -> str:
    part = part_at(path)
    if choices := _choices(part):
        return "must be one of " + ", ".join(choices)
    if bound := re.fullmatch(r"Expected `\w+` ([<>]=?) (\S+)", what):
        return f"must be {bound[1]} {float(bound[2]):.15g}"
    if length := re.fullmatch(r"Expected `array` of length (\d+), got \d+", what):
        return f"must be an array of {length[1]} numbers"
    if kind := re.fullmatch(r"Expected `(.+?)`(?:, got `.*`)?", what):
        names = [_WORDS.get(name, name) for name in kind[1].split(" | ") if name != "null"]
        return "must be " + " or ".join(names)
    if "regex" in what:
        return f"must match {part['pattern']}"
    return what[0].lower() + what[1:]


def _choices(part: dict[str, Any]) -> list[str]:
    options = part.get("enum", [])
    others = [alternative for alternative in part.get("anyOf", ()) if "enum" in alternative]
    for alternative in others:
        options = [*options, *alternative["enum"]]
    words = [f'"{option}"' for option in options]
    numbers = [a for a in part.get("anyOf", ()) if a.get("type") == "integer"]
    return words + [f"a number from {a['minimum']} to {a['maximum']}" for a in numbers if words]
