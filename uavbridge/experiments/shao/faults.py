"""UAVs that fail in mid-mission, pheromones against fixed routes: Shao 2020's claim, measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.planner import param
from planners.types import I64
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples
from uavbridge.experiments.shao import detect, ground, sweeps
from uavbridge.experiments.shao.detect import DetectParams
from uavbridge.experiments.shao.ground import Ground
from uavbridge.experiments.shao.world import NEVER, simulate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEARCHES = ("pheromones", "routes")
KEPT = (
    "steps_all_found",
    "targets_found",
    "revisit_response",
    "revisits",
    "unanswered",
    "coverage",
)


@dataclass(frozen=True, slots=True)
class FaultParams(DetectParams):
    """Those of the small map, and the failures."""

    swept_uavs: int = param(8, unit="1", doc="UAVs of a team", low=1, high=500)
    failures: str = param("0,2,4,6", unit="-", doc="UAVs that fail, by commas")
    fail_from: int = param(5, unit="steps", doc="earliest failure", low=0)
    fail_to: int = param(50, unit="steps", doc="latest failure", low=0)


def cases(params: FaultParams) -> list[Case]:
    """Both searches with each number of failures. Raises ValueError when more fail than fly."""
    counts = detect.numbers("failures", params.failures, int, 0)
    if max(counts) > params.swept_uavs or params.fail_to < params.fail_from:
        raise ValueError("failures must be at most swept_uavs, and fail_to at least fail_from")
    return [{"search": search, "failed": count} for search in SEARCHES for count in counts]


def failing(case: Case, params: FaultParams, seeds: I64) -> I64:
    """When (runs, n) each UAV is out of service, NEVER: it stays."""
    fails = np.full((len(seeds), params.swept_uavs), NEVER, dtype=np.int64)
    for row, seed in zip(fails, seeds.tolist(), strict=True):
        draw = np.random.default_rng([seed, 1])
        who = draw.permutation(len(row))[: int(case["failed"])]
        row[who] = draw.integers(params.fail_from, params.fail_to + 1, len(row))[who]
    return fails


def simulate_case(case: Case, params: FaultParams, seeds: I64, fidelity: str) -> Samples:
    """What was found, seen and revisited in the end."""
    fails = failing(case, params, seeds)
    made, draws = detect.layout({"n_uav": params.swept_uavs}, params, seeds)
    if case["search"] == "routes":
        return _kept(_routes(made, fails, params))
    *_, state = simulate(made, draws, params.world, params.steps, fails)
    covered = ground.shares(state.seen & ~made.obstacles)[:, None]
    waits = detect.responses(state, len(seeds))
    open_ = (state.due_at != NEVER).sum(axis=1)
    return _kept(detect.figures(covered, state.found_at, waits, open_))


def _routes(made: Ground, fails: I64, params: FaultParams) -> Samples:
    track = sweeps.tracks(made, params.swept_uavs, params.lane, params.steps)
    step = np.arange(params.steps + 1)[:, None]
    alive = (fails[:, None] == NEVER) | (step < fails[:, None])
    parts = [
        sweeps.visits(sweeps.in_range(one, targets, params.sensor, up), params.period)
        for one, targets, up in zip(track, made.targets, alive, strict=True)
    ]
    covered = sweeps.coverage(made, track, params.sensor, (params.steps,), alive)
    found = np.stack([part[0] for part in parts])
    waiting = np.array([part[2] for part in parts])
    return detect.figures(covered, found, [part[1] for part in parts], waiting)


def _kept(samples: Samples) -> Samples:
    return {name: samples[name] for name in KEPT}


def plot(figure: Figure, outcome: Outcome) -> None:
    """Figures over the number of failures."""
    from uavbridge.experiments.shao import plots

    plots.faults(figure, outcome)


EXPERIMENT = Experiment(
    name="shao-faults",
    summary="UAVs that fail in mid-mission, pheromones against fixed routes",
    source="Shao 2020, section 4.3.3, measured",
    params=FaultParams,
    cases=cases,
    simulate=simulate_case,
    file=__file__,
    runs=20,
    block=10,
    paired=("search", "failed"),
    plot=plot,
)
