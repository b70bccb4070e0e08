"""The list of planners, for people and for programs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table

from planners.planner import PlannerKind


def as_data(planners: Mapping[str, PlannerKind]) -> list[dict[str, Any]]:
    """Planners with their parameters as plain values."""
    return [
        {
            "name": kind.name,
            "summary": kind.summary,
            "parameters": [
                {
                    "name": parameter.name,
                    "type": type(parameter.default).__name__,
                    "unit": parameter.metadata["unit"],
                    "default": parameter.default,
                    "doc": parameter.metadata["doc"],
                }
                for parameter in kind.parameters()
            ],
        }
        for kind in planners.values()
    ]


def show(planners: Mapping[str, PlannerKind]) -> None:
    """A table a planner on standard output."""
    console = Console(soft_wrap=False)
    for planner in as_data(planners):
        console.print(f"[bold]{planner['name']}[/bold]  {planner['summary']}", highlight=False)
        if planner["parameters"]:
            console.print(_parameters(planner["parameters"]))
        console.print()


def _parameters(parameters: list[dict[str, Any]]) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 2), header_style="dim")
    for heading in ("parameter", "default", "unit", "meaning"):
        table.add_column(heading, overflow="fold")
    for parameter in parameters:
        table.add_row(
            parameter["name"], str(parameter["default"]), parameter["unit"], parameter["doc"]
        )
    return table
