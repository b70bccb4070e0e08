"""Zhou 2023, Figs 5 and 6: one run on each terrain, its tracks and suballiances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.terrain import Terrain, steep_share
from planners.types import F64, I64
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples
from uavbridge.experiments.runner import seeds_of
from uavbridge.experiments.zhou import setting
from uavbridge.experiments.zhou.setting import ZhouParams
from uavbridge.experiments.zhou.world import simulate as states

if TYPE_CHECKING:
    from matplotlib.figure import Figure

N_U = 40


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """One run, step by step."""

    terrain: Terrain
    targets: F64  # (T, 2) m
    tracks: F64  # (steps, n, 3) m
    task: I64  # (steps, n) target that each works for as a member, -1: none
    first: I64  # (steps, n) 1: class I
    reached_at: I64  # (T,) step, -1: never
    reached_by: I64  # (T,) robot


def cases(params: ZhouParams) -> list[Case]:
    """Fig. 5 (slopes up to beta) and Fig. 6 (up to alpha)."""
    return [{"table": table, "n_u": N_U} for table in sorted(setting.SLOPES)]


def trace(case: Case, params: ZhouParams, seed: int) -> Trace:
    """The run of a seed."""
    terrain, draws, starts, targets = setting.course(case, params, np.array([seed]))
    run = list(states(terrain, starts, targets, draws, params.planner, params.world))
    member = [np.where(one.robots.member[0], one.robots.told.task[0], -1) for one in run]
    return Trace(
        terrain,
        targets[0],
        np.stack([one.position[0] for one in run]),
        np.stack(member),
        np.stack([one.robots.told.first[0].astype(np.int64) for one in run]),
        run[-1].reached_at[0],
        run[-1].reached_by[0],
    )


def simulate(case: Case, params: ZhouParams, seeds: I64, fidelity: str) -> Samples:
    """Steps and energy, how many worked as members at once, and how steep the ground is."""
    samples = dict(setting.measure(case, params, seeds, fidelity))
    traces = [trace(case, params, int(seed)) for seed in seeds]
    most = [max(np.bincount(row[row >= 0], minlength=1).max() for row in t.task) for t in traces]
    samples["most_members"] = np.array(most, dtype=np.float64)
    beta = params.planner.climb_rad + 1e-9
    samples["share_above_beta"] = np.array([steep_share(t.terrain, beta) for t in traces])
    return samples


def plot(figure: Figure, outcome: Outcome) -> None:
    """Terrain, zone above beta, tracks; one suballiance; members by target over time."""
    from uavbridge.experiments.zhou import tracks

    runs = []
    for case in cases(outcome.params):
        seed = int(seeds_of(outcome.experiment, case, outcome.seed, 1)[0])
        runs.append(trace(case, outcome.params, seed))
    tracks.draw(figure, runs, outcome.params.planner.climb_rad)


EXPERIMENT = Experiment(
    name="zhou-trace",
    summary="one run on each terrain: tracks, suballiances, slopes above beta",
    source="Zhou 2023, Figs 5, 6",
    params=ZhouParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=1,
    block=1,
    plot=plot,
)
