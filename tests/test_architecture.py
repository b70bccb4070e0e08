"""Who may import what, and how long a module may be, whatever the import linter is set to."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
MODULES = sorted(
    path
    for package in ("planners", "sim_vehicles", "uavbridge")
    for path in (ROOT / package).rglob("*.py")
)
LONGEST_MODULE = 500

# Where alone something may be imported: paths or folders.
ONLY_IN = {
    "zenoh": ("uavbridge/bus/zenoh_bus.py",),
    "pymavlink": ("sim_vehicles/codec/",),
    "time": ("uavbridge/clock.py", "sim_vehicles/clock.py"),
    "datetime": ("uavbridge/clock.py",),
    "random": (),
}
PURE = {
    "__future__", "abc", "bisect", "collections", "copy", "dataclasses", "enum", "functools",
    "heapq", "itertools", "json", "math", "numpy", "operator", "planners", "re", "string", "struct",
    "types", "typing",
}  # fmt: skip
GEOMETRY = ("planners.grid", "planners.terrain", "planners.paths")


def imports(source: str) -> Iterator[str]:
    """Full names that a module imports, wherever in it."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield node.module or ""
            if node.module in ("planners", "uavbridge", "sim_vehicles"):
                yield from (f"{node.module}.{alias.name}" for alias in node.names)


def faults(path: str, source: str) -> list[str]:
    """Imports that a module at ``path`` must not have."""
    found = []
    for name in imports(source):
        top = name.split(".")[0]
        if top in ONLY_IN and not path.startswith(ONLY_IN[top]):
            found.append(f"{path} imports {name}")
        if path.startswith("planners/") and top not in PURE:
            found.append(f"{path} imports {name}: planners are pure")
        if path.startswith("sim_vehicles/"):
            if top == "uavbridge":
                found.append(f"{path} imports {name}: the simulator stands alone")
            if top == "planners" and name != "planners" and not name.startswith(GEOMETRY):
                found.append(f"{path} imports {name}: only geometry is shared")
    return found


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def test_there_are_modules() -> None:
    assert len(MODULES) > 20


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_module(path: Path) -> None:
    source = path.read_text()
    assert not faults(name_of(path), source)
    assert source.count("\n") <= LONGEST_MODULE


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("uavbridge/agent/agent.py", "import zenoh"),
        ("uavbridge/bus/local.py", "from zenoh import Config"),
        ("uavbridge/mavlink/udp.py", "from pymavlink.dialects.v20 import common"),
        ("sim_vehicles/fleet.py", "def f():\n    import time"),
        ("sim_vehicles/fleet.py", "from random import random"),
        ("sim_vehicles/fleet.py", "from planners.belief import bayes"),
        ("sim_vehicles/fleet.py", "from planners import belief"),
        ("sim_vehicles/fleet.py", "from uavbridge.clock import to_us"),
        ("planners/grid.py", "import socket"),
        ("planners/grid.py", "import logging"),
        ("planners/grid.py", "from uavbridge import rng"),
    ],
)
def test_a_wrong_import_is_found(path: str, line: str) -> None:
    assert faults(path, line + "\n")


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("uavbridge/bus/zenoh_bus.py", "import zenoh"),
        ("sim_vehicles/codec/tables.py", "from pymavlink.dialects.v20 import common"),
        ("sim_vehicles/world/targets.py", "from planners.grid import Grid"),
        ("sim_vehicles/world/targets.py", "from planners import grid"),
        ("uavbridge/clock.py", "import time"),
    ],
)
def test_a_right_import_is_not(path: str, line: str) -> None:
    assert not faults(path, line + "\n")
