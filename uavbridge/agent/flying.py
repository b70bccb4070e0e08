"""The course of vehicles that fly: up to the search height, search, home at heights of their own.

Paths home cannot meet: each of the team rises to a height of its own, flies level to
over its home, and descends when the column below is free. Heights are those above home,
or above the ground where the mission has terrain, which is then followed.
"""

from __future__ import annotations

from math import hypot

from planners.types import FlySegment, FlyVelocity, Setpoint
from uavbridge.agent.course import STILL, Leg
from uavbridge.agent.guidance import climb_to, over_ground, towards, wanted
from uavbridge.agent.handling import HANDLING
from uavbridge.agent.phases import Phase
from uavbridge.agent.plan import AgentPlan
from uavbridge.safety.filter import Traffic, Vector


class Flying:
    """``Course`` of one vehicle in the air."""

    drives = False

    def __init__(self, plan: AgentPlan) -> None:
        self.home: Vector = plan.start
        self.handling = HANDLING["multirotor"]
        self.trouble = ""
        self._plan = plan
        self._altitude_m = self._height(plan.start)
        self._post: Vector = plan.start

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
        plan = self._plan
        if phase is Phase.CLIMB:
            off_m = hypot(position[0] - plan.start[0], position[1] - plan.start[1])
            there = self._at_height(self._altitude_m, position) and off_m < self.handling.start_m
            return Leg(self._towards(plan.start, position), Phase.SEARCH if there else None)
        if phase is Phase.SEARCH:
            return Leg(STILL if setpoint is None else self._search(setpoint, position))
        if phase is Phase.RISE:
            there = self._at_height(plan.return_height_m, position)
            up = self._at(plan.return_height_m, STILL, position)
            return Leg(up, Phase.HOME if there else None)
        if phase is Phase.PAUSE:
            return Leg(self._towards(self._post, position))
        return self._homewards(phase, position, traffic)

    def _search(self, setpoint: Setpoint, position: Vector) -> Vector:
        plan = self._plan
        velocity = wanted(setpoint, position, self._altitude_m, plan.envelope)
        if plan.terrain is None:
            return velocity
        if isinstance(setpoint, FlyVelocity):
            return self._at(self._altitude_m, velocity, position)
        end = setpoint.end if isinstance(setpoint, FlySegment) else setpoint.position
        return self._at(float(end[2]), velocity, position)

    def _homewards(self, phase: Phase, position: Vector, traffic: list[Traffic]) -> Leg:
        plan = self._plan
        over_home = (self.home[0], self.home[1], plan.return_height_m)
        velocity = towards(over_home, position, plan.envelope.speed_m_s)
        if phase is Phase.DESCEND:
            low = position[2] - self.home[2] <= plan.low_height_m
            down = (velocity[0], velocity[1], -plan.envelope.sink_m_s)
            return Leg(down, Phase.LAND if low else None)
        off_m = hypot(position[0] - over_home[0], position[1] - over_home[1])
        free = off_m < self.handling.home_m and self._column_free(position, traffic)
        down_by = Phase.LAND if self.handling.circles else Phase.DESCEND
        level = self._at(plan.return_height_m, velocity, position)
        return Leg(level, down_by if free else None)

    def _column_free(self, position: Vector, traffic: list[Traffic]) -> bool:
        """Nobody below who would be met; of two at one height the smaller id goes first."""
        clear_m = 1.5 * self._plan.envelope.separation_m
        mine = (round(position[2]), self._plan.agent)
        return not any(
            hypot(o.position[0] - self.home[0], o.position[1] - self.home[1]) < clear_m
            and (round(o.position[2]), o.agent) < mine
            for o in traffic
        )

    def _at_height(self, height_m: float, position: Vector) -> bool:
        return abs(self._height(position) - height_m) < self.handling.height_m

    def _height(self, position: Vector) -> float:
        """Height (m) above home, or above the terrain."""
        terrain = self._plan.terrain
        return position[2] if terrain is None else position[2] - float(terrain.height_at(position))

    def _towards(self, point: Vector, position: Vector) -> Vector:
        """To a point, at the height that it has over its own ground."""
        velocity = towards(point, position, self._plan.envelope.speed_m_s)
        return self._at(self._height(point), velocity, position)

    def _at(self, height_m: float, velocity: Vector, position: Vector) -> Vector:
        """A velocity that keeps a height (m); only its horizontal part counts."""
        plan = self._plan
        if plan.terrain is None:
            return velocity[0], velocity[1], climb_to(height_m, position[2])
        return over_ground(velocity, height_m, position, plan.terrain, plan.envelope)
