"""Every planner has a page with its parameters, and a module that says what stands for what."""

import sys
from pathlib import Path

import pytest

from planners.registry import BUILTIN, describe

DOCS = Path(__file__).parents[2] / "docs" / "planners"
PAGES = {"boids-guided": "boids", "pheromone-scenario": "pheromone"}


@pytest.mark.parametrize("name", BUILTIN)
def test_the_page_lists_the_parameters_as_they_are(name):
    page = (DOCS / f"{PAGES.get(name, name)}.md").read_text()
    for row in describe(BUILTIN[name]):
        default = f'"{row.default}"' if isinstance(row.default, str) else str(row.default)
        line = f"| `{row.name}` | `{default}` | {row.unit} | {row.allowed} | {row.doc} |"
        assert line in page, "the page is out of step"


@pytest.mark.parametrize("name", BUILTIN)
def test_the_module_says_which_symbol_is_which_name(name):
    module = sys.modules[BUILTIN[name].params.__module__]
    assert "| symbol | name |" in module.__doc__
    assert any(f" {year}" in module.__doc__ for year in (2014, 2020, 2022, 2023))


def test_the_checks_are_all_explained():
    from planners.conformance import CHECKS

    page = (DOCS / "index.md").read_text()
    assert all(f"`{name}`" in page for name in CHECKS)
