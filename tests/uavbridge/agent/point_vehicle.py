"""A vehicle at our own seam: a point with a lagging velocity, no MAVLink. For tests."""

import numpy as np
from msgspec.structs import replace

from uavbridge.clock import to_s
from uavbridge.vehicle.api import (
    Arm,
    Disarm,
    Done,
    Follow,
    HoldPosition,
    LandHere,
    Mode,
    Refused,
    ReturnHome,
    SetVelocity,
    TakeOff,
    VehicleState,
)


class PointVehicle:
    """Answers at the next ``advance``; ``refusal`` makes arming, or ``refuses``, fail with it."""

    def __init__(self, position, *, refusal="", refuses=Arm, silent=False, kind="multirotor"):
        self.home = np.array(position, dtype=float)
        self.refusal = refusal
        self.refuses = refuses
        self.silent = silent
        self.commands = []
        self._events = []
        self._wanted = np.zeros(3)
        self._height = 0.0
        self._t_us = 0
        self._state = VehicleState(position=self.home.copy(), mode=Mode.HOLD, kind=kind)

    @property
    def state(self):
        return self._state

    def do(self, command, t_us):
        if isinstance(command, SetVelocity):
            self._wanted = command.velocity
            return
        self.commands.append(command)
        if isinstance(command, self.refuses) and self.refusal:
            self._events.append(Refused(command, self.refusal))
            return
        changes = {
            Arm: {"armed": True},
            Disarm: {"armed": False},
            TakeOff: {"mode": Mode.TAKEOFF},
            Follow: {"mode": Mode.OFFBOARD},
            HoldPosition: {"mode": Mode.HOLD},
            LandHere: {"mode": Mode.LAND},
            ReturnHome: {"mode": Mode.RETURN},
        }[type(command)]
        if isinstance(command, TakeOff):
            self._height = self.home[2] + command.height_m
        self._state = replace(self._state, **changes)
        self._events.append(Done(command))

    def set_mode(self, mode):
        """A pilot takes the sticks."""
        self._state = replace(self._state, mode=mode, mode_text=mode.value)

    def stop_motors(self, battery):
        """By no order of ours."""
        self._state = replace(self._state, armed=False, battery=battery)

    def advance(self, t_us):
        dt = to_s(t_us - self._t_us)
        self._t_us = t_us
        if self.silent:
            self._state = replace(self._state, link_ok=False)
            return ()
        state = self._state
        velocity = self._velocity(state)
        position = state.position + velocity * dt
        landed = position[2] <= self.home[2] + 0.05
        if landed:
            position[2] = self.home[2]
        self._state = replace(
            state,
            t_us=t_us,
            position=position,
            velocity=velocity,
            in_air=not landed,
            armed=state.armed and not (landed and state.mode is Mode.LAND),
            has_position=True,
            link_ok=True,
        )
        events, self._events = tuple(self._events), []
        return events

    def _velocity(self, state):
        if not state.armed:
            return np.zeros(3)
        if state.mode is Mode.TAKEOFF:
            return np.array([0.0, 0.0, np.clip(self._height - state.position[2], -2, 2)])
        if state.mode is Mode.LAND:
            return np.array([0.0, 0.0, -1.0])
        if state.mode is Mode.OFFBOARD:
            return state.velocity + 0.15 * (self._wanted - state.velocity)
        return np.zeros(3)

    def close(self):
        pass
