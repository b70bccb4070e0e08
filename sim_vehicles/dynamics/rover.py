"""Ground vehicles: kinematic rovers that stay on the terrain.

A rover drives along its heading and turns towards the velocity, or the point, that is
asked for; it may turn on the spot. Its speed along the ground is limited, changes by a
limited acceleration, and falls to zero at the steepest climb: uphill it is
``speed (1 - rise / steepest rise)`` at most, measured over the length of the vehicle, so
that no rover climbs more than it can. Downhill there is no limit but the speed. Height,
roll and pitch are the ground's.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import radians

import numpy as np

from planners.terrain import Terrain, flat
from sim_vehicles.dynamics.airframe import BatteryParams
from sim_vehicles.dynamics.battery import Battery
from sim_vehicles.dynamics.demand import Demand, unwind
from sim_vehicles.dynamics.model import F64, Setpoints, States

_STILL_M_S = 0.05  # below it nothing is asked for
_LEVEL = flat((-1e5, -1e5, 1e5, 1e5))


@dataclass(frozen=True, slots=True)
class RoverParams:
    """A rover; the default is made for the speeds of Zhou 2023."""

    speed_m_s: float = 12.0  # along the ground
    accel_m_s2: float = 4.0
    turn_rad_s: float = 2.0
    climb_rad: float = radians(35.0)  # steepest it can climb, where its speed is 0
    length_m: float = 1.0  # over which slopes count
    stop_m: float = 0.2  # so near to a place it brakes and is there
    idle_load: float = 0.05
    battery: BatteryParams = field(default_factory=BatteryParams)


_DEFAULT = RoverParams()


class GroundRover:
    """Rovers on one terrain, batched."""

    def __init__(
        self,
        position: F64,
        yaw: F64,
        *,
        terrain: Terrain | None = None,
        params: RoverParams = _DEFAULT,
    ) -> None:
        """Place vehicles at rest at position (n, 3) ENU m, of which x and y count, yaw (n,) rad.

        Without terrain the ground is level, at height 0.
        """
        self._params = params
        self._terrain = _LEVEL if terrain is None else terrain
        self._states = states = States.at(position, yaw)
        n = len(states.yaw)
        self._speed = np.zeros(n)  # along the ground
        self._demand = Demand(n)
        self._battery = Battery(states, params.battery)
        self._turns = np.zeros(n)
        self._settle()

    @property
    def states(self) -> States:
        return self._states

    def step(self, setpoints: Setpoints, wind: F64, dt_s: float) -> None:
        states, p = self._states, self._params
        on = setpoints.motors & (states.battery > 0.0)
        way, wanted = self._wanted(setpoints, dt_s)
        self._turn(np.where(on & (wanted > _STILL_M_S), way, np.nan), dt_s)
        heading = np.stack((np.cos(states.yaw), np.sin(states.yaw)), axis=-1)
        ahead = np.maximum(np.cos(way - states.yaw), 0.0)  # slow down to turn
        rise = self._rise(heading)
        most = p.speed_m_s * np.clip(1.0 - rise / np.tan(p.climb_rad), 0.0, 1.0)
        slant = np.sqrt(1.0 + rise * rise)
        goal = np.minimum(wanted * ahead * slant, most) * on
        change = p.accel_m_s2 * dt_s
        self._speed = np.minimum(self._speed + np.clip(goal - self._speed, -change, change), most)
        before = states.position.copy()
        states.position[:, :2] += heading * (self._speed / slant * dt_s)[:, None]
        self._settle()
        states.velocity[:] = (states.position - before) / dt_s
        load = np.where(on, p.idle_load + 0.5 * self._speed / p.speed_m_s, 0.0)
        states.thrust[:] = load
        self._battery.draw(load, dt_s)

    def _wanted(self, setpoints: Setpoints, dt_s: float) -> tuple[F64, F64]:
        """Direction (n,) and horizontal speed (n,) that are asked for."""
        demand = self._demand
        demand.gather(setpoints, self._states.position.T, self._states.yaw)
        error = demand.error[:2]
        distance = np.hypot(error[0], error[1])
        stopping = np.sqrt(2.0 * self._params.accel_m_s2 * distance)
        pace = np.minimum(np.minimum(distance / dt_s, stopping), setpoints.max_speed)
        pace *= distance > self._params.stop_m
        vx, vy = demand.velocity[:2] + error * (pace / np.maximum(distance, 1e-12))
        return np.arctan2(vy, vx), np.minimum(np.hypot(vx, vy), self._params.speed_m_s)

    def _turn(self, way: F64, dt_s: float) -> None:
        """Turn towards headings (n,) rad; NaN: towards the yaw asked for, if any."""
        states, p = self._states, self._params
        turn = np.where(np.isfinite(way), way - states.yaw, self._demand.turn)
        turn += np.where(np.isfinite(way), 0.0, self._demand.turn_rate * dt_s)
        unwind(turn, self._turns)
        turn = np.clip(turn, -p.turn_rad_s * dt_s, p.turn_rad_s * dt_s)
        states.yaw += turn
        states.rates[:, 2] = turn / dt_s
        unwind(states.yaw, self._turns)

    def _rise(self, heading: F64) -> F64:
        """Steepest rise (n,) per metre ahead: at the wheels and a vehicle's length on."""
        xy, length = self._states.position[:, :2], self._params.length_m
        steps = np.array((0.05, 0.5, 1.0)) * length
        points = xy[:, None] + heading[:, None] * steps[:, None]
        height = self._terrain.height_at(points) - self._states.position[:, 2, None]
        return np.asarray((height / steps).max(axis=-1))

    def _settle(self) -> None:
        """On the ground: height, roll and pitch."""
        states = self._states
        states.ground[:] = self._terrain.height_at(states.position)
        states.position[:, 2] = states.ground
        east, north = self._terrain.gradient_at(states.position).T
        cos, sin = np.cos(states.yaw), np.sin(states.yaw)
        states.pitch[:] = np.arctan(east * cos + north * sin)
        states.roll[:] = np.arctan(north * cos - east * sin)  # higher on the left: right down
