"""The cheap model of the same aircraft: answers of its loops instead of forces.

Beard and McLain 2012, section 9.4, Eqs. (9.19)-(9.23): course by coordinated turns, bank, flight
path angle and airspeed as first-order answers. The same guide flies it as the six degrees of
freedom; their answers are compared in docs/reference/vehicle_model.md.
"""

from __future__ import annotations

import numpy as np

from planners.terrain import Terrain
from sim_vehicles.dynamics.airframe import GRAVITY
from sim_vehicles.dynamics.model import F64, Bools, Setpoints, States
from sim_vehicles.dynamics.plane.airframe import PlaneParams
from sim_vehicles.dynamics.plane.guide import Guide, wrapped
from sim_vehicles.dynamics.plane.power import Drain
from sim_vehicles.dynamics.plane.runway import Runway

_DEFAULT = PlaneParams()
ROLL_1_S = 4.5  # b of bank, flight path angle, airspeed
CLIMB_1_S = 2.5
SPEED_1_S = 0.9
_SPIN_RAD_S = 2.0  # fastest change of bank
_RISE_M_S2 = 8.0  # largest acceleration across the path, up or down


class GuidedPlane:
    """Aircraft by the guidance model. Setpoints are read as in ``guide``."""

    def __init__(
        self,
        position: F64,
        yaw: F64,
        *,
        params: PlaneParams = _DEFAULT,
        terrain: Terrain | None = None,
        airspeed: F64 | None = None,
    ) -> None:
        """As ``SixDof``: on the ground at rest, or flying level where above it."""
        self._params = params
        self._states = states = States.at(position, yaw)
        self._runway = Runway(states, terrain)
        self._guide = Guide(params.limits)
        self._drain = Drain(states, params)
        n = len(states.yaw)
        speed = np.full(n, params.limits.trim_m_s) if airspeed is None else np.asarray(airspeed)
        self._air = np.where(states.on_ground, 0.0, speed)
        self._heading = states.yaw.copy()
        self._climb = np.zeros(n)
        self._position = np.array(states.position.T)
        self._velocity = np.zeros((3, n))
        self._write(np.zeros((3, n)))

    @property
    def states(self) -> States:
        return self._states

    def step(self, setpoints: Setpoints, wind: F64, dt_s: float) -> None:
        states, limits, drift = self._states, self._params.limits, wind.T
        running = setpoints.motors & (states.battery > 0.0)
        wanted = self._guide.wanted(setpoints, self._position, self._velocity, self._air, drift)
        ground = states.on_ground.copy()
        stops = self._runway.stopping(setpoints)
        running &= ~stops
        speed = np.maximum(self._air, 0.5 * limits.slowest_m_s)

        answer = 1.0 - np.exp(-dt_s * np.array((ROLL_1_S, CLIMB_1_S, SPEED_1_S)))
        spin = np.clip(
            (wanted.roll - states.roll) * answer[0], -_SPIN_RAD_S * dt_s, _SPIN_RAD_S * dt_s
        )
        roll = np.where(ground, 0.0, states.roll + spin)
        fast = (self._air > limits.rotate_m_s) & ~stops
        attack = self._attack(speed, roll)
        tilted = np.fmin(wanted.pitch - attack * np.cos(roll), wanted.climb)  # NaN: the climb
        aim = np.where(ground, np.where(fast, np.maximum(tilted, 0.05), 0.0), tilted)
        bend = np.clip(
            (aim - self._climb) * answer[1] * speed, -_RISE_M_S2 * dt_s, _RISE_M_S2 * dt_s
        )
        climb = np.where(ground & ~fast, 0.0, self._climb + bend / speed)
        pull = (wanted.airspeed - self._air) * (answer[2] / dt_s)
        pull = np.clip(pull, -limits.slower_m_s2, limits.faster_m_s2)
        glide = -GRAVITY * np.sin(climb) - self._drag(speed, roll) / self._params.mass
        asked = np.maximum(self._params.thrust(wanted.throttle, speed), 0.0)
        driven = np.isfinite(wanted.throttle)
        pull = np.where(driven, glide + asked / self._params.mass, pull)
        change = np.where(running, pull, np.where(ground, 0.0, glide))
        thrust = np.where(running, self._params.mass * (change - glide), 0.0)
        self._air = np.clip(self._air + change * dt_s, 0.0, 1.4 * limits.fastest_m_s)
        turn = np.where(ground, 0.0, -GRAVITY / speed * np.tan(roll))
        self._heading = wrapped(self._heading + turn * dt_s)
        states.rates[:, 0] = np.where(ground, 0.0, spin / dt_s)
        states.rates[:, 1] = bend / (speed * dt_s)
        states.rates[:, 2] = turn
        states.roll[:] = roll
        self._climb = climb
        self._move(drift, running, dt_s)
        states.thrust[:] = np.where(running, self._params.throttle(thrust, self._air), 0.0)
        self._drain.draw(thrust, self._air, dt_s)

    def _move(self, wind: F64, running: Bools, dt_s: float) -> None:
        states = self._states
        before = self._velocity.copy()
        self._write(wind)
        self._position += 0.5 * dt_s * (before + self._velocity)
        down = self._runway.hold(self._position, self._velocity, running, dt_s)
        states.position[:], states.velocity[:] = self._position.T, self._velocity.T
        if down.any():
            rolling = np.hypot(self._velocity[0], self._velocity[1])
            self._air = np.where(down, rolling, self._air)
            self._climb = np.where(down, np.maximum(self._climb, 0.0), self._climb)

    def _write(self, wind: F64) -> None:
        """Velocity and attitude from airspeed, heading and climb in the wind (3, n)."""
        states = self._states
        level = self._air * np.cos(self._climb)
        drift = np.where(states.on_ground, 0.0, wind)
        self._velocity[0] = level * np.cos(self._heading) + drift[0]
        self._velocity[1] = level * np.sin(self._heading) + drift[1]
        self._velocity[2] = self._air * np.sin(self._climb) + drift[2]
        states.velocity[:] = self._velocity.T
        states.yaw[:] = self._heading
        attack = self._attack(self._air, states.roll)
        flying = ~states.on_ground
        states.pitch[:] = np.where(flying, self._climb + attack * np.cos(states.roll), 0.0)
        states.airspeed[:] = self._air

    def _attack(self, speed: F64, roll: F64) -> F64:
        load = GRAVITY / np.maximum(np.cos(roll), 0.3)
        return self._params.trim(np.maximum(speed, 12.0), load, np.zeros(len(speed)))[0]

    def _drag(self, speed: F64, roll: F64) -> F64:
        load = GRAVITY / np.maximum(np.cos(roll), 0.3)
        return self._params.trim(np.maximum(speed, 12.0), load, np.zeros(len(speed)))[2]
