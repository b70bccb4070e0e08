"""The five methods of Liu 2022 in batches of runs: the planners' kernels, one agent's turn a call.

Draws come from one generator a run, in the order of (cycle, agent), as the
planners would draw them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.random import Generator

from planners.paths import loop
from planners.planner import Planner
from planners.search import boids, esustpm, flight, mower, random_walk
from planners.types import F64, I64, Bools, Scenario
from uavbridge.experiments.liu.setting import (
    GRID,
    INTERVAL_S,
    TICK_S,
    LiuParams,
    scenario,
    starts,
)

Memory: TypeAlias = dict[str, Any]  # arrays (runs, agents, ...), written in place

_MARGIN_M = 15.0  # in which vehicles turn


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What one agent knows on its turn, in every run."""

    position: F64  # (runs, 2) m
    others: F64  # (runs, k, 2) m, ascending agents
    theirs: F64  # (runs, k, 2) m/s, as last flown
    present: Bools  # (runs, k)
    belief: F64  # (runs, columns, rows)


class Method(Protocol):
    """One search method over a batch of runs."""

    @property
    def scenario(self) -> Scenario: ...

    def memory(self, draws: Sequence[Generator], cycles: int) -> Memory:
        """Before the first cycle; draws all that the runs will need."""
        ...

    def move(self, memory: Memory, agent: int, cycle: int, seen: Seen) -> F64:
        """Velocities (runs, 2) m/s of one agent on its turn; writes ``memory``."""
        ...

    def planner(self) -> Planner:
        """The same method as a mission flies it."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class EsustpmMethod:
    """ESUSTPM."""

    scenario: Scenario
    params: esustpm.EsustpmParams

    def memory(self, draws: Sequence[Generator], cycles: int) -> Memory:
        team = len(self.scenario.team)
        noise = np.stack([draw.standard_normal((cycles, team)) for draw in draws])
        return _turning(noise, np.full((len(draws), team), math.pi / 2.0))

    def move(self, memory: Memory, agent: int, cycle: int, seen: Seen) -> F64:
        turned = esustpm.step(
            seen.position,
            memory["heading"][:, agent],
            seen.others,
            seen.present,
            seen.belief,
            memory["guide"][:, agent],
            memory["noise"][:, cycle, agent],
            self.scenario,
            self.params,
            esustpm.Rules.of(self.params, self.scenario.detection_threshold),
        )
        return _remembered(memory, agent, *turned)

    def planner(self) -> Planner:
        return esustpm.bind(self.scenario, self.params)


@dataclass(frozen=True, slots=True, eq=False)
class BoidsMethod:
    """Boids, with guidance where the parameters are those of guided boids."""

    scenario: Scenario
    params: boids.BoidsParams

    def memory(self, draws: Sequence[Generator], cycles: int) -> Memory:
        team = len(self.scenario.team)
        heading, noise = np.empty((2, len(draws), cycles, team))
        for run, draw in enumerate(draws):
            for cycle in range(cycles):
                for agent in range(team):
                    heading[run, cycle, agent] = draw.uniform(-math.pi, math.pi)
                    noise[run, cycle, agent] = draw.standard_normal()
        return _turning(noise, heading[:, 0].copy())

    def move(self, memory: Memory, agent: int, cycle: int, seen: Seen) -> F64:
        turned = boids.step(
            seen.position,
            memory["heading"][:, agent],
            seen.others,
            seen.theirs,
            seen.present,
            seen.belief,
            memory["guide"][:, agent],
            memory["noise"][:, cycle, agent],
            self.scenario,
            self.params,
        )
        return _remembered(memory, agent, *turned)

    def planner(self) -> Planner:
        return boids.bind(self.scenario, self.params)


@dataclass(frozen=True, slots=True, eq=False)
class RandomMethod:
    """Classical random search."""

    scenario: Scenario
    params: random_walk.RandomWalkParams

    def memory(self, draws: Sequence[Generator], cycles: int) -> Memory:
        shape = (cycles, len(self.scenario.team), random_walk.DRAWS, 2)
        return {"square": np.stack([draw.uniform(-1.0, 1.0, shape) for draw in draws])}

    def move(self, memory: Memory, agent: int, cycle: int, seen: Seen) -> F64:
        params, tick_s = self.params, self.scenario.tick_s
        chosen = random_walk.clearest(
            seen.position,
            seen.others,
            seen.present,
            random_walk.directions(memory["square"][:, cycle, agent]),
            params.speed_m_s * tick_s,
            GRID,
            params.safe_m,
            params.margin_m,
        )
        flown = chosen * params.speed_m_s
        return flight.turn_back(seen.position, flown, GRID, tick_s, params.margin_m, "vector")

    def planner(self) -> Planner:
        return random_walk.bind(self.scenario, self.params)


@dataclass(frozen=True, slots=True, eq=False)
class MowerMethod:
    """The mower: a lane an agent."""

    scenario: Scenario
    params: mower.MowerParams

    def memory(self, draws: Sequence[Generator], cycles: int) -> Memory:
        team = len(self.scenario.team)
        own = [mower.lanes_loop(GRID, agent, team, self.params) for agent in range(team)]
        points, count = loop.stack(own)
        return {"points": points, "count": count, "leg": np.zeros((len(draws), team), np.int64)}

    def move(self, memory: Memory, agent: int, cycle: int, seen: Seen) -> F64:
        leg: I64 = memory["leg"][:, agent]
        flown, memory["leg"][:, agent] = mower.step(
            seen.position,
            memory["points"][agent],
            memory["count"][agent],
            leg,
            self.params,
            self.scenario.tick_s,
        )
        return flown

    def planner(self) -> Planner:
        return mower.bind(self.scenario, self.params)


def _turning(noise: F64, heading: F64) -> Memory:
    """Of guided methods: noise (runs, cycles, agents) and first headings (runs, agents)."""
    return {"noise": noise, "guide": np.full(heading.shape, -1, np.int64), "heading": heading}


def _remembered(memory: Memory, agent: int, flown: F64, guide: I64) -> F64:
    """The velocities (runs, 2), written down with the guide cells (runs,)."""
    memory["guide"][:, agent] = guide
    memory["heading"][:, agent] = np.arctan2(flown[:, 1], flown[:, 0])
    return flown


def method(name: str, params: LiuParams, *, flown: bool = False) -> Method:
    """A method of the paper, read as the parameters say.

    ``flown``: for vehicles with inertia, which need room to turn.
    """
    return _METHODS[name](params, _MARGIN_M if flown else 0.0)


def _esustpm(params: LiuParams, margin_m: float) -> Method:
    own = esustpm.EsustpmParams(
        neighbours=params.neighbours,
        guide_gain=params.guide_gain,
        guide_law=params.guide_law,
        **_guidance(params),
        speed_m_s=params.speed_m,
        speed_reading=params.speed_reading,
        heading_noise_rad=params.heading_noise_rad,
        boundary=params.boundary,
        margin_m=margin_m,
    )
    tick_s = INTERVAL_S if params.speed_reading == "none" else TICK_S
    return EsustpmMethod(scenario(params, starts(), tick_s), own)


def _boids(params: LiuParams, margin_m: float) -> Method:
    return BoidsMethod(scenario(params, starts()), boids.BoidsParams(**_flock(params, margin_m)))


def _guided(params: LiuParams, margin_m: float) -> Method:
    own = boids.GuidedBoidsParams(
        **_flock(params, margin_m),
        guide=params.guide,
        **_guidance(params),
    )
    return BoidsMethod(scenario(params, starts()), own)


def _guidance(params: LiuParams) -> dict[str, Any]:
    return {
        "keep": params.keep,
        "escape_ratio": params.escape_ratio,
        "ties": params.ties,
        "guide_point": params.guide_point,
    }


def _flock(params: LiuParams, margin_m: float) -> dict[str, Any]:
    return {
        "safe_m": params.safe_m,
        "radius_m": params.radius_m,
        "separation": params.separation,
        "alignment": params.alignment,
        "cohesion": params.cohesion,
        "speed_m_s": params.boids_speed_m,
        "heading_noise_rad": params.heading_noise_rad,
        "boundary": params.boundary,
        "margin_m": margin_m,
    }


def _random(params: LiuParams, margin_m: float) -> Method:
    own = random_walk.RandomWalkParams(
        speed_m_s=params.speed_m,
        safe_m=params.random_safe_m,
        margin_m=max(params.random_safe_m, margin_m),
    )
    return RandomMethod(scenario(params, starts()), own)


def _mower(params: LiuParams, margin_m: float) -> Method:
    reach_m = max(margin_m, 0.001)
    own = mower.MowerParams(inset_cells=0.0, speed_m_s=params.speed_m, reach_m=reach_m)
    lanes = np.array([mower.lanes_loop(GRID, agent, 10, own)[0] for agent in range(10)])
    places = lanes if params.mower_starts == "lanes" else starts()
    return MowerMethod(scenario(params, places), own)


_METHODS: Mapping[str, Callable[[LiuParams, float], Method]] = {
    "random": _random,
    "mower": _mower,
    "boids": _boids,
    "boids-guided": _guided,
    "esustpm": _esustpm,
}
