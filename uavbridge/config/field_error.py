"""What is wrong with a mission file, in one line that names the file, the line and the key."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

KeyPath: TypeAlias = tuple[str | int, ...]

_HEADER = re.compile(r"^\s*\[(\[?)\s*([^\[\]]+?)\s*\]")
_KEY = re.compile(
    r"""^\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*="""
)
_LONGEST = 60


class FieldError(Exception):
    """One thing wrong at a key.

    Args:
        path: of the key, such as ``("fleet", "starts", 3)``.
        what: is wrong, without the value.
        got: the value; left out of the message where there is none.
    """

    def __init__(self, path: KeyPath, what: str, *got: object) -> None:
        super().__init__(what)
        self.path = path
        self.what = what
        self.got = f" (got {_shown(got[0])})" if got else ""

    def __str__(self) -> str:
        return f"{self.what}{self.got}"


def dotted(path: KeyPath) -> str:
    """``fleet.starts[3]``."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.lstrip(".")


def parse_path(text: str) -> KeyPath:
    """The path of msgspec's ``$.fleet.starts[3]``; a table's unknown key ``[...]`` is cut off."""
    parts = re.findall(r"\.([^.\[\]]+)|\[(\d+)\]", text.split("[...]")[0])
    return tuple(name or int(index) for name, index in parts)


def value_at(data: Any, path: KeyPath) -> Any:
    """The value at a path. Raises LookupError where there is none."""
    for part in path:
        try:
            data = data[part]
        except (LookupError, TypeError):
            raise LookupError(dotted(path)) from None
    return data


def line_of(text: str, path: KeyPath) -> int | None:
    """Line (from 1) at which a TOML text sets the key, or the nearest thing around it.

    A plain search by line, right for files as people write them; None where nothing fits.
    """
    lines = dict(_keys(text))
    for length in range(len(path), 0, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None


def _keys(text: str) -> Iterator[tuple[KeyPath, int]]:
    """Paths of the keys and tables of a TOML text with their lines."""
    table: KeyPath = ()
    counts: dict[KeyPath, int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        if header := _HEADER.match(line):
            table = _split(header[2])
            if header[1]:
                counts[table] = counts.get(table, -1) + 1
                table = (*table, counts[table])
            yield table, number
        elif key := _KEY.match(line):
            yield (*table, *_split(key[1])), number


def _split(key: str) -> KeyPath:
    return tuple(part.strip().strip("\"'") for part in key.split("."))


def _shown(value: object) -> str:
    """A value as TOML spells it, cut short."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, int) and abs(value) > 10**20:
        text = "a very large number"
    elif isinstance(value, Mapping):
        text = "a table"
    elif isinstance(value, str):
        text = '"' + value.encode("unicode_escape").decode() + '"'
    elif isinstance(value, list | tuple):
        text = repr(list(value))
    else:
        text = str(value)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."
