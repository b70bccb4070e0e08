"""A starling flock as a planner: it crosses the area to an aim, and back, and so on.

Chen et al. 2023, "A Study of Collaborative Trajectory Planning Method Based on Starling Swarm
Bionic Algorithm for Multi-Unmanned Aerial Vehicle", Appl. Sci. 13, 6795. Kernels:
``planners.flocking.starling``; one agent's row of ``flock.update``.

| symbol | name |
| --- | --- |
| R_p, R_minl, R_maxl, R_a | ``perception_m``, ``near_m``, ``far_m``, ``cluster_m`` |
| R_e, R_m | ``repel_m``, ``hold_m`` |
| K_d, K_v, K_dr, K_vr | ``gather``, ``match``, ``come_back``, ``come_back_speed`` |
| K_l, K_rand | ``learn``, ``explore`` |
| K_spring, K_vs | ``spring`` and ``pull``, ``damp`` |
| K_a, K_v of Eq. (11) | ``behaviour``, ``single`` |
| x_aim | ``aim_east``, ``aim_north`` |

Where the ground is known and bars the way, the agent nearest to the aim plans a way by RRT, and the
newest way goes from neighbour to neighbour in the payload, as do the ages of disturbances.
Without terrain in the view the ground is level and nothing bars the way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from planners.flocking.starling import message, route, wing
from planners.flocking.starling.behaviours import NAMES
from planners.flocking.starling.flock import Flock, Setting, update
from planners.flocking.starling.message import Told
from planners.flocking.starling.ridge import Watch
from planners.flocking.starling.route import RouteRules
from planners.flocking.starling.rules import StarlingRules
from planners.flocking.starling.wing import Wing
from planners.paths.rrt import path_length
from planners.planner import PlannerKind, param
from planners.search import flight
from planners.terrain import Terrain
from planners.types import F64, FlyVelocity, Goal, Scenario, View

_PLAN_S = 2.0  # time between two tries to plan a way
_SAMPLES = 1200  # of a tree
_ASIDE = (1.0, 0.6, 0.3, 0.0)  # shares of the distance to high ground beside a way, tried in order


@dataclass(frozen=True, slots=True)
class StarlingParams(StarlingRules):
    """Parameters of the starling planner: the flock's, and where it flies."""

    aim_east: float = param(
        0.9, unit="1", doc="the aim, as a share of the area from its western edge", low=0, high=1
    )
    aim_north: float = param(
        0.5, unit="1", doc="the aim, as a share of the area from its southern edge", low=0, high=1
    )
    reached_m: float = param(
        100.0, unit="m", doc="nearer to the aim, the flock turns to the point opposite", low=0.0
    )
    clearance_m: float = param(25.0, unit="m", doc="least height above ground", low=0.0)
    aside_m: float = param(
        150.0,
        unit="m",
        doc="ground higher than the way is left so far to the side where there is room; nearer, "
        "space is dangerous",
        low=0.0,
        high=1000.0,
    )
    lead_s: float = param(
        0.0,
        unit="s",
        doc="what the flock wants is asked of the vehicle so far ahead, at least a tick: as long "
        "as its course takes to follow",
        low=0.0,
        high=10.0,
    )
    bank_rad: float = param(0.785, unit="rad", doc="largest bank in turns", low=0.05, high=1.4)
    margin_m: float = param(
        15.0, unit="m", doc="the boundary lies this far inside the area's edges", low=0.0
    )
    forget_s: float = param(5.0, unit="s", doc="neighbours not heard for longer are gone", low=0.0)


@dataclass(frozen=True, slots=True, eq=False)
class StarlingMemory:
    """What the agent would tell, and when it last tried to plan (-1: never)."""

    told: Told
    tried_us: int


@dataclass(frozen=True, slots=True)
class Starling:
    """The planner."""

    scenario: Scenario
    params: StarlingParams

    def init(self, view: View) -> StarlingMemory:
        return StarlingMemory(Told(), -1)

    def plan(
        self, view: View, memory: StarlingMemory, rng: Generator
    ) -> tuple[Goal, StarlingMemory]:
        chance, noise = rng.uniform(), rng.standard_normal(3)
        heard, others = self._heard(view)
        flock = self._flock(view, memory.told, heard, others)
        told = max((memory.told, *heard), key=lambda one: one.rank)
        told, tried = self._turned(told, flock, view, memory, rng)
        count = len(flock.position)
        first = np.arange(count) == 0
        aim = self._aim(told.leg, view)
        towards = np.broadcast_to(aim, flock.position.shape).copy()
        if len(told.way) > 1:
            towards[0] = route.ahead(told.way, flock.position[:1], 6.0 * self._speed)[0]
        limits = self._wing
        setting = Setting(
            replace(self.params, speed_m_s=self._speed),
            limits,
            Watch(self.params.clearance_m, ceiling_m=self.scenario.limits.altitude_max_m),
            view.terrain,
            self._beside(view),
            aim,
        )
        done = update(
            flock,
            towards,
            np.zeros((0, 3)),
            np.where(first, chance, 0.0),
            np.where(first[:, None], noise, 0.0),
            setting,
            self.scenario.tick_s,
        )
        lead = max(self.scenario.tick_s, self.params.lead_s)
        flown = wing.flown(flock.velocity[:1], done.acceleration[:1], limits, lead)[0]
        ages = float(done.danger_s[0]), float(done.alarm_s[0])
        after = replace(told, danger_s=ages[0], alarm_s=ages[1])
        goal = Goal(
            self._setpoint(view, flown),
            payload=message.encode(after),
            note=NAMES[int(done.mode[0])],
        )
        return goal, StarlingMemory(after, tried)

    @property
    def _speed(self) -> float:
        return min(self.params.speed_m_s, self.scenario.limits.speed_m_s)

    @property
    def _wing(self) -> Wing:
        """Limits of the vehicle: those of the mission bound those of an aircraft."""
        fast, climb = self.scenario.limits.speed_m_s, self.scenario.limits.climb_m_s
        angle = min(math.atan2(climb, fast), 0.3)
        slow = min(self._speed / 2.0, 25.0)
        return Wing(self.params.bank_rad, angle, angle, slow, fast)

    def _heard(self, view: View) -> tuple[list[Told], F64]:
        """Messages and motion (k, 6) of those heard lately, ascending id."""
        heard = view.neighbours
        told, rows = [], []
        for row in np.argsort(heard.ids, kind="stable"):
            place = heard.position[row] + heard.velocity[row] * heard.age_s[row]
            motion = np.concatenate((place, heard.velocity[row]))
            if heard.age_s[row] > self.params.forget_s or not np.isfinite(motion).all():
                continue
            told.append(message.decode(heard.payloads[row] if row < len(heard.payloads) else b""))
            rows.append(motion)
        return told, np.array(rows).reshape(-1, 6)

    def _flock(self, view: View, own: Told, heard: list[Told], others: F64) -> Flock:
        """The agent in the first row, then those heard."""
        moving = view.velocity
        if float(np.hypot(moving[0], moving[1])) < 0.1:  # at rest it flies where it looks
            heading = view.heading_rad
            moving = 0.1 * np.array((math.cos(heading), math.sin(heading), 0.0))
        return Flock(
            np.concatenate((view.position[None], others[:, :3])),
            np.concatenate((moving[None], others[:, 3:])),
            np.array([own.danger_s, *(one.danger_s for one in heard)]),
            np.array([own.alarm_s, *(one.alarm_s for one in heard)]),
        )

    def _beside(self, view: View) -> Terrain | None:
        """The ground about the agent, widened: where its height is that of high ground beside."""
        if view.terrain is None or self.params.aside_m == 0.0:
            return None
        place, aside = view.position, self.params.aside_m
        if not np.isfinite(place).all():
            return None
        return route.widened(view.terrain.around(place, aside + view.terrain.cell_m), aside)

    def _aim(self, leg: int, view: View) -> F64:
        """The aim of a leg (3,): even ones go to the aim, odd ones to the point opposite."""
        west, south, east, north = self.scenario.grid.bounds
        share = np.array((self.params.aim_east, self.params.aim_north))
        if leg % 2:
            share = 1.0 - share
        x, y = np.array((west, south)) + share * (east - west, north - south)
        height = flight.altitude(self.scenario, view.agent)
        if view.terrain is not None:
            ground = float(view.terrain.height_at((x, y)))
            height = max(height, ground + 2.0 * self.params.clearance_m)
        return np.array((x, y, height))

    def _turned(
        self, told: Told, flock: Flock, view: View, memory: StarlingMemory, rng: Generator
    ) -> tuple[Told, int]:
        """The message with the next leg when the aim is reached, with a new way when one is due."""
        aim = self._aim(told.leg, view)
        away = np.hypot(*(flock.position - aim)[:, :2].T)
        if away[0] <= self.params.reached_m:
            told = replace(Told(), leg=told.leg + 1)
            aim = self._aim(told.leg, view)
        due = memory.tried_us < 0 or view.t_us - memory.tried_us >= _PLAN_S * 1e6
        if view.terrain is None or not due or away[0] > away.min():
            return told, memory.tried_us
        way = self._way(told, view, view.terrain, aim, rng)
        if way is not None:
            told = replace(told, planned_us=view.t_us, planner=view.agent, way=way)
        return told, view.t_us

    def _way(self, told: Told, view: View, ground: Terrain, aim: F64, rng: Generator) -> F64 | None:
        """A new way, or None when there is none or the old one is still clear."""
        if not np.isfinite(view.position).all() or not ground.contains(view.position):
            return None
        goal = _within(ground, view.position, aim, self.params.clearance_m)
        if len(told.way) > 1:
            left = route.remaining(told.way, view.position)
            clear = not route.blocked(ground, left, self.params.clearance_m / 2.0)
            arrives = float(np.hypot(*(told.way[-1] - aim)[:2])) < 1.0
            if clear and (arrives or path_length(left) > 8.0 * self._speed):
                return None
        limits = self.scenario.limits
        rules = RouteRules(
            clearance_m=self.params.clearance_m,
            ceiling_m=limits.altitude_max_m,
            climb_rad=math.pi / 4.0,
            margins_m=tuple(share * self.params.aside_m for share in _ASIDE),
            step_m=max(3.0 * self._speed, 2.0 * ground.cell_m),
            samples=_SAMPLES,
            ways=2,
        )
        flown_at = rules, self._wing, self._speed
        for margin in rules.margins_m:
            wide = route.widened(ground, margin)
            way = route.plan(wide, view.position, view.heading_rad, goal, *flown_at, rng)
            if way is not None and len(way) <= message.POINTS:
                return way
        return None

    def _setpoint(self, view: View, velocity: F64) -> FlyVelocity:
        """The velocity (3,) inside area, altitude band and limits."""
        case, limits = self.scenario, self.scenario.limits
        planar = flight.turn_back(
            view.position[:2], velocity[:2], case.grid, case.tick_s, self.params.margin_m, "vector"
        )
        planar = flight.limit(planar, limits.speed_m_s, "norm")
        height = float(view.position[2])
        low = (limits.altitude_min_m - height) / case.tick_s
        high = (limits.altitude_max_m - height) / case.tick_s
        climb = min(max(float(velocity[2]), low), high)
        climb = min(max(climb, -limits.climb_m_s), limits.climb_m_s)
        return FlyVelocity(np.array((planar[0], planar[1], climb)))


def _within(ground: Terrain, position: F64, aim: F64, clearance_m: float) -> F64:
    """The aim, or where the line to it leaves the known ground, lifted above it."""
    low, high = np.array(ground.bounds).reshape(2, 2)
    offset = (aim - position)[:2]
    edge = np.where(offset > 0.0, high, low) - position[:2]
    moving = np.abs(offset) > 1e-9
    share = float(np.where(moving, edge / np.where(moving, offset, 1.0), np.inf).min())
    if share >= 1.0:
        return aim
    x, y = np.clip(position[:2] + share * offset, low, high)
    floor = float(ground.height_at((x, y))) + 2.0 * clearance_m
    return np.array((x, y, max(float(aim[2]), floor)))


def bind(scenario: Scenario, params: StarlingParams) -> Starling:
    """A starling flock for one mission."""
    return Starling(scenario, params)


STARLING = PlannerKind(
    "starling",
    "A starling flock across terrain, to an aim and back (Chen 2023, Eqs. 1-32)",
    StarlingParams,
    bind,
)
