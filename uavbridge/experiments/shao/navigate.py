"""Shao 2020, Figs 9 and 10: a leader by vector or scalar pheromones, and its followers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.pheromone import FieldLaw, SpreadLaw
from planners.pheromone.follow import FollowLaw
from planners.pheromone.lead import cell_of
from planners.planner import param
from planners.types import F64, I64, Bools
from uavbridge.experiments.experiment import (
    READING,
    Case,
    Experiment,
    Outcome,
    Samples,
    generators,
)
from uavbridge.experiments.shao import ground
from uavbridge.experiments.shao.journey import LEADERS, Flock, Journey, travel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CLEARING = 6  # cells around start and goal without obstacles
READINGS = ("radius=10",)


@dataclass(frozen=True, slots=True)
class NavigateParams:
    """Table 2, and what the paper leaves open."""

    size: int = param(101, unit="cells", doc="P = Q, side of the map", low=20, high=1000)
    steps: int = param(500, unit="steps", doc="N_c", low=1, high=100_000)
    sensor: float = param(5.0, unit="cells", doc="sensorLD, of the leader", low=1.0, high=20.0)
    length: float = param(2.0, unit="cells", doc="rho, step of the leader", low=0.1, high=4.0)
    epsilon: float = param(0.1, unit="1", doc="of the sigma norm", low=0.001, high=0.999)
    h: float = param(0.5, unit="1", doc="of the bump function", low=0.0, high=0.999)
    c1: float = param(0.6, unit="1", doc="pull to the leader", low=0.0)
    c2: float = param(0.4, unit="1", doc="to the leader's velocity", low=0.0)
    evaporation: float = param(0.2, unit="1", doc="E_tau", low=0.0, high=1.0)
    diffusion: float = param(0.2, unit="1", doc="G_tau", low=0.0, high=1.0)
    corner: int = param(
        3, unit="cells", doc="start and goal from their corners; not given", low=0, high=50
    )
    obstacles: float = param(
        0.05, unit="1", doc="share of obstacle cells; not given", low=0.0, high=0.4
    )
    sense: str = param(
        "log",
        unit="-",
        doc="the leader senses target pheromone's logarithm, or the field itself",
        choices=("log", "field"),
    )
    scale: float = param(0.1, unit="1", doc="of target pheromone as it is sensed", low=0.0)
    before: int = param(
        300, unit="steps", doc="that the field has to spread before the start", low=0
    )
    followers: int = param(6, unit="1", doc="of the leader; not given", low=1, high=200)
    radius: float = param(5.0, unit="cells", doc="r of Eq. (17); not given", low=0.1)

    def journey(self, leader: str, form: str, radius: float) -> Journey:
        """As the kernels want it."""
        law = FieldLaw(target=SpreadLaw(self.evaporation, self.diffusion))
        follow = FollowLaw(radius, self.epsilon, self.h, self.c1, self.c2, form)
        return Journey(
            leader,
            self.sensor,
            self.length,
            law,
            scale=self.scale,
            log=self.sense == "log",
            before=self.before,
            follow=follow,
        )


def cases(params: NavigateParams) -> list[Case]:
    """Leaders, then followers of the vector leader in both forms and with both radii."""
    leaders: list[Case] = [{"leader": leader} for leader in LEADERS]
    forms: list[Case] = [{"form": form} for form in ("printed", "working")]
    return [*leaders, *forms, *({**case, READING: text} for text in READINGS for case in forms)]


def course(params: NavigateParams, seeds: I64) -> tuple[Bools, F64, I64, F64]:
    """Obstacles, starts, goals, and places of the followers."""
    size, corner = params.size, params.corner
    if size - 1 - corner <= corner:
        raise ValueError(f"corner must be below half the map's size, not {corner}")
    obstacles, places = [], []
    for draw in generators(seeds):
        made = ground.draw([draw], size, 1, 1, params.obstacles, "anywhere").obstacles[0]
        made[: corner + CLEARING, : corner + CLEARING] = False
        made[size - corner - CLEARING :, size - corner - CLEARING :] = False
        obstacles.append(made)
        places.append(draw.uniform(0.0, corner + CLEARING - 1.0, (params.followers, 2)))
    start = np.full((len(seeds), 2), float(corner))
    goal = np.full((len(seeds), 2), size - 1 - corner)
    return np.stack(obstacles), start, goal, np.stack(places)


def simulate(case: Case, params: NavigateParams, seeds: I64, fidelity: str) -> Samples:
    """Iterations until the leader is there, and how the followers kept."""
    obstacles, start, goal, places = course(params, seeds)
    label = str(case.get(READING, ""))
    radius = float(label.partition("=")[2]) if label else params.radius
    form = str(case.get("form", "working"))
    journey = params.journey(str(case.get("leader", "vector")), form, radius)
    watch = Watch(obstacles)
    state: Flock | None = None
    for state in travel(obstacles, start, goal, places, journey, params.steps):
        watch.add(state)
    assert state is not None
    arrived = state.arrived_at >= 0
    if "leader" in case:
        return {
            "iterations": np.where(arrived, state.arrived_at, np.nan).astype(np.float64),
            "arrived": arrived.astype(np.float64),
            "way": watch.way,
        }
    return watch.figures()


class Watch:
    """Figures of the flocks over the second half of their way."""

    def __init__(self, obstacles: Bools) -> None:
        self.way: F64 = np.zeros(len(obstacles))
        self._obstacles = obstacles
        self._rows: list[dict[str, F64]] = []

    def add(self, state: Flock) -> None:
        """One step; runs that have arrived are left out."""
        going = (state.arrived_at < 0) | (state.arrived_at == state.t)
        speed = np.hypot(state.leader_velocity[:, 0], state.leader_velocity[:, 1])
        self.way = self.way + np.where(going, speed, 0.0)
        values = _figures(state, self._obstacles)
        self._rows.append({key: np.where(going, part, np.nan) for key, part in values.items()})

    def figures(self) -> Samples:
        """Means over the second half of each run's way; of the nearest pair the least, too."""
        samples = {}
        for key in self._rows[0]:
            course_ = np.stack([row[key] for row in self._rows])
            steps = np.isfinite(course_).sum(axis=0)
            late = np.arange(len(course_))[:, None] >= steps // 2
            part = np.where(late & np.isfinite(course_), course_, np.nan)
            samples[key] = np.nanmean(part, axis=0)
            if key == "nearest_pair":
                samples["nearest_ever"] = np.nanmin(part, axis=0)
        return samples


def _figures(state: Flock, obstacles: Bools) -> dict[str, F64]:
    """By run: distances to the leader, between neighbours, lag behind, inside obstacles."""
    apart = state.position - state.leader[:, None]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    pairs = state.position[:, :, None] - state.position[:, None]
    between = np.hypot(pairs[..., 0], pairs[..., 1])
    n = between.shape[1]
    between = np.where(np.eye(n, dtype=np.bool_), np.inf if n > 1 else np.nan, between)
    nearest = between.min(axis=-1)
    speed = np.maximum(np.hypot(*state.leader_velocity.T), 1e-9)
    way = state.leader_velocity / speed[:, None]
    behind = -(apart.mean(axis=1) * way).sum(axis=-1)
    with np.errstate(invalid="ignore"):
        cell = cell_of(np.clip(state.position, 0.0, np.array(obstacles.shape[1:]) - 1.0))
    inside = obstacles[np.arange(len(cell))[:, None], cell[..., 0], cell[..., 1]]
    return {
        "leader_distance": distance.mean(axis=1),
        "nearest_pair": nearest.min(axis=1),
        "spacing": nearest.mean(axis=1),
        "lag": behind,
        "in_obstacles": inside.mean(axis=1).astype(np.float64),
    }


def remarks(outcome: Outcome) -> Sequence[str]:
    """The share of the gain that is the longer step."""
    means = {
        str(row.case["leader"]): row.mean
        for row in outcome.rows
        if row.metric == "iterations" and "leader" in row.case
    }
    vector, one, two = (means.get(name) for name in LEADERS)
    if vector is None or one is None or two is None:
        return []
    return [
        f"The vector leader needs {vector / one:.2f} of the steps of a scalar one that goes a cell "
        f"at a time (printed: 0.66), and {vector / two:.2f} of one with the same step."
    ]


def plot(figure: Figure, outcome: Outcome) -> None:
    """Paths of leaders and followers of the first run, and the figures."""
    from uavbridge.experiments.shao import plots

    plots.navigation(figure, outcome)


EXPERIMENT = Experiment(
    name="shao-navigate",
    summary="steps of vector and scalar leaders, and how followers keep to them",
    source="Shao 2020, Figs 9, 10",
    params=NavigateParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=20,
    medians=("leader_distance", "spacing", "lag"),
    block=10,
    paired=("leader", "form"),
    remarks=remarks,
    plot=plot,
)
