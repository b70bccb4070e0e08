"""The course of vehicles on the ground: search where the planner says, then drive home.

No vertical commands: the ground has the height. The way home is planned over the
terrain, no steeper than the vehicle climbs.
"""

from __future__ import annotations

from math import hypot, inf

from planners.paths.drive import Routes, routes_to
from planners.types import Setpoint
from uavbridge.agent.course import STILL, Leg
from uavbridge.agent.guidance import towards, wanted
from uavbridge.agent.handling import HANDLING
from uavbridge.agent.phases import Phase
from uavbridge.agent.plan import AgentPlan
from uavbridge.clock import SECOND_US, to_s
from uavbridge.safety.filter import Traffic, Vector

STUCK_S = 90.0  # on the way home without coming nearer
NEARER_M = 1.0
NEVER_US = -(1 << 60)


class Driving:
    """``Course`` of one vehicle on the ground."""

    drives = True

    def __init__(self, plan: AgentPlan) -> None:
        self.home: Vector = plan.start
        self.handling = HANDLING["rover"]
        self.trouble = ""
        self._plan = plan
        self._post: Vector = plan.start
        self._routes: Routes | None = None
        self._nearest_m = inf  # to home, along the way
        self._nearer_us = NEVER_US
        self._point: Vector = plan.start  # of the way home, thought over once a second
        self._point_us = NEVER_US

    def stay(self, at: Vector) -> None:
        self._post = at

    def steer(
        self,
        phase: Phase,
        position: Vector,
        t_us: int,
        setpoint: Setpoint | None,
        traffic: list[Traffic],
    ) -> Leg:
        if phase is Phase.HOME:
            return self._homewards(position, t_us)
        if phase is Phase.SEARCH:
            if setpoint is None:
                return Leg(STILL)
            return Leg(_level(wanted(setpoint, position, position[2], self._plan.envelope)))
        return Leg(self._towards(self._post, position))

    def _homewards(self, position: Vector, t_us: int) -> Leg:
        if hypot(self.home[0] - position[0], self.home[1] - position[1]) < self.handling.home_m:
            return Leg(STILL, Phase.PARK)
        if t_us - self._point_us >= SECOND_US:
            self._point, left_m = self._next(position)
            self._point_us = t_us
            if left_m < self._nearest_m - NEARER_M:
                self._nearest_m, self._nearer_us = left_m, t_us
            elif to_s(t_us - self._nearer_us) > STUCK_S:
                self.trouble = f"no nearer to home in {STUCK_S:g} s: stopped {left_m:.0f} m away"
                return Leg(STILL, Phase.PARK)
        return Leg(self._towards(self._point, position))

    def _next(self, position: Vector) -> tuple[Vector, float]:
        """The point to drive to, and how far home is from here."""
        plan = self._plan
        if plan.terrain is None:
            return self.home, hypot(self.home[0] - position[0], self.home[1] - position[1])
        if self._routes is None:
            self._routes = routes_to(self.home, plan.terrain, plan.climb_rad)
        (x, y), left_m = self._routes.onwards(position[0], position[1])
        return (x, y, position[2]), left_m

    def _towards(self, point: Vector, position: Vector) -> Vector:
        return _level(towards(point, position, self._plan.envelope.speed_m_s))


def _level(velocity: Vector) -> Vector:
    return velocity[0], velocity[1], 0.0
