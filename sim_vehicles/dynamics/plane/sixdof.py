"""Fixed-wing aircraft with six degrees of freedom under their autopilot, all at once."""

from __future__ import annotations

import numpy as np

from planners.terrain import Terrain
from sim_vehicles.dynamics.airframe import GRAVITY
from sim_vehicles.dynamics.model import F64, Bools, Setpoints, States
from sim_vehicles.dynamics.plane.airframe import PlaneParams
from sim_vehicles.dynamics.plane.guide import Guide, Wanted
from sim_vehicles.dynamics.plane.loops import Loops
from sim_vehicles.dynamics.plane.motion import PITCH, POSITION, RATES, ROLL, VELOCITY, YAW, Motion
from sim_vehicles.dynamics.plane.power import Drain
from sim_vehicles.dynamics.plane.runway import Runway

_DEFAULT = PlaneParams()
_LONGEST_S = 0.02  # of a step of the dynamics
_NOSE_UP = 0.17  # rad on the runway when it is fast enough


class SixDof:
    """Aerosonde-like aircraft: guide, inner loops, six degrees of freedom, ground and battery.

    Setpoints are read as in ``guide``. The autopilot runs at every step of at most 0.02 s, the
    equations of motion by Runge-Kutta of fourth order in that step. Motors off, or an empty
    battery: the propeller is folded, and it glides.
    """

    def __init__(
        self,
        position: F64,
        yaw: F64,
        *,
        params: PlaneParams = _DEFAULT,
        terrain: Terrain | None = None,
        airspeed: F64 | None = None,
    ) -> None:
        """Place aircraft: on the ground at rest, or flying level in trim where above it.

        Args:
            position: (n, 3) ENU m.
            yaw: (n,) rad.
            params: the airframe, the same for all.
            terrain: heights of the ground; None: level at 0.
            airspeed: (n,) m/s of those in the air; None: of trim.
        """
        n = len(position)
        self._params = params
        self._states = states = States.at(position, yaw)
        self._state: F64 = np.zeros((12, n))
        self._state[POSITION] = states.position.T
        self._state[YAW] = states.yaw
        states.position, states.velocity = self._state[POSITION].T, self._state[VELOCITY].T
        states.roll, states.pitch = self._state[ROLL], self._state[PITCH]
        states.yaw = self._state[YAW]
        self._runway = Runway(states, terrain)
        self._motion, self._guide = Motion(params), Guide(params.limits)
        self._loops = Loops(params, n)
        self._drain = Drain(states, params)
        speed = np.full(n, params.limits.trim_m_s) if airspeed is None else np.asarray(airspeed)
        self._launch(speed)

    @property
    def states(self) -> States:
        return self._states

    def _launch(self, speed: F64) -> None:
        states = self._states
        up = ~states.on_ground
        level = np.zeros(len(speed))
        attack, _, _ = self._params.trim(speed, level + GRAVITY, level)
        states.velocity[:, 0] = np.where(up, speed * np.cos(states.yaw), 0.0)
        states.velocity[:, 1] = np.where(up, speed * np.sin(states.yaw), 0.0)
        states.pitch[:] = np.where(up, attack, 0.0)
        states.airspeed[:] = np.where(up, speed, 0.0)

    def step(self, setpoints: Setpoints, wind: F64, dt_s: float) -> None:
        count = max(int(np.ceil(dt_s / _LONGEST_S - 1e-9)), 1)
        for _ in range(count):
            self._advance(setpoints, wind.T, dt_s / count)

    def _advance(self, setpoints: Setpoints, wind: F64, dt_s: float) -> None:
        states, state = self._states, self._state
        running = setpoints.motors & (states.battery > 0.0)
        air = state[VELOCITY] - wind
        speed = np.sqrt(air[0] ** 2 + air[1] ** 2 + air[2] ** 2)
        climb = np.arctan2(air[2], np.hypot(air[0], air[1]))
        wanted = self._guide.wanted(setpoints, state[POSITION], state[VELOCITY], speed, wind)
        stops = self._runway.stopping(setpoints)
        running &= ~stops
        self._off_the_ground(wanted, speed, stops)
        controls = self._loops.controls(wanted, state, speed, climb, dt_s)
        controls[3] = np.where(running, controls[3], 0.0)
        state[:] = self._motion.step(state, controls, wind, dt_s)
        state[YAW] = (state[YAW] + np.pi) % (2.0 * np.pi) - np.pi
        self._touch(running, dt_s)
        states.rates[:] = state[RATES].T * (1.0, 1.0, -1.0)
        states.airspeed[:] = speed
        throttle = self._params.throttle(controls[3], speed)
        states.thrust[:] = np.where(running & (controls[3] != 0.0), throttle, 0.0)
        self._drain.draw(controls[3], speed, dt_s)

    def _off_the_ground(self, wanted: Wanted, speed: F64, stops: Bools) -> None:
        """On the runway: wings level, full speed ahead, nose up once it is fast enough."""
        ground = self._states.on_ground
        if ground.any():
            fast = (speed > self._params.limits.rotate_m_s) & ~stops
            wanted.roll[ground] = 0.0
            wanted.pitch[ground] = np.nan
            wanted.climb[ground] = np.where(fast, _NOSE_UP, 0.0)[ground]
            self._loops.rest(ground & ~fast)

    def _touch(self, running: Bools, dt_s: float) -> None:
        state = self._state
        down = self._runway.hold(state[POSITION], state[VELOCITY], running, dt_s)
        if down.any():
            state[ROLL] = np.where(down, 0.0, state[ROLL])
            state[PITCH] = np.where(down, np.clip(state[PITCH], 0.0, _NOSE_UP), state[PITCH])
            state[9] = np.where(down, 0.0, state[9])
            state[11] = np.where(down, 0.0, state[11])
            held = down & ((state[PITCH] <= 0.0) | (state[PITCH] >= _NOSE_UP))
            state[10] = np.where(held, 0.0, state[10])
