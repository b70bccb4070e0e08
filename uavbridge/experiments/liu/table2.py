"""Liu 2022, Table 2: the five methods after 200 cycles, with and without targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from planners.planner import param
from planners.types import I64
from uavbridge.experiments.experiment import FIDELITIES, READING, Case, Experiment, Outcome, Samples
from uavbridge.experiments.liu import measures, orders
from uavbridge.experiments.liu.setting import RUNS_FLOWN, LiuParams

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SWARM = ("boids", "boids-guided", "esustpm")
_GUIDED = ("boids-guided", "esustpm")
_EVERY = ("random", "mower", *_SWARM)

# Other readings, and the methods that each concerns.
SPEED = {
    "speed_reading=component": ("esustpm",),
    "speed_reading=norm": ("esustpm",),
    "speed_reading=none": ("esustpm",),
    "boids_speed_m=14.14": ("boids", "boids-guided"),
}
OTHERS = {
    "update=bayes": _EVERY,
    "update_on=cycle": _EVERY,
    "start_cells=read": _EVERY,
    "start_cells=unvisited": _EVERY,
    "turns=together": _SWARM,
    "keep=best": _GUIDED,
    "ties=lowest": _GUIDED,
    "guide_point=corner": _GUIDED,
    "guide_law=towards": ("esustpm",),
    "guide_law=away": ("esustpm",),
    "heading_noise_rad=0.0": _SWARM,
    "escape_ratio=0.5": _GUIDED,
    "boundary=component": _SWARM,
    "mower_starts=printed": ("mower",),
}


@dataclass(frozen=True, slots=True)
class Params(LiuParams):
    """Those of the setting, and which other readings are shown."""

    readings: str = param(
        "speed",
        unit="-",
        doc="other readings shown: of the speeds, all of them, or none",
        choices=("none", "speed", "all"),
    )


def cases(params: Params) -> list[Case]:
    """Methods with and without targets, then the other readings."""
    shown = {
        "none": {},
        "speed": SPEED,
        "all": {**SPEED, **OTHERS},
    }[params.readings]
    plain: list[Case] = [
        {"method": method, "targets": targets}
        for method in params.chosen
        for targets in (True, False)
    ]
    other: list[Case] = [
        {**case, READING: label}
        for label, methods in shown.items()
        for case in plain
        if case["method"] in methods and measures.reading(params, label) != params
    ]
    return [*plain, *other]


def simulate(case: Case, params: Params, seeds: I64, fidelity: str) -> Samples:
    """Figures at the last cycle."""
    return measures.numbers(measures.course(case, params, seeds, fidelity), params)


def remarks(outcome: Outcome) -> list[str]:
    """Where the printed order of the methods holds."""
    metrics = ("uncertainty", "visited_cells", "targets_found")
    texts = [
        orders.in_words(outcome, metric, targets)
        for metric in metrics
        for targets in (True, False)
        if targets or metric != "targets_found"
    ]
    if outcome.params.readings == "none":
        return texts
    slow = {"esustpm": "speed_reading=norm"}
    fast = dict.fromkeys(("boids", "boids-guided"), "boids_speed_m=14.14")
    return [*texts, *(orders.in_words(outcome, "uncertainty", True, who) for who in (slow, fast))]


def plot(figure: Figure, outcome: Outcome) -> None:
    """Paper and ours, method by method."""
    from uavbridge.experiments.liu import plots

    rows: Sequence[tuple[str, str]] = (
        ("visited_cells", "cells visited"),
        ("uncertainty", "uncertainty (one-sided)"),
        ("entropy", "entropy (bits, two-sided)"),
        ("targets_found", "targets found"),
    )
    plots.against_paper(figure, outcome, rows)


EXPERIMENT = Experiment(
    name="liu-table2",
    summary="cells visited, uncertainty and targets found after 200 cycles, by method",
    source="Liu 2022, Table 2",
    params=Params,
    cases=cases,
    simulate=simulate,
    file=__file__,
    fidelities=FIDELITIES,
    runs_flown=RUNS_FLOWN,
    batched=("ideal", "dynamics"),
    remarks=remarks,
    plot=plot,
)
