"""Shao 2020, Fig. 7: routes and pheromone maps of one run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.pheromone import Field
from planners.planner import param
from planners.types import F64, I64, Bools
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples
from uavbridge.experiments.shao import detect
from uavbridge.experiments.shao.detect import DetectParams
from uavbridge.experiments.shao.ground import Ground
from uavbridge.experiments.shao.world import NEVER, simulate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN_STEP = 670  # Figs 7(c) and 7(d)


@dataclass(frozen=True, slots=True)
class MapsParams(DetectParams):
    """Those of the small map, and one team."""

    steps: int = param(1000, unit="steps", doc="N_c, steps of a run", low=1, high=100_000)
    swept_uavs: int = param(4, unit="1", doc="UAVs; not given", low=1, high=500)


@dataclass(frozen=True, slots=True, eq=False)
class Pictures:
    """What Fig. 7 shows of the first of some runs."""

    ground: Ground
    routes: I64  # (steps, n, 2) until all targets were found
    path: F64  # (columns, rows) path pheromone then
    late: Field  # at step 670, or the last
    signals: I64  # (runs,) targets that wait for a visit then
    found_at: I64  # (runs, T)
    on_routes: F64  # (runs,) mean path pheromone where a UAV has been when all were found
    elsewhere: F64  # (runs,) and where none has been


def take(case: Case, params: DetectParams, seeds: I64) -> Pictures:
    """Runs of a team, and what their maps hold."""
    made, draws = detect.layout(case, params, seeds)
    routes: list[I64] = []
    path = np.zeros(made.obstacles.shape)
    been = np.zeros(made.obstacles.shape, np.bool_)
    at_found = been.copy()
    settled = np.zeros(len(seeds), np.bool_)
    runs = np.arange(len(seeds))[:, None]
    late, signals = None, np.zeros(len(seeds), np.int64)
    for state in simulate(made, draws, params.world, params.steps):
        if not settled[0]:
            routes.append(state.cells[0])
        been[runs, state.cells[..., 0], state.cells[..., 1]] = True
        done = (state.found_at != NEVER).all(axis=1) & ~settled
        if done.any() or state.t == params.steps:
            rows: Bools = done | ((state.t == params.steps) & ~settled)
            path[rows], at_found[rows] = state.field.path[rows], been[rows]
            settled |= rows
        if state.t == min(SHOWN_STEP, params.steps):
            one = state.field
            late = Field(one.target[0], one.obstacle[0], one.path[0])
            signals = (state.due_at != NEVER).sum(axis=1)
    assert late is not None
    means = [
        (np.where(where, path, 0.0).sum(axis=(1, 2)) / np.maximum(where.sum(axis=(1, 2)), 1))
        for where in (at_found, ~at_found)
    ]
    return Pictures(made, np.stack(routes), path[0], late, signals, state.found_at, *means)


def cases(params: MapsParams) -> list[Case]:
    """One team."""
    return [{"n_uav": params.swept_uavs}]


def simulate_case(case: Case, params: MapsParams, seeds: I64, fidelity: str) -> Samples:
    """When all were found, signals at step 670, path pheromone on the routes and elsewhere."""
    shown = take(case, params, seeds)
    found = (shown.found_at != NEVER).all(axis=1)
    return {
        "steps_all_found": np.where(found, shown.found_at.max(axis=1), np.nan),
        f"signals_at_{SHOWN_STEP}": shown.signals.astype(np.float64),
        "path_on_routes": shown.on_routes,
        "path_elsewhere": shown.elsewhere,
    }


def plot(figure: Figure, outcome: Outcome) -> None:
    """Fig. 7, of the first run."""
    from uavbridge.experiments.shao import plots

    plots.maps(figure, outcome)


EXPERIMENT = Experiment(
    name="shao-maps",
    summary="routes, and path, target and combined pheromone maps",
    source="Shao 2020, Fig. 7",
    params=MapsParams,
    cases=cases,
    simulate=simulate_case,
    file=__file__,
    runs=1,
    block=10,
    paired=("n_uav",),
    plot=plot,
)
