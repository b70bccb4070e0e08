"""The lists of planners and of experiments, for people and for programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from planners.planner import PlannerKind
from planners.registry import Parameter, describe, described
from uavbridge.experiments.experiment import Experiment


def as_data(planners: Mapping[str, PlannerKind]) -> list[dict[str, Any]]:
    """Planners with their parameters as plain values."""
    return [
        {
            "name": kind.name,
            "summary": kind.summary,
            "parameters": [_described(parameter) for parameter in describe(kind)],
        }
        for kind in planners.values()
    ]


def experiments_as_data(experiments: Sequence[Experiment]) -> list[dict[str, Any]]:
    """Experiments with their parameters as plain values."""
    return [
        {
            "name": one.name,
            "summary": one.summary,
            "source": one.source,
            "runs": one.runs,
            "fidelities": list(one.fidelities),
            "parameters": [_described(parameter) for parameter in described(one.params)],
        }
        for one in experiments
    ]


def show_experiments(experiments: Sequence[Experiment]) -> None:
    """A line an experiment on standard output."""
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="dim")
    for heading in ("experiment", "source", "fidelities"):
        table.add_column(heading, no_wrap=True)
    table.add_column("what", overflow="fold")
    for one in experiments:
        table.add_row(one.name, one.source, ", ".join(one.fidelities), one.summary)
    Console(markup=False, highlight=False).print(table)


def _described(parameter: Parameter) -> dict[str, Any]:
    return {
        "name": parameter.name,
        "type": parameter.kind.__name__,
        "unit": parameter.unit,
        "default": parameter.default,
        "allowed": parameter.allowed,
        "doc": parameter.doc,
    }


def show(planners: Mapping[str, PlannerKind]) -> None:
    """A table a planner on standard output."""
    console = Console(markup=False, highlight=False)
    for planner in as_data(planners):
        console.print(Text.assemble((planner["name"], "bold"), "  ", planner["summary"]))
        if planner["parameters"]:
            console.print(_parameters(planner["parameters"]))
        console.print()


def _parameters(parameters: list[dict[str, Any]]) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 2), header_style="dim")
    for heading in ("parameter", "default", "unit"):
        table.add_column(heading, no_wrap=True)
    table.add_column("meaning", overflow="fold")
    for parameter in parameters:
        allowed = f" ({parameter['allowed']})" if parameter["allowed"] else ""
        cells = (parameter["name"], parameter["default"], parameter["unit"])
        table.add_row(*map(str, cells), f"{parameter['doc']}{allowed}")
    return table
