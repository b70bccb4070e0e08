"""Boids as a search, without and with Liu's guidance.

Liu et al. 2022, "Emergent search of UAV swarm guided by the target probability
map", sections 5.1.4 and 5.1.5: rivals of ESUSTPM. The three rules of Reynolds
1987 (``planners.flocking.boids``) turn an agent that flies at a constant speed;
with guidance, the guide cell of ESUSTPM (``planners.search.guidance``) is a
fourth wish. The heading changes to

    unit(inertia e + w_s separation + w_a alignment + w_c cohesion + w_g F_4)

| symbol | name |
| --- | --- |
| e, the heading flown | ``heading`` |
| safe distance | ``safe_m`` |
| w_s, w_a, w_c | ``separation``, ``alignment``, ``cohesion`` |
| w_g | ``guide`` |
| F_4 | ``guidance.direction`` |

The paper gives the safe distance (120 m) and neither weights, radius, speed law
nor initial headings. Taken here: the sum above, constant speed, headings
drawn uniformly at the first tick, and the reversal at the boundary of ESUSTPM.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from planners.flocking import boids as rules
from planners.planner import PlannerKind, param
from planners.search import flight, guidance, readings
from planners.search.guidance import Guidance
from planners.types import F64, I64, Bools, Goal, Scenario, View


@dataclass(frozen=True, slots=True)
class BoidsParams:
    """Parameters of boids without guidance."""

    safe_m: float = param(120.0, unit="m", doc="distance below which agents part", low=0.001)
    radius_m: float = param(
        300.0, unit="m", doc="neighbours within it are matched and closed up to", low=0.001
    )
    inertia: float = param(1.0, unit="1", doc="weight of the heading flown", low=0.0)
    separation: float = param(1.5, unit="1", doc="weight of collision avoidance", low=0.0)
    alignment: float = param(0.5, unit="1", doc="weight of velocity matching", low=0.0)
    cohesion: float = param(0.3, unit="1", doc="weight of flock centering", low=0.0)
    speed_m_s: float = param(10.0, unit="m/s", doc="constant speed", low=0.1)
    heading_noise_rad: float = readings.heading_noise_rad()
    boundary: str = readings.boundary()
    margin_m: float = readings.margin_m()
    forget_s: float = readings.forget_s()


@dataclass(frozen=True, slots=True)
class GuidedBoidsParams(BoidsParams):
    """Parameters of boids with guidance."""

    guide: float = param(1.0, unit="1", doc="weight of the guide cell", low=0.0)
    keep: str = readings.keep("entered")
    escape_ratio: float = readings.escape_ratio(0.0)
    ties: str = readings.ties()
    guide_point: str = readings.guide_point()


@dataclass(frozen=True, slots=True)
class BoidsMemory:
    """The heading last flown (None before the first tick) and the guide cell (-1: none)."""

    heading_rad: float | None
    guide: int


def turn(
    position: F64,
    heading: F64,
    others: F64,
    theirs: F64,
    present: Bools,
    towards_guide: F64,
    guide_weight: float,
    params: BoidsParams,
) -> F64:
    """Velocities (..., 2) m/s that the rules want, at the constant speed.

    Args:
        position: (..., 2) m.
        heading: (...) rad, as flown.
        others: (..., k, 2) m, the neighbours.
        theirs: (..., k, 2) m/s, their velocities.
        present: (..., k) which of them are heard.
        towards_guide: (..., 2) unit vectors to the guide cells, or zero.
        guide_weight: weight of these.
        params: of the planner.
    """
    onwards = np.stack((np.cos(heading), np.sin(heading)), axis=-1)
    near = rules.within(position, others, present, params.radius_m)
    wish = params.inertia * onwards + guide_weight * towards_guide
    wish = wish + params.separation * rules.separation(position, others, near, params.safe_m)
    wish = wish + params.alignment * rules.alignment(
        onwards * params.speed_m_s, theirs, near, params.speed_m_s
    )
    wish = wish + params.cohesion * rules.cohesion(position, others, near, params.radius_m)
    length = np.hypot(wish[..., 0], wish[..., 1])[..., None]
    undecided = length < 1e-9
    unit = np.where(undecided, onwards, wish / np.where(undecided, 1.0, length))
    return np.asarray(unit * params.speed_m_s)


def step(
    position: F64,
    heading: F64,
    others: F64,
    theirs: F64,
    present: Bools,
    belief: F64,
    guide: I64,
    noise: F64,
    scenario: Scenario,
    params: BoidsParams,
) -> tuple[F64, I64]:
    """One decision of every agent of every run: velocities (..., 2) m/s and guide cells (...).

    Arguments as of ``turn`` and ``planners.search.esustpm.step``.
    """
    towards, weight = np.zeros_like(position), 0.0
    if isinstance(params, GuidedBoidsParams):
        rule = Guidance(
            scenario.detection_threshold,
            params.keep,
            params.escape_ratio,
            params.ties,
            params.guide_point,
        )
        guide = guidance.choose(belief, position, guide, scenario.grid, rule, others, present)
        towards = guidance.direction(position, guide, scenario.grid, rule.point)
        weight = params.guide
    wish = turn(position, heading, others, theirs, present, towards, weight, params)
    wish = flight.turned(wish, noise * params.heading_noise_rad)
    inside = flight.turn_back(
        position, wish, scenario.grid, scenario.tick_s, params.margin_m, params.boundary
    )
    return inside, guide


@dataclass(frozen=True, slots=True)
class Boids:
    """The planner: one agent's row of ``step``."""

    scenario: Scenario
    params: BoidsParams

    def init(self, view: View) -> BoidsMemory:
        return BoidsMemory(None, -1)

    def plan(self, view: View, memory: BoidsMemory, rng: Generator) -> tuple[Goal, BoidsMemory]:
        drawn = float(rng.uniform(-math.pi, math.pi))
        heading = drawn if memory.heading_rad is None else memory.heading_rad
        others, theirs = flight.neighbours(view, self.params.forget_s)
        flown, guide = step(
            view.position[:2],
            np.asarray(heading),
            others,
            theirs,
            flight.everyone(others),
            view.belief,
            np.asarray(memory.guide),
            np.asarray(rng.standard_normal()),
            self.scenario,
            self.params,
        )
        setpoint = flight.level_velocity(self.scenario, view, flown)
        flown_heading = float(np.arctan2(flown[1], flown[0]))
        return Goal(setpoint, note="flocking"), BoidsMemory(flown_heading, int(guide))


def bind(scenario: Scenario, params: BoidsParams) -> Boids:
    """Boids for one mission."""
    return Boids(scenario, params)


BOIDS = PlannerKind(
    "boids", "Reynolds' three flocking rules, no guidance (Liu 2022, 5.1.4)", BoidsParams, bind
)
BOIDS_GUIDED = PlannerKind(
    "boids-guided",
    "Reynolds' three flocking rules, drawn by the likeliest surrounding cell (Liu 2022, 5.1.5)",
    GuidedBoidsParams,
    bind,
)
