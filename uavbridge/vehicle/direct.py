"""A simulated vehicle in this process, driven without bytes.

The mission's frame is the fleet's. Its autopilot is told what a MAVLink vehicle
would be told, at the same times, and refuses in the same words.
"""

from __future__ import annotations

from math import nan
from typing import Final, Protocol

import numpy as np

from sim_vehicles.arming import Refusal
from sim_vehicles.modes import Mode as Flown
from sim_vehicles.squad import Squad
from uavbridge.clock import to_us
from uavbridge.vehicle.api import (
    HIGHEST_M,
    Arm,
    Command,
    Disarm,
    Done,
    Follow,
    HoldPosition,
    LandHere,
    Mode,
    Refused,
    RestoreNet,
    ReturnHome,
    SetNet,
    SetPosition,
    SetVelocity,
    TakeOff,
    VehicleEvent,
    VehicleState,
)

SETPOINT_LIFE_US: Final = to_us(0.5)
_SECOND_US: Final = to_us(1.0)
_MODES: Final = {
    Flown.MANUAL: Mode.MANUAL,
    Flown.ALTITUDE: Mode.MANUAL,
    Flown.POSITION: Mode.MANUAL,
    Flown.TAKEOFF: Mode.TAKEOFF,
    Flown.HOLD: Mode.HOLD,
    Flown.MISSION: Mode.MISSION,
    Flown.RETURN: Mode.RETURN,
    Flown.LAND: Mode.LAND,
    Flown.OFFBOARD: Mode.OFFBOARD,
}
_ASKED: Final[dict[type[Command], Flown]] = {
    HoldPosition: Flown.HOLD,
    LandHere: Flown.LAND,
    ReturnHome: Flown.RETURN,
}


class DirectFleet(Protocol):
    """What is needed of ``sim_vehicles.fleet.Fleet``."""

    def seat(self, index: int) -> tuple[Squad, int]:
        """The squad of a vehicle, and its row there."""
        ...


class DirectVehicle:
    """Vehicle ``index`` of a fleet. Whoever owns the fleet lets its time pass.

    Args:
        fleet: the simulated vehicles.
        index: which one, from 0.
    """

    def __init__(self, fleet: DirectFleet, index: int) -> None:
        squad, self._index = fleet.seat(index)
        self._pilot = squad.pilot
        self._states = squad.states
        self._now_us = 0
        self._heartbeat_us = 0
        self._setpoint: SetVelocity | SetPosition | None = None
        self._setpoint_until_us = 0
        self._events: list[VehicleEvent] = []
        self._state: VehicleState | None = None

    @property
    def state(self) -> VehicleState:
        if self._state is None:
            self._state = self._look()
        return self._state

    def _look(self) -> VehicleState:
        i, pilot, states = self._index, self._pilot, self._states
        mode = Flown(int(pilot.status.mode[i]))
        armed = bool(pilot.status.armed[i])
        reason = None if armed else pilot.why_not_arm(i)
        return VehicleState(
            t_us=self._now_us,
            position=states.position[i].copy(),
            velocity=states.velocity[i].copy(),
            heading_rad=float(states.yaw[i]),
            mode=_MODES[mode],
            mode_text=pilot.modes[mode].name,
            armed=armed,
            in_air=not pilot.status.landed[i],
            battery=float(states.battery[i]),
            has_position=bool(pilot.now_us >= pilot.status.ready_us[i]),
            link_ok=True,
            waiting_for=() if reason is None else (reason,),
        )

    def do(self, command: Command, t_us: int) -> None:
        """Ask for something; it takes effect at once, the next ``advance`` tells of it.

        Raises:
            ValueError: a setpoint that is not finite.
        """
        if isinstance(command, SetVelocity | SetPosition):
            wanted = command.velocity if isinstance(command, SetVelocity) else command.position
            if not np.isfinite(wanted).all():
                raise ValueError(f"a setpoint must be finite, not {wanted}")
            self._setpoint = command
            self._setpoint_until_us = t_us + SETPOINT_LIFE_US
            self._follow(command)
            return
        refusal = self._ask(command, t_us)
        self._events.append(Done(command) if refusal is None else Refused(command, refusal.reason))

    def _ask(self, command: Command, t_us: int) -> Refusal | None:
        pilot, i = self._pilot, self._index
        if isinstance(command, Arm):
            return pilot.arm(i)
        if isinstance(command, Disarm):
            return pilot.disarm(i)
        if isinstance(command, Follow):
            if self._setpoint is None:
                self._setpoint = SetVelocity(np.zeros(3))
                self._setpoint_until_us = t_us + SETPOINT_LIFE_US
            self._follow(self._setpoint)
            return pilot.change_mode(i, Flown.OFFBOARD)
        if isinstance(command, SetNet | RestoreNet):
            return None  # who drives it without bytes is gone with it
        self._setpoint = None
        if isinstance(command, TakeOff):
            if not 0.0 < command.height_m <= HIGHEST_M:
                return Refusal(f"{command.height_m} m is no height to take off to")
            pilot.parameters.set(i, "MIS_TAKEOFF_ALT", command.height_m)
            return pilot.take_off(i)
        return pilot.change_mode(i, _ASKED[type(command)])

    def _follow(self, setpoint: SetVelocity | SetPosition) -> None:
        yaw = nan if setpoint.yaw_rad is None else setpoint.yaw_rad
        if isinstance(setpoint, SetVelocity):
            vx, vy, vz = setpoint.velocity.tolist()
            asked = (nan, nan, nan, vx, vy, vz, yaw, nan)
        else:
            x, y, z = setpoint.position.tolist()
            asked = (x, y, z, nan, nan, nan, yaw, nan)
        self._pilot.follow(self._index, asked)

    def advance(self, t_us: int) -> tuple[VehicleEvent, ...]:
        self._now_us = t_us
        self._state = None
        if t_us >= self._heartbeat_us:
            self._heartbeat_us = t_us + _SECOND_US
            self._pilot.heard_gcs(self._index)
        if self._setpoint is not None:
            if t_us <= self._setpoint_until_us:
                self._follow(self._setpoint)
            else:
                self._setpoint = None
        events, self._events = self._events, []
        return tuple(events)

    def close(self) -> None:
        self._setpoint = None
