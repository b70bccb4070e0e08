"""Write the pages of docs/reference that follow from the code: ``make docs``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from sim_vehicles.conformance import page as conformance_page
from uavbridge.cli import main as command_line
from uavbridge.config import json_schema

REFERENCE = Path(__file__).parent / "reference"

_MISSION_INTRODUCTION = """\
# Mission file

A mission is a TOML file. Keys are strict: an unknown key, a wrong type or a value out of range is
an error that names file, line and key (`uavbridge check FILE` finds them all without flying, one
at a time). `uavbridge schema` prints the JSON schema, also kept as
[mission.schema.json](mission.schema.json); an editor that knows TOML schemas (taplo, Even Better
TOML) completes and checks with it when the file begins with

    #:schema https://.../mission.schema.json

Only `name` and `[area]` must be there. Lengths are metres, times seconds, positions `[x, y]` metres
east and north of `[home]`, heights above home, or above the ground where there is `[terrain]`.
Numbers may be written as whole numbers.

- The options of `uavbridge launch` replace the top-level key of the same name. With `--planner`
  naming another planner than the file does, the file's `[parameters]` are not used.
- The team has `vehicles` members. Agents listed under `[[agents]]` belong to it first; the others
  get the lowest free ids from 1. By ascending id they take the points of `fleet.starts`, unless
  `[[agents]]` gives them one; who has none is placed on a square lattice, `fleet.spacing_m` apart,
  near the others.
- Agents never see `[[targets]]`: the mission that an agent loads has none. The simulated world
  sends it sensor readings instead.
- The mission ends when every target is declared by some agent and `coverage_goal` is reached, or
  after `duration`; then all return and land.
"""


def mission_file() -> str:
    """docs/reference/mission_file.md."""
    schema = json_schema()
    tables, plain = [], {}
    for key, part in schema["properties"].items():
        inner = part.get("$ref") or part.get("items", {}).get("$ref")
        if inner is None:
            plain[key] = part
            continue
        table = schema["$defs"][inner.rsplit("/", 1)[-1]]
        header = f"[[{key}]]" if "items" in part else f"[{key}]"
        tables += [f"## {header}", table["description"], _keys(table["properties"], table)]
    top = ["## Top level", _keys(plain, schema)]
    return "\n\n".join([_MISSION_INTRODUCTION.rstrip(), *top, *tables]) + "\n"


def _keys(properties: dict[str, Any], table: dict[str, Any]) -> str:
    rows = ["| key | type | default | meaning |", "| --- | --- | --- | --- |"]
    for key, part in properties.items():
        default = f"`{json.dumps(part['default'])}`" if "default" in part else ""
        meaning = part.get("description", "").replace("|", "\\|")
        if key in table.get("required", ()):
            default = "must be given"
        rows.append(f"| `{key}` | {_type(part)} | {default} | {meaning} |")
    return "\n".join(rows)


def _type(part: dict[str, Any]) -> str:
    if "enum" in part:
        return ", ".join(f'`"{choice}"`' for choice in part["enum"])
    if "anyOf" in part:
        return " or ".join(_type(choice) for choice in part["anyOf"])
    kind = part["type"]
    if kind == "array":
        return "point" if "prefixItems" in part else "array of points"
    words = {"integer": "whole number", "boolean": "bool", "object": "table"}
    return " ".join([words.get(kind, kind), _range(part)]).strip()


def _range(part: dict[str, Any]) -> str:
    bounds = [
        f"{sign} {part[name]:.15g}"
        for name, sign in (
            ("exclusiveMinimum", ">"),
            ("minimum", "≥"),
            ("exclusiveMaximum", "<"),
            ("maximum", "≤"),
        )
        if name in part
    ]
    return ", ".join(bounds)


def command_line_page() -> str:
    """docs/reference/command_line.md."""
    context = click.Context(command_line, info_name="uavbridge")
    parts = ["# Command line", _COMMAND_INTRODUCTION.strip(), _help(context)]
    for name in command_line.list_commands(context):
        command = command_line.get_command(context, name)
        assert command is not None
        inner = click.Context(command, info_name=name, parent=context)
        parts += [f"## uavbridge {name}", _help(inner)]
    return "\n\n".join(parts) + "\n"


_COMMAND_INTRODUCTION = """
Human-readable by default; `--json` puts one JSON document on standard output and all else on
standard error. Exit status: 0 when the mission did what it was asked, 1 when it did not, 2 for bad
input. An error is one line on standard error.
"""


def _help(context: click.Context) -> str:
    context.terminal_width = 96
    return f"```text\n{context.get_help()}\n```"


def pages() -> dict[str, str]:
    """All generated pages by file name."""
    return {
        "mission_file.md": mission_file(),
        "mission.schema.json": json.dumps(json_schema(), indent=2) + "\n",
        "command_line.md": command_line_page(),
        "conformance.md": conformance_page(),
    }


if __name__ == "__main__":
    for name, text in pages().items():
        (REFERENCE / name).write_text(text)
