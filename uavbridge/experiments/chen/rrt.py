"""Chen 2023, Figs 7-8: RRT ways over terrain, before and after nodes are skipped."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.paths import rrt
from planners.paths.ground import path_gap
from planners.planner import param
from planners.types import I64
from uavbridge.experiments.chen import terrains
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples, generators

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SMOOTHINGS = ("none", "printed", "farthest")
FROM, TO = np.array((50.0, 50.0, 100.0)), np.array((5600.0, 200.0, 150.0))


@dataclass(frozen=True, slots=True)
class RrtParams:
    """Parameters of chen-rrt."""

    step_m: float = param(150.0, unit="m", doc="length of an extension", low=1.0)
    clearance_m: float = param(40.0, unit="m", doc="least height above ground", low=0.0)
    ceiling_m: float = param(300.0, unit="m", doc="largest height", low=1.0)
    goal_bias: float = param(0.0, unit="1", doc="share of samples at the goal", low=0.0, high=1.0)
    samples: int = param(6000, unit="1", doc="samples before it gives up", low=1)


def cases(params: RrtParams) -> list[Case]:
    """Every terrain with every smoothing; the same trees for all three."""
    return [{"terrain": name, "smoothing": how} for name in terrains.NAMES for how in SMOOTHINGS]


def planned(case: Case, params: RrtParams, rng: np.random.Generator) -> rrt.RrtPath | None:
    """One way of a case."""
    rules = rrt.RrtRules(
        step_m=params.step_m,
        clearance_m=params.clearance_m,
        ceiling_m=params.ceiling_m,
        goal_bias=params.goal_bias,
        nodes=params.samples,
        smoothing=str(case["smoothing"]),
    )
    return rrt.plan(terrains.terrain(str(case["terrain"])), FROM, TO, rules, rng)


def simulate(case: Case, params: RrtParams, seeds: I64, fidelity: str) -> Samples:
    """Figures of the ways; NaN where none was found."""
    ground = terrains.terrain(str(case["terrain"]))
    figures = []
    for rng in generators(seeds):
        path = planned(case, params, rng)
        if path is None:
            figures.append([0.0, *[np.nan] * 6])
            continue
        figures.append(
            [
                1.0,
                path.length,
                path.raw_length,
                len(path.points),
                len(path.raw),
                path.samples,
                path_gap(ground, path.points),
            ]
        )
    names = (
        "found",
        "length_m",
        "raw_length_m",
        "nodes",
        "raw_nodes",
        "samples",
        "min_clearance_m",
    )
    return dict(zip(names, np.array(figures, dtype=np.float64).T, strict=True))


def plot(figure: Figure, outcome: Outcome) -> None:
    """Fig. 7 from above, Fig. 8 in space: the first run over every terrain."""
    from uavbridge.experiments.chen import plots
    from uavbridge.experiments.runner import seeds_of

    ways = []
    for case, _ in outcome.samples:
        if case["smoothing"] == "farthest":
            seeds = seeds_of(outcome.experiment, case, outcome.seed, 1)
            path = planned(case, outcome.params, generators(seeds)[0])
            ways.append((str(case["terrain"]), path))
    plots.ways(figure, ways)


EXPERIMENT = Experiment(
    name="chen-rrt",
    summary="RRT ways over terrain, before and after nodes are skipped",
    source="Chen 2023, Figs 7-8",
    params=RrtParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=20,
    block=5,
    paired=("smoothing",),
    plot=plot,
)
