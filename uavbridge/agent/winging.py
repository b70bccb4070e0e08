"""The course of aircraft: as of other vehicles that fly, but to stay at a place is to circle it."""

from __future__ import annotations

from math import atan, atan2, cos, hypot, pi, sin, tan
from typing import Final

from planners.types import FlySegment, FlyVelocity, Setpoint
from uavbridge.agent.course import STILL, Leg
from uavbridge.agent.flying import Flying
from uavbridge.agent.guidance import climb_to, over_ground
from uavbridge.agent.handling import HANDLING
from uavbridge.agent.passing import Passing
from uavbridge.agent.phases import Phase
from uavbridge.agent.plan import AgentPlan
from uavbridge.safety.filter import Traffic, Vector

LEAST_CIRCLE_M: Final = 150.0
CIRCLE_BANK_RAD: Final = 0.5
PACE: Final = 1.5  # of the least speed, in circles
JOIN_1_S: Final = 0.3  # how fast a circle is joined
AT_HOME: Final = 1.6  # radii
CLEAR: Final = 3.0  # radii about home that must be free of aircraft below
BESIDE: Final = 1.5  # separations about home that must be free of all others below
SLOW: Final = 0.5  # of the least speed: nobody who circles is slower
_GRAVITY: Final = 9.80665


class Winging(Flying):
    """``Course`` of one aircraft."""

    def __init__(self, plan: AgentPlan) -> None:
        super().__init__(plan)
        self.handling = HANDLING["plane"]
        limits = plan.envelope
        self._pace = min(max(PACE * limits.slowest_m_s, 1.0), limits.speed_m_s)
        self._circle_m = max(LEAST_CIRCLE_M, self._pace**2 / (_GRAVITY * tan(CIRCLE_BANK_RAD)))
        self._passing = Passing(limits.speed_m_s)
        self._middle: Vector | None = None  # of the circle in which it climbs or sinks

    def steer(
        self,
        phase: Phase,
        position: Vector,
        t_us: int,
        setpoint: Setpoint | None,
        traffic: list[Traffic],
    ) -> Leg:
        plan = self._plan
        self._passing.see(position)
        if phase is Phase.RISE:
            self._middle = self._middle or position
            up = self._round(self._middle, plan.return_height_m, position)
            there = self._at_height(plan.return_height_m, position)
            return Leg(up, Phase.HOME if there else None)
        self._middle = None
        if phase is Phase.CLIMB:
            off_m = hypot(position[0] - plan.start[0], position[1] - plan.start[1])
            there = self._at_height(self._altitude_m, position)
            there = there and off_m < max(self.handling.start_m, AT_HOME * self._circle_m)
            way = self._round(plan.start, self._altitude_m, position)
            return Leg(way, Phase.SEARCH if there else None)
        if phase is Phase.SEARCH:
            return Leg(STILL if setpoint is None else self._search(setpoint, position))
        if phase is Phase.PAUSE:
            return Leg(self._round(self._post, self._height(self._post), position))
        return self._homewards(phase, position, traffic)

    def _search(self, setpoint: Setpoint, position: Vector) -> Vector:
        plan = self._plan
        if isinstance(setpoint, FlyVelocity):
            x, y, z = setpoint.velocity.tolist()
            return (x, y, z) if z else self._at(self._altitude_m, (x, y, 0.0), position)
        end = setpoint.end if isinstance(setpoint, FlySegment) else setpoint.position
        x, y, z = end.tolist()
        height_m = self._height((x, y, z))
        if self._passing.was_there((x, y, z), position):
            return self._round((x, y, z), height_m, position)
        way_x, way_y = self._passing.way((x, y, z), position)
        way = plan.envelope.speed_m_s * way_x, plan.envelope.speed_m_s * way_y, 0.0
        return self._at(height_m, way, position)

    def _homewards(self, phase: Phase, position: Vector, traffic: list[Traffic]) -> Leg:
        way = self._round(self.home, self._plan.return_height_m, position)
        off_m = hypot(position[0] - self.home[0], position[1] - self.home[1])
        free = off_m < AT_HOME * self._circle_m and self._column_free(position, traffic)
        return Leg(way, Phase.LAND if free else None)

    def _column_free(self, position: Vector, traffic: list[Traffic]) -> bool:
        """Nobody lower circles near home; of two at one height the smaller id goes first.

        Who is slower than aircraft fly (on the ground, or no aircraft) is in the way only there.
        """
        limits = self._plan.envelope
        mine = (round(position[2]), self._plan.agent)
        for other in traffic:
            flies = hypot(*other.velocity) > SLOW * limits.slowest_m_s
            clear_m = CLEAR * self._circle_m if flies else BESIDE * limits.separation_m
            away_m = hypot(other.position[0] - self.home[0], other.position[1] - self.home[1])
            if away_m < clear_m and (round(other.position[2]), other.agent) < mine:
                return False
        return True

    def _round(self, middle: Vector, height_m: float, position: Vector) -> Vector:
        """To a circle about a place, and along it clockwise, at a height."""
        east, north = position[0] - middle[0], position[1] - middle[1]
        outwards, away = atan2(north, east), hypot(east, north)
        course = outwards - pi / 2 - atan(JOIN_1_S * (away - self._circle_m) / self._pace)
        way = self._pace * cos(course), self._pace * sin(course), 0.0
        return self._at(height_m, way, position)

    def _at(self, height_m: float, velocity: Vector, position: Vector) -> Vector:
        """A velocity that keeps a height (m); it never gets slower for steep ground."""
        plan = self._plan
        if plan.terrain is None:
            return velocity[0], velocity[1], climb_to(height_m, position[2])
        _, _, up = over_ground(velocity, height_m, position, plan.terrain, plan.envelope)
        return velocity[0], velocity[1], up
