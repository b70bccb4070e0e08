"""Shao 2020, section 3: a leader brings the rest to the region, then all detect and revisit."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from planners.pheromone import DetectRule, FieldLaw, PathLaw
from planners.planner import param
from planners.types import F64, I64, Bools
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples, generators
from uavbridge.experiments.shao import detect, ground
from uavbridge.experiments.shao.ground import Ground
from uavbridge.experiments.shao.journey import Journey, travel
from uavbridge.experiments.shao.navigate import CLEARING
from uavbridge.experiments.shao.world import NEVER, State, World, simulate

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class ScenarioParams:
    """Tables 1 and 2, and what the paper leaves open."""

    size: int = param(100, unit="cells", doc="P = Q, side of the whole map", low=20, high=1000)
    region: int = param(50, unit="cells", doc="M = N, side of the target region", low=5, high=500)
    targets: int = param(5, unit="1", doc="TarN, targets in the region", low=1, high=200)
    period: int = param(500, unit="steps", doc="T, revisit period", low=1)
    steps: int = param(3000, unit="steps", doc="N_c of the detection", low=1, high=100_000)
    travel_steps: int = param(500, unit="steps", doc="N_c of the navigation", low=1, high=100_000)
    corner: int = param(3, unit="cells", doc="start from the south-western corner", low=0, high=50)
    uavs: str = param("2,4,8,12", unit="-", doc="leader and followers, by commas; not given")
    obstacles: float = param(
        0.05, unit="1", doc="share of obstacle cells; not given", low=0.0, high=0.4
    )
    random_share: float = param(
        0.2, unit="1", doc="chance of being in the random group; not given", low=0.0, high=1.0
    )
    recovery: float = param(
        0.0, unit="1/step", doc="path pheromone that comes back; 0 as printed", low=0.0
    )

    @property
    def world(self) -> World:
        """Of the detection."""
        law = FieldLaw(path=PathLaw(recovery=self.recovery))
        return World(self.period, law=law, rule=DetectRule(random_share=self.random_share))


def cases(params: ScenarioParams) -> list[Case]:
    """Sizes of the team. Raises ValueError when the region does not fit on the map."""
    if params.region + params.corner + 2 * CLEARING > params.size:
        raise ValueError(f"region must leave room for the start, not {params.region}")
    return [{"n_uav": n} for n in detect.numbers("uavs", params.uavs, int, 2)]


def course(params: ScenarioParams, n: int, draws: list[Any]) -> tuple[Bools, I64, F64]:
    """Obstacles (r, size, size), targets (r, T, 2) in the region's cells, starts (r, n, 2)."""
    obstacles, targets, starts = [], [], []
    for draw in draws:
        made = ground.draw([draw], params.size, 1, 1, params.obstacles, "anywhere").obstacles[0]
        clear = params.corner + CLEARING
        made[:clear, :clear] = False
        region = made[-params.region :, -params.region :]
        middle = params.region // 2
        region[middle - 2 : middle + 3, middle - 2 : middle + 3] = False
        region |= ~ground.reached(~region)
        free = np.argwhere(~region)
        obstacles.append(made)
        targets.append(free[draw.choice(len(free), params.targets, replace=False)])
        starts.append(draw.uniform(0.0, clear - 1.0, (n, 2)))
    return np.stack(obstacles), np.stack(targets), np.stack(starts)


def simulate_case(case: Case, params: ScenarioParams, seeds: I64, fidelity: str) -> Samples:
    """Steps until the group is there, and until all targets are found and revisited."""
    draws = generators(seeds)
    n = int(case["n_uav"])
    obstacles, targets, starts = course(params, n, draws)
    there, places = _journey(obstacles, starts, params)
    state, revisited = _detection(obstacles, targets, places, draws, params)
    arrived = there >= 0
    found = arrived & (state.found_at != NEVER).all(axis=1)
    waits = detect.responses(state, len(seeds))
    middle = params.size - params.region + params.region // 2
    apart = np.hypot(*(places - middle).transpose(2, 0, 1)).max(axis=1)
    return {
        "steps_there": np.where(arrived, there, np.nan).astype(np.float64),
        "group_radius": np.where(arrived, apart, np.nan),
        "steps_all_found": np.where(found, there + state.found_at.max(axis=1), np.nan),
        "steps_all_revisited": np.where(
            arrived & (revisited >= 0).all(axis=1), there + revisited.max(axis=1), np.nan
        ),
        "revisit_response": np.array([np.mean(one) if one else np.nan for one in waits]),
        "revisits": np.array([float(len(one)) for one in waits]),
    }


def _journey(obstacles: Bools, starts: F64, params: ScenarioParams) -> tuple[I64, F64]:
    """When (r,) leaders arrive, -1: never, and where (r, n, 2) everybody is then."""
    middle = params.size - params.region + params.region // 2
    goal = np.full((len(starts), 2), middle)
    places = starts.copy()
    journey = Journey()
    leaders = np.full((len(starts), 2), float(params.corner))
    there = np.full(len(starts), NEVER)
    for state in travel(obstacles, leaders, goal, starts[:, 1:], journey, params.travel_steps):
        going = (there < 0)[:, None, None]
        now = np.concatenate((state.leader[:, None], state.position), axis=1)
        places, there = np.where(going, now, places), state.arrived_at.copy()
    return there, places


def _detection(
    obstacles: Bools, targets: I64, places: F64, draws: list[Any], params: ScenarioParams
) -> tuple[State, I64]:
    """The state after the detection, and when (r, T) each target was first revisited."""
    region = obstacles[:, -params.region :, -params.region :]
    corner = params.size - params.region
    cells = np.stack(
        [_settled(one, place - corner) for one, place in zip(region, places, strict=True)]
    )
    headings = np.stack([draw.integers(0, 8, cells.shape[1]) for draw in draws])
    made = Ground(region, targets, cells, headings)
    revisited = np.full(targets.shape[:2], NEVER)
    state: State | None = None
    known = 0
    for state in simulate(made, draws, params.world, params.steps):
        for answer in state.answered[known:]:
            first = revisited[answer.run, answer.target] == NEVER
            revisited[answer.run[first], answer.target[first]] = state.t
        known = len(state.answered)
    assert state is not None
    return dataclasses.replace(state), revisited


def _settled(obstacles: Bools, places: F64) -> I64:
    """The free cells (n, 2) nearest to places (n, 2)."""
    free = np.argwhere(~obstacles)
    apart = places[:, None] - free
    return np.asarray(free[np.hypot(apart[..., 0], apart[..., 1]).argmin(axis=1)])


def plot(figure: Figure, outcome: Outcome) -> None:
    """Times over the number of UAVs."""
    from uavbridge.experiments.shao import plots

    plots.scenario(figure, outcome)


EXPERIMENT = Experiment(
    name="shao-scenario",
    summary="leader and followers go to the region, then all detect and revisit",
    source="Shao 2020, section 3",
    params=ScenarioParams,
    cases=cases,
    simulate=simulate_case,
    file=__file__,
    runs=20,
    block=10,
    paired=("n_uav",),
    plot=plot,
)
