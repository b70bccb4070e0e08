"""A moving target, which Khan 2014 leaves to future work: the strategies as they are.

The target steps to one of the four cells beside it with the chance ``speed``
each time step. The paper's maps believe that it stays; ``forget`` lets what was
seen fade, and is the other reading shown. An error is a cell that the target is
not in when it is named; a search is given up after ``steps_most``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from planners.planner import param
from planners.types import I64
from uavbridge.experiments.experiment import READING, Case, Experiment, Outcome, Samples
from uavbridge.experiments.khan import study
from uavbridge.experiments.khan.choices import KhanParams
from uavbridge.experiments.khan.teams import team_of
from uavbridge.experiments.khan.world import search

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPEEDS = (0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2)


@dataclass(frozen=True, slots=True)
class Params(study.StudyParams):
    """Those of all figures, the team, and when a search is given up."""

    uavs: int = param(5, unit="1", doc="N", low=1, high=50)
    range_cells: int = param(6, unit="cells", doc="communication range", low=0)
    steps_most: int = param(1000, unit="steps", doc="a run ends then", low=1, high=100000)
    faded: float = param(
        0.01, unit="1", doc="forget, in the other reading; 0: none", low=0.0, high=0.999
    )


def cases(params: Params) -> list[Case]:
    """A case a speed and rule."""
    plain = study.cases(
        params, (params.uavs,), (params.range_cells,), [{"speed": speed} for speed in SPEEDS]
    )
    if not params.faded:
        return plain
    label = f"forget={params.faded:g}"
    return [*plain, *({**case, READING: label} for case in plain if READING not in case)]


def simulate(case: Case, params: Params, seeds: I64, fidelity: str) -> Samples:
    """Steps, errors, and how far the target was from the cell named."""
    label = str(case.get(READING, ""))
    if label.startswith("forget="):
        setting: KhanParams = replace(params, forget=params.faded)
    else:
        setting = study.setting_of(case, params)
    uavs = int(case["N"])
    team = team_of(str(case["rule"]), setting, len(seeds), uavs)
    fates = search(team, setting, uavs, float(case["range"]), seeds, chance=float(case["speed"]))
    named = fates.cell >= 0
    offset = np.array(np.divmod(fates.cell, setting.rows)) - np.divmod(fates.target, setting.rows)
    return {
        **study.metrics(fates),
        "named_percent": np.where(named, 100.0, 0.0),
        "distance_cells": np.where(named, np.hypot(offset[0], offset[1]), np.nan),
    }


def plot(figure: Figure, outcome: Outcome) -> None:
    """Steps, errors and distance over the target's speed."""
    from uavbridge.experiments.khan import plots

    shown = ("steps", "error_percent", "distance_cells")
    plots.against(figure, outcome, "speed", "chance of a step of the target", shown)


EXPERIMENT = Experiment(
    name="khan-moving",
    summary="steps and errors when the target moves",
    source="Khan 2014, future work",
    params=Params,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=300,
    block=150,
    paired=(*study.PAIRED, "speed"),
    derive=study.gains,
    plot=plot,
)
