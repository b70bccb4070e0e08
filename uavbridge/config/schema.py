"""The mission file's JSON schema, for editors and for our own messages."""

from __future__ import annotations

from functools import cache
from math import inf
from typing import Any

import msgspec

from uavbridge.config.field_error import KeyPath
from uavbridge.config.mission import Mission


def json_schema() -> dict[str, Any]:
    """A JSON schema (2020-12) of mission files."""
    schema = msgspec.json.schema(Mission)
    parts = schema["$defs"]
    root = parts.pop("Mission")
    del root["properties"]["vehicles"]["default"]
    for part in (root, *parts.values()):
        for key in part["properties"].values():
            _tidy(key)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **root,
        "title": "uavbridge mission file",
        "$defs": parts,
    }


def _tidy(key: dict[str, Any]) -> None:
    """Drop what TOML or JSON cannot spell: null, a whole table as default, infinity."""
    if "default" in key and (key["default"] in (None, inf) or "$ref" in key):
        del key["default"]
    alternatives = [part for part in key.get("anyOf", ()) if part.get("type") != "null"]
    if len(alternatives) == 1:  # a key that may be None is one that may be absent
        del key["anyOf"]
        key.update(alternatives[0])


@cache
def _schema() -> dict[str, Any]:
    return json_schema()


def part_at(path: KeyPath) -> dict[str, Any]:
    """The schema of the value at a path; empty where the schema is silent."""
    part = _resolve(_schema())
    for step in path:
        if isinstance(step, str):
            part = part.get("properties", {}).get(step, {})
        else:
            prefix = part.get("prefixItems", ())
            part = prefix[step] if step < len(prefix) else part.get("items", {})
        part = _resolve(part if isinstance(part, dict) else {})
    return part


def _resolve(part: dict[str, Any]) -> dict[str, Any]:
    """A part with its reference followed."""
    reference = part.get("$ref")
    if reference is None:
        return part
    target: dict[str, Any] = _schema()["$defs"][reference.rsplit("/", 1)[-1]]
    return target
