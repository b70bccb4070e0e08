"""Detection and revisit as an experiment: Shao 2020, Table 1 and what it leaves open, Figs 4-6."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from planners.pheromone import DetectRule, FieldLaw, PathLaw, SpreadLaw, Weights
from planners.planner import param
from planners.types import F64, I64
from uavbridge.experiments.experiment import Axis, Case, Experiment, Outcome, Samples, generators
from uavbridge.experiments.shao import ground, sweeps
from uavbridge.experiments.shao.ground import Ground
from uavbridge.experiments.shao.world import NEVER, Answer, State, World, simulate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKS = (100, 185, 500)  # steps at which coverage is told
ROUNDS = 5  # revisits of a target that are told one by one
SWEPT = ("random_share", "recovery")


@dataclass(frozen=True, slots=True)
class DetectParams:
    """Table 1, and what the paper leaves open."""

    size: int = param(50, unit="cells", doc="M = N, side of the map", low=5, high=1000)
    targets: int = param(5, unit="1", doc="TarN, targets on the map", low=1, high=200)
    period: int = param(500, unit="steps", doc="T, revisit period", low=1)
    steps: int = param(3000, unit="steps", doc="N_c, steps of a run", low=1, high=100_000)
    sensor: float = param(4.0, unit="cells", doc="SD, sensor radius", low=1.0, high=20.0)
    evaporation: float = param(0.2, unit="1", doc="E_tau and E_epsilon", low=0.0, high=1.0)
    diffusion: float = param(0.2, unit="1", doc="G_tau and G_epsilon", low=0.0, high=1.0)
    deposit: float = param(1.0, unit="1", doc="d_tau and d_epsilon", low=0.0)
    path_initial: float = param(2.0, unit="1", doc="sigma_0", low=0.001)
    path_least: float = param(0.1, unit="1", doc="sigma_min", low=0.0)
    path_reach: float = param(4.0, unit="cells", doc="D_0, range of influence", low=0.0, high=20.0)
    attenuation: float = param(1.0, unit="1", doc="Q, attenuation coefficient", low=0.001)
    target_weight: float = param(1.0, unit="1", doc="lambda_Ta", low=0.0, high=1.0)
    obstacle_weight: float = param(-0.3, unit="1", doc="lambda_Th", low=-1.0, high=0.0)
    path_weight: float = param(0.3, unit="1", doc="lambda_Tr", low=0.0, high=1.0)
    alpha: float = param(1.0, unit="1", doc="weight of pheromones, Eq. (9); not given", low=0.0)
    beta: float = param(1.0, unit="1", doc="weight of costs, Eq. (9); not given", low=0.0)
    random_share: float = param(
        0.2, unit="1", doc="chance of being in the random group; not given", low=0.0, high=1.0
    )
    recovery: float = param(
        0.0, unit="1/step", doc="path pheromone that comes back; 0 as printed", low=0.0
    )
    wear: str = param(
        "falling",
        unit="-",
        doc="Eq. (7): loss falls with the distance, or grows as printed",
        choices=("falling", "printed"),
    )
    obstacles: float = param(
        0.05, unit="1", doc="share of obstacle cells; not given", low=0.0, high=0.5
    )
    starts: str = param(
        "anywhere", unit="-", doc="where UAVs start; not given", choices=("anywhere", "corner")
    )
    uavs: str = param("1,2,4,6,8,12,16", unit="-", doc="numbers of UAVs, by commas; not given")
    swept_uavs: int = param(8, unit="1", doc="UAVs of the swept rows", low=1, high=500)
    random_shares: str = param("0,0.1,0.5,1", unit="-", doc="random shares swept, by commas")
    recoveries: str = param("0.0005,0.002,0.01", unit="-", doc="recoveries swept, by commas")
    exhaustive: bool = param(True, unit="-", doc="fly fixed routes too")

    @property
    def world(self) -> World:
        """Table 1 as the kernels want it."""
        spread = SpreadLaw(self.evaporation, self.diffusion, self.deposit)
        path = PathLaw(
            self.path_initial,
            self.path_least,
            self.path_reach,
            self.attenuation,
            self.recovery,
            self.wear,
        )
        return World(
            self.period,
            self.sensor,
            FieldLaw(spread, spread, path),
            Weights(self.target_weight, self.obstacle_weight, self.path_weight),
            DetectRule(self.alpha, self.beta, self.random_share),
        )

    @property
    def lane(self) -> int:
        """Widest lanes, in cells, that leave no cell unseen."""
        return 2 * int(self.sensor) + 1


def numbers(name: str, text: str, kind: type[Any], low: float) -> list[Any]:
    """Values by commas. Raises ValueError when one is none, or below ``low``."""
    try:
        values = [kind(word) for word in text.split(",") if word.strip()]
    except ValueError as error:
        raise ValueError(f"{name} must be numbers by commas, not {text!r}") from error
    if any(not value >= low for value in values):
        raise ValueError(f"{name} must be at least {low:g}, not {text!r}")
    return values


def cases(params: DetectParams) -> list[Case]:
    """Numbers of UAVs, then sweeps of the random share and of recovery, then fixed routes."""
    teams = numbers("uavs", params.uavs, int, 1)
    plain: list[Case] = [{"n_uav": n} for n in teams]
    n = params.swept_uavs
    shares = numbers("random_shares", params.random_shares, float, 0.0)
    if any(share > 1.0 for share in shares):
        raise ValueError(f"random_shares must be at most 1, not {params.random_shares!r}")
    plain += [{"n_uav": n, "random_share": share} for share in shares]
    recoveries = numbers("recoveries", params.recoveries, float, 0.0)
    plain += [{"n_uav": n, "recovery": recovery} for recovery in recoveries]
    if params.exhaustive:
        plain += [{"n_uav": 1, "route": lane} for lane in ("one-cell", "sensor-wide")]
        plain += [{"n_uav": n, "route": lane} for lane in ("one-cell", "sensor-wide")]
    return plain


def layout(case: Case, params: DetectParams, seeds: I64) -> tuple[Ground, list[Any]]:
    """Lattices of the runs, and generators for what happens on them."""
    draws = generators(seeds)
    n = int(case["n_uav"])
    made = ground.draw(draws, params.size, params.targets, n, params.obstacles, params.starts)
    return made, draws


def read(params: DetectParams, case: Case) -> DetectParams:
    """The parameters with those that the case sweeps."""
    return replace(
        params,
        random_share=float(case.get("random_share", params.random_share)),
        recovery=float(case.get("recovery", params.recovery)),
    )


def simulate_case(
    curve: tuple[int, ...], case: Case, params: DetectParams, seeds: I64, fidelity: str
) -> Samples:
    """All figures, and the curves at the steps ``curve``, of some runs."""
    params = read(params, case)
    made, draws = layout(case, params, seeds)
    if "route" in case:
        return _swept(curve, case, params, made)
    at = {*curve, *MARKS, params.steps}
    covered = np.full((len(seeds), params.steps + 1), np.nan)
    state: State | None = None
    for state in simulate(made, draws, params.world, params.steps):
        if state.t in at:
            covered[:, state.t] = ground.shares(state.seen & ~made.obstacles)
    assert state is not None
    waits = responses(state, len(seeds))
    rounds = _rounds(state.answered, made.targets.shape[:2])
    open_ = (state.due_at != NEVER).sum(axis=1)
    curves = _curves(covered, state.found_at, curve)
    return {**figures(covered, state.found_at, waits, open_), **curves, **rounds}


def responses(state: State, runs: int) -> list[list[int]]:
    """Steps from each signal to its answer, by run."""
    waits: list[list[int]] = [[] for _ in range(runs)]
    for answer in state.answered:
        for run, response in zip(answer.run.tolist(), answer.response.tolist(), strict=True):
            waits[run].append(response)
    return waits


def _swept(curve: tuple[int, ...], case: Case, params: DetectParams, made: Ground) -> Samples:
    """The same of fixed routes; a target counts as visited when it is in range."""
    spacing = 1 if case["route"] == "one-cell" else params.lane
    track = sweeps.tracks(made, int(case["n_uav"]), spacing, params.steps)
    at = sorted(step for step in {*curve, *MARKS, params.steps} if step <= params.steps)
    covered = np.full((len(track), params.steps + 1), np.nan)
    covered[:, at] = sweeps.coverage(made, track, params.sensor, tuple(at))
    parts = [
        sweeps.visits(sweeps.in_range(one, targets, params.sensor), params.period)
        for one, targets in zip(track, made.targets, strict=True)
    ]
    found = np.stack([part[0] for part in parts])
    waiting = np.array([part[2] for part in parts])
    told = figures(covered, found, [part[1] for part in parts], waiting)
    return {**told, **_curves(covered, found, curve)}


def figures(
    covered: F64, found_at: I64, waits: Sequence[Sequence[int]], unanswered: I64
) -> Samples:
    """Metrics of some runs.

    Args:
        covered: (runs, steps + 1) share of the cells, NaN where it was not counted.
        found_at: (runs, T) step, ``NEVER``: not found.
        waits: by run, the responses.
        unanswered: (runs,) targets that wait at the end.
    """
    found = found_at != NEVER
    return {
        "steps_all_found": np.where(found.all(axis=1), found_at.max(axis=1), np.nan),
        "targets_found": found.sum(axis=1).astype(np.float64),
        "revisit_response": np.array([np.mean(one) if len(one) else np.nan for one in waits]),
        "revisits": np.array([float(len(one)) for one in waits]),
        "unanswered": unanswered.astype(np.float64),
        **{f"coverage_at_{step}": _at(covered, step) for step in MARKS},
        "coverage": covered[:, -1],
    }


def _curves(covered: F64, found_at: I64, curve: tuple[int, ...]) -> Samples:
    """Targets found and coverage at the steps ``curve``; NaN beyond the last step."""
    found = found_at != NEVER
    acquired = ((found_at[:, :, None] <= curve) & found[:, :, None]).sum(axis=1) * 1.0
    acquired[:, np.array(curve) >= covered.shape[1]] = np.nan
    return {
        "acquired@step": acquired,
        "covered@step": np.stack([_at(covered, step) for step in curve], axis=1),
    }


def _at(covered: F64, step: int) -> F64:
    return covered[:, step] if step < covered.shape[1] else np.full(len(covered), np.nan)


def _rounds(answered: Sequence[Answer], shape: tuple[int, ...]) -> Samples:
    """Mean response (runs,) over the targets of a run to their first, second, ... revisit."""
    count = np.zeros(shape, np.int64)
    total, seen = np.zeros((ROUNDS, shape[0])), np.zeros((ROUNDS, shape[0]))
    for answer in answered:
        number = count[answer.run, answer.target]
        count[answer.run, answer.target] += 1
        for place, run, response in zip(
            number.tolist(), answer.run.tolist(), answer.response.tolist(), strict=True
        ):
            if place < ROUNDS:
                total[place, run] += response
                seen[place, run] += 1
    mean = np.where(seen > 0, total / np.maximum(seen, 1), np.nan)
    return {f"response_{place + 1}": mean[place] for place in range(ROUNDS)}


def remarks(outcome: Outcome) -> list[str]:
    """What the paper prints that belongs to no number of UAVs."""
    rows = [row for row in outcome.rows if row.metric == "steps_all_found" and row.mean is not None]
    fleets = [row for row in rows if set(row.case) == {"n_uav"}]
    if not fleets or outcome.params.size != 50:
        return []
    near = min(fleets, key=lambda row: abs((row.mean or 0.0) - 185.0))
    return [
        "The printed run has all five targets at step 185 (Fig. 7); of these teams "
        f"{near.case['n_uav']} UAVs come nearest, with {near.mean:.0f} on average."
    ]


def plot(figure: Figure, outcome: Outcome) -> None:
    """Figs 4-6."""
    from uavbridge.experiments.shao import plots

    plots.detection(figure, outcome)


def experiment(
    name: str, size: int, params: type[Any], file: str, curve: tuple[int, ...]
) -> Experiment:
    """Detection on one size of map as an experiment; its curves are told at the steps ``curve``."""
    return Experiment(
        name=name,
        summary=f"targets found, revisits and coverage on {size} x {size} cells, by team",
        source="Shao 2020, Figs 4-6",
        params=params,
        cases=cases,
        simulate=partial(simulate_case, curve),
        file=file,
        runs=10,
        block=10,
        paired=("n_uav", *SWEPT, "route"),
        axis=Axis("step", curve),
        remarks=remarks,
        plot=plot,
    )
