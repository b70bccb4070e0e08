"""What carries the agents of light missions: point masses, or the bare vehicle models.

Missions that fly at the same time share one set of bodies, a vehicle a row, so that a
step of the model serves them all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from planners.terrain import Terrain
from planners.types import F64, I64, FlySegment, FlyVelocity, Setpoint
from sim_vehicles.crafts import CRAFTS
from sim_vehicles.dynamics import MakeModel, Setpoints, VehicleModel, Wind, WindSpec
from uavbridge.agent.guidance import over_ground, wanted
from uavbridge.agent.plan import AgentPlan
from uavbridge.bus.wire import Vector
from uavbridge.clock import to_s
from uavbridge.config import Mission
from uavbridge.rng import stream
from uavbridge.runner.ticks import CONTROL_US

STEP_S = to_s(CONTROL_US)


@dataclass(frozen=True, slots=True, eq=False)
class Flock:
    """The vehicles of one mission."""

    mission: Mission
    plans: Sequence[AgentPlan]


class Bodies(Protocol):
    """Vehicles of one mission after the other."""

    @property
    def position(self) -> F64:
        """(n, 3) ENU m."""
        ...

    @property
    def velocity(self) -> F64:
        """(n, 3) m/s."""
        ...

    def fly(self, setpoints: Sequence[Setpoint | None]) -> None:
        """One control step; None: stay."""
        ...


class Points:
    """Point masses: they do what they are told, within their mission's speed.

    On terrain they keep their height above it.
    """

    def __init__(self, flocks: Sequence[Flock]) -> None:
        self.position: F64 = np.array([plan.start for flock in flocks for plan in flock.plans])
        self.velocity: F64 = np.zeros_like(self.position)
        self._terrain = flocks[0].mission.terrain()
        self._height = self.position[:, 2] - _ground(self._terrain, self.position)
        self._speed = [flock.mission.safety.speed_m_s for flock in flocks for _ in flock.plans]

    def fly(self, setpoints: Sequence[Setpoint | None]) -> None:
        for row, setpoint in enumerate(setpoints):
            self.velocity[row] = self._velocity(row, setpoint)
        after = self.position + self.velocity * STEP_S
        if self._terrain is not None:
            after[:, 2] = self._terrain.height_at(after) + self._height
            self.velocity = (after - self.position) / STEP_S
        self.position = after

    def _velocity(self, row: int, setpoint: Setpoint | None) -> F64:
        if setpoint is None:
            return np.zeros(3)
        most = self._speed[row]
        if isinstance(setpoint, FlyVelocity):
            speed = float(np.hypot(setpoint.velocity[0], setpoint.velocity[1]))
            return setpoint.velocity * min(1.0, most / max(speed, 1e-9))
        asked = most if setpoint.speed_m_s is None else setpoint.speed_m_s
        if isinstance(setpoint, FlySegment):
            goal = _ahead(setpoint, self.position[row], min(asked, most) * STEP_S)
        else:
            goal = setpoint.position
        offset = goal - self.position[row]
        distance = float(np.sqrt(offset @ offset))
        pace = min(asked, most, distance / STEP_S)
        return np.asarray(offset / max(distance, 1e-9) * pace)


class Vehicles:
    """The missions' vehicle models, guided like live vehicles but without autopilot and filter."""

    def __init__(self, flocks: Sequence[Flock]) -> None:
        first = flocks[0].mission
        self._plans = [plan for flock in flocks for plan in flock.plans]
        start = np.array([plan.start for plan in self._plans])
        self.position, self.velocity = start.copy(), np.zeros_like(start)
        kinds = [member.kind for flock in flocks for member in flock.mission.team()]
        self._height = start[:, 2] - _ground(first.terrain(), start)
        self._squads: list[tuple[I64, VehicleModel, Setpoints]] = []
        for kind in dict.fromkeys(kinds):
            rows = np.flatnonzero([each == kind for each in kinds])
            heading = np.pi / 2.0 - np.radians(first.fleet.heading_deg)
            model = _model(kind, first)(
                start[rows], np.full(len(rows), heading), terrain=first.terrain()
            )
            asked = Setpoints.idle(len(rows))
            asked.motors[:] = True
            self._squads.append((rows, model, asked))
        self._asked = np.zeros_like(start)
        self._steps = max(1, round(STEP_S / first.simulator.step_s))
        self._winds = [_wind(flock) for flock in flocks]

    def fly(self, setpoints: Sequence[Setpoint | None]) -> None:
        for row, setpoint in enumerate(setpoints):
            self._asked[row] = self._velocity(row, setpoint)
        for rows, _, asked in self._squads:
            asked.velocity[:] = self._asked[rows]
        step_s = STEP_S / self._steps
        for _ in range(self._steps):
            wind = np.concatenate([each.step(step_s) for each in self._winds])
            for rows, model, asked in self._squads:
                model.step(asked, wind[rows], step_s)
        for rows, model, _ in self._squads:
            self.position[rows] = model.states.position
            self.velocity[rows] = model.states.velocity

    def _velocity(self, row: int, setpoint: Setpoint | None) -> Vector:
        if setpoint is None:
            return 0.0, 0.0, 0.0
        plan = self._plans[row]
        x, y, z = self.position[row].tolist()
        east, north, up = wanted(setpoint, (x, y, z), plan.start[2], plan.envelope)
        if plan.terrain is not None and not plan.drives:
            height_m, velocity = float(self._height[row]), (east, north, 0.0)
            here = (x, y, z)
            east, north, up = over_ground(velocity, height_m, here, plan.terrain, plan.envelope)
        factor = min(1.0, plan.envelope.speed_m_s / max(float(np.hypot(east, north)), 1e-9))
        climb = plan.envelope.climb_m_s
        return east * factor, north * factor, min(max(up, -climb), climb)


def _ground(terrain: Terrain | None, position: F64) -> F64:
    """Heights (n,) of the ground."""
    return np.zeros(len(position)) if terrain is None else terrain.height_at(position)


def _model(kind: str, mission: Mission) -> MakeModel:
    """The dynamics of one kind of vehicle."""
    models = CRAFTS["px4", kind].models
    return models.get(mission.fleet.model) or next(iter(models.values()))


def _wind(flock: Flock) -> Wind:
    blows, seed = flock.mission.wind, flock.mission.seed
    spec = WindSpec((blows.east_m_s, blows.north_m_s, blows.up_m_s), blows.gust_m_s)
    return Wind(spec, len(flock.plans), stream(seed, "wind"))


def _ahead(segment: FlySegment, position: F64, way_m: float) -> F64:
    """The point of a segment that lies ``way_m`` beyond the one nearest to a position."""
    along = segment.end - segment.start
    length = float(np.sqrt(along @ along))
    if length < 1e-9:
        return segment.end
    unit = along / length
    done = float((position - segment.start) @ unit) + way_m
    return np.asarray(segment.start + unit * min(max(done, 0.0), length))
