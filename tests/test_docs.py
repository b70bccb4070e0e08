"""The documents say what the code does."""

from __future__ import annotations

import configparser
import re
import sys
import tomllib
from importlib import util
from pathlib import Path
from types import ModuleType

import pytest
from click.testing import CliRunner

from planners import conformance
from uavbridge.cli import main

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
EXAMPLE = DOCS / "examples" / "my_planner"
PAGES = sorted([*DOCS.rglob("*.md"), ROOT / "README.md"])


def module(path: Path) -> ModuleType:
    spec = util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    loaded = util.module_from_spec(spec)
    sys.modules[path.stem] = loaded
    spec.loader.exec_module(loaded)
    return loaded


@pytest.mark.parametrize(
    "name", ["mission_file.md", "mission.schema.json", "command_line.md", "conformance.md"]
)
def test_generated_pages_are_in_step(name: str) -> None:
    pages = module(DOCS / "generate.py").pages()
    assert (DOCS / "reference" / name).read_text() == pages[name], "run make docs"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
        if "://" not in target:
            assert (page.parent / target).exists(), target


@pytest.mark.parametrize("name", conformance.CHECKS)
def test_the_example_planner_conforms(name: str) -> None:
    kind = module(EXAMPLE / "my_planner.py").KIND
    assert conformance.CHECKS[name](conformance.Trial(kind)) == []


def test_the_example_package_is_the_one_that_tests_install() -> None:
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text())["project"]
    installed = configparser.ConfigParser()
    installed.read(ROOT / "tests/plugin_package/my_planner-0.1.0.dist-info/entry_points.txt")
    group = "uavbridge.planners"
    assert dict(installed[group]) == project["entry-points"][group]


def test_the_tutorial_shows_the_example_planner() -> None:
    tutorial = (DOCS / "tutorial" / "write_your_own_planner.md").read_text()
    for name in ("my_planner.py", "pyproject.toml", "test_my_planner.py"):
        assert (EXAMPLE / name).read_text().strip() in tutorial, f"{name} has changed"


def test_the_first_flights_mission_is_understood_as_shown(tmp_path: Path) -> None:
    tutorial = (DOCS / "tutorial" / "first_flight.md").read_text()
    blocks = re.findall(r"```(\w+)\n(.*?)```", tutorial, re.DOTALL)
    mission = next(text for language, text in blocks if language == "toml")
    shown = [text for language, text in blocks if language == "text"]
    path = tmp_path / "my_mission.toml"
    path.write_text(mission)
    assert CliRunner().invoke(main, ["check", str(path)]).stdout in shown
    path.write_text(mission.replace("range_m", "rnage_m"))
    complaint = CliRunner().invoke(main, ["check", str(path)]).stderr
    assert any(complaint.replace(str(path), path.name) in text for text in shown)
