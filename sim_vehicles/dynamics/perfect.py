"""Vehicles that do exactly what they are asked: the trivial model."""

from __future__ import annotations

import numpy as np

from planners.terrain import Terrain
from sim_vehicles.dynamics.airframe import GRAVITY, MultirotorParams
from sim_vehicles.dynamics.battery import Battery
from sim_vehicles.dynamics.demand import Demand, unwind
from sim_vehicles.dynamics.model import F64, Setpoints, States

_DEFAULT = MultirotorParams()
_TINY = 1e-12  # m: keeps 0 / 0 away
_IDLE_LOAD = 0.1  # thrust over weight of spinning motors on the ground


class PerfectTracking:
    """Setpoints are met at once, within the limits of speed, climb and sink.

    No tilt, no inertia, no wind; the battery drains as in a hover. With motors
    off, or an empty battery, a vehicle falls freely to the ground.
    """

    def __init__(
        self,
        position: F64,
        yaw: F64,
        *,
        params: MultirotorParams = _DEFAULT,
        ground_m: float = 0.0,
        terrain: Terrain | None = None,
    ) -> None:
        """Place vehicles at rest at position (n, 3) ENU m, yaw (n,) rad."""
        self._params = params
        self._states = states = States.at(position, yaw)
        self._terrain = terrain
        self._ground: F64 = states.ground
        self._ground[:] = np.minimum(states.position[:, 2], ground_m)
        if terrain is not None:
            self._ground[:] = terrain.height_at(states.position)
        states.on_ground[:] = states.position[:, 2] <= self._ground
        self._demand = Demand(len(position))
        self._battery = Battery(states, params.battery)
        self._on = np.zeros(len(position), dtype=np.bool_)
        self._load = np.zeros(len(position))

    @property
    def states(self) -> States:
        return self._states

    def step(self, setpoints: Setpoints, wind: F64, dt_s: float) -> None:
        states, on, demand = self._states, self._on, self._demand
        np.logical_and(setpoints.motors, states.battery > 0.0, out=on)
        demand.gather(setpoints, states.position.T, states.yaw)
        wanted = self._velocity(setpoints, dt_s)

        falling = states.velocity[:, 2] - GRAVITY * dt_s
        states.velocity[:] = np.where(on, wanted, 0.0).T
        states.velocity[:, 2] = np.where(on, wanted[2], falling)
        states.position += states.velocity * dt_s
        self._touch()

        demand.turn *= on
        demand.turn_rate *= on
        states.yaw += demand.turn
        states.yaw += demand.turn_rate * dt_s
        states.rates[:, 2] = demand.turn_rate
        unwind(states.yaw, self._load)

        self._load[:] = np.where(states.on_ground, _IDLE_LOAD, 1.0) * on
        np.divide(self._load, self._params.thrust_to_weight, out=states.thrust)
        self._battery.draw(self._load, dt_s)

    def _velocity(self, setpoints: Setpoints, dt_s: float) -> F64:
        p, error = self._params, self._demand.error
        error /= dt_s
        size = np.hypot(error[0], error[1]) + _TINY
        error[:2] *= np.minimum(1.0, setpoints.max_speed / size)
        np.clip(error[2], -setpoints.max_down, setpoints.max_up, out=error[2])
        error += self._demand.velocity
        error[:2] *= p.speed_m_s / np.maximum(np.hypot(error[0], error[1]), p.speed_m_s)
        np.clip(error[2], -p.sink_m_s, p.climb_m_s, out=error[2])
        return error

    def _touch(self) -> None:
        states = self._states
        if self._terrain is not None:
            self._ground[:] = self._terrain.height_at(states.position)
        low = states.position[:, 2] <= self._ground
        states.on_ground[:] = low
        np.copyto(states.position[:, 2], self._ground, where=low)
        np.copyto(states.velocity, 0.0, where=low[:, None])
