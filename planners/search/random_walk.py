"""Classical random search.

Liu et al. 2022, "Emergent search of UAV swarm guided by the target probability
map", section 5.1.2, Eqs. (12) and (13):

    dir = rnd(2, 1) / norm(rnd(2, 1))                   (12)
    P(t+1) = P(t) + dir S dt                            (13)

| symbol | name |
| --- | --- |
| rnd(2, 1), in [-1, 1] | ``square`` |
| dir | the value of ``directions`` |
| S | ``speed_m_s`` (10 m a cycle of 1 s) |
| dt | ``Scenario.tick_s`` |
| set safe value | ``safe_m``, ``margin_m`` |

A uniform point of the square, normalised, favours the diagonals by up to
sqrt 2; it is used as printed. The paper avoids neighbours and edges "when the
distances are less than the set safe value" without a rule or a value: here a
few directions are drawn and the first that stays clear is taken, or the
clearest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from planners.grid import Grid
from planners.planner import PlannerKind, param
from planners.search import flight
from planners.types import F64, MICROSECONDS, Bools, Goal, Scenario, View

DRAWS = 8  # directions tried a decision


@dataclass(frozen=True, slots=True)
class RandomWalkParams:
    """Parameters of the random walk."""

    speed_m_s: float = param(10.0, unit="m/s", doc="speed, S of Eq. (13)", low=0.1)
    hold_s: float = param(
        1.0, unit="s", doc="time a direction is flown; the paper draws every cycle", low=0.0
    )
    safe_m: float = param(20.0, unit="m", doc="distance kept from neighbours", low=0.0)
    margin_m: float = param(20.0, unit="m", doc="distance kept from the area's edges", low=0.0)
    forget_s: float = param(5.0, unit="s", doc="neighbours not heard for longer are gone", low=0.0)


@dataclass(frozen=True, slots=True)
class RandomWalkMemory:
    """Velocity flown, and when it was drawn (None: never)."""

    velocity: tuple[float, float]
    drawn_us: int | None


def directions(square: F64) -> F64:
    """Unit vectors (..., 2) from points (..., 2) of the square [-1, 1]^2, Eq. (12)."""
    length = np.hypot(square[..., 0], square[..., 1])[..., None]
    return np.asarray(square / np.where(length > 0.0, length, 1.0))  # Eq. (12)


def clearest(
    position: F64,
    others: F64,
    present: Bools,
    drawn: F64,
    step_m: float,
    grid: Grid,
    safe_m: float,
    margin_m: float,
) -> F64:
    """The first direction that keeps the safe distances, or the one that misses them least.

    Args:
        position: (..., 2) m.
        others: (..., k, 2) m.
        present: (..., k) which of them are heard.
        drawn: (..., draws, 2) unit vectors.
        step_m: length of the step.
        grid: the area.
        safe_m: distance kept from neighbours.
        margin_m: distance kept from the area's edges.

    Returns:
        (..., 2) unit vectors.
    """
    ahead = position[..., None, :] + drawn * step_m  # Eq. (13)
    west, south, east, north = grid.bounds
    low, high = np.array((west, south)), np.array((east, north))
    edge = np.minimum(ahead - low, high - ahead).min(axis=-1) - margin_m
    room = np.minimum(edge, 0.0)
    if others.shape[-2]:
        offset = ahead[..., :, None, :] - others[..., None, :, :]
        gap = np.hypot(offset[..., 0], offset[..., 1]) - safe_m
        gap = np.where(present[..., None, :], gap, 0.0).min(axis=-1)
        room = np.minimum(room, gap)
    pick = room.argmax(axis=-1)  # the first of equals: 0 is clear
    return np.take_along_axis(drawn, pick[..., None, None], axis=-2)[..., 0, :]


@dataclass(frozen=True, slots=True)
class RandomWalk:
    """The planner."""

    scenario: Scenario
    params: RandomWalkParams

    def init(self, view: View) -> RandomWalkMemory:
        return RandomWalkMemory((0.0, 0.0), None)

    def plan(
        self, view: View, memory: RandomWalkMemory, rng: Generator
    ) -> tuple[Goal, RandomWalkMemory]:
        held_us = self.params.hold_s * MICROSECONDS
        if memory.drawn_us is None or view.t_us - memory.drawn_us >= held_us:
            memory = RandomWalkMemory(self._draw(view, rng), view.t_us)
        flown = flight.turn_back(
            view.position[:2],
            np.array(memory.velocity),
            self.scenario.grid,
            self.scenario.tick_s,
            self.params.margin_m,
            "vector",
        )
        return Goal(flight.level_velocity(self.scenario, view, flown), note="wandering"), memory

    def _draw(self, view: View, rng: Generator) -> tuple[float, float]:
        params = self.params
        others, _ = flight.neighbours(view, params.forget_s)
        chosen = clearest(
            view.position[:2],
            others,
            flight.everyone(others),
            directions(rng.uniform(-1.0, 1.0, (DRAWS, 2))),
            params.speed_m_s * self.scenario.tick_s,
            self.scenario.grid,
            params.safe_m,
            params.margin_m,
        )
        return float(chosen[0] * params.speed_m_s), float(chosen[1] * params.speed_m_s)


def bind(scenario: Scenario, params: RandomWalkParams) -> RandomWalk:
    """The random walk for one mission."""
    return RandomWalk(scenario, params)


RANDOM = PlannerKind(
    "random", "A new random direction every cycle (Liu 2022, Eqs. 12-13)", RandomWalkParams, bind
)
