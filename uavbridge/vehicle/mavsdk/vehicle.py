"""A vehicle driven by MAVSDK.

Its plugins block until the autopilot answers, so one thread a vehicle makes the calls, one
after the other; ``advance`` collects results and asks for telemetry's newest values, which
MAVSDK keeps (no callbacks: of those it drops some when it is busy). Its offboard plugin
repeats the last setpoint for ever; the station holds those back that nobody renewed.
"""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from math import degrees, isfinite, radians
from typing import Any, Final

import numpy as np

from sim_vehicles.codec import Encoder
from sim_vehicles.geodesy import Geodetic
from uavbridge.clock import to_us
from uavbridge.mavlink.commands import Commands
from uavbridge.mavlink.identity import COMPONENT, SYSTEM
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.local_frame import LocalFrame, heading_to_yaw
from uavbridge.mavlink.wishes import ROUND_S, STREAMS, Wish, Wishes
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
    ReturnHome,
    Said,
    SetPosition,
    SetVelocity,
    TakeOff,
    VehicleEvent,
    VehicleState,
)
from uavbridge.vehicle.mavsdk.plugins import Plugins, Seen, call_of
from uavbridge.vehicle.mavsdk.station import SHARED

SETPOINT_LIFE_US: Final = to_us(0.5)
_CONFIRM_US: Final = to_us(4.0)
_EXPLAIN_US: Final = to_us(0.5)
_ORIGIN_US: Final = to_us(2.0)
_ROUND_US: Final = to_us(ROUND_S)
_WISHES: Final = (*STREAMS, Wish("ATTITUDE", 4.0))  # ArduPilot sends none of them unasked
_MODES: Final = {
    "TAKEOFF": Mode.TAKEOFF,
    "READY": Mode.HOLD,
    "HOLD": Mode.HOLD,
    "MISSION": Mode.MISSION,
    "RETURN_TO_LAUNCH": Mode.RETURN,
    "LAND": Mode.LAND,
    "OFFBOARD": Mode.OFFBOARD,
    "FOLLOW_ME": Mode.UNKNOWN,
    "UNKNOWN": Mode.UNKNOWN,
}
_SHOWN: Final[dict[type, Mode]] = {
    TakeOff: Mode.TAKEOFF,
    Follow: Mode.OFFBOARD,
    HoldPosition: Mode.HOLD,
    LandHere: Mode.LAND,
    ReturnHome: Mode.RETURN,
}
_ENDED: Final = frozenset({Mode.LAND, Mode.RETURN})
_SEVERITIES: Final = {
    "EMERGENCY": 0, "ALERT": 1, "CRITICAL": 2, "ERROR": 3,
    "WARNING": 4, "NOTICE": 5, "INFO": 6, "DEBUG": 7,
}  # fmt: skip
_TROUBLE: Final = 4


@dataclass(slots=True)
class _Asked:
    command: Command
    answer: Future[None]
    until_us: int = 0  # to be shown by then, once answered


class MavsdkVehicle:
    """One vehicle; the same link, id and origin as ``MavlinkVehicle`` takes.

    Args:
        link: carries the datagrams; closed with the vehicle.
        system: the vehicle's system id.
        origin: the mission's home, where the mission's ENU frame is zero.
        link_timeout_s: silence after which ``link_ok`` is False.

    Raises:
        ConfigError: MAVSDK 4 is not installed.
        VehicleError: it is driven by MAVSDK already.
    """

    def __init__(
        self, link: Link, system: int, *, origin: Geodetic, link_timeout_s: float = 3.0
    ) -> None:
        self.system = system
        self._link, self._origin = link, origin
        self._timeout_us = to_us(link_timeout_s)
        self._station = SHARED.take()
        self._station.join(system, link)
        self._worker = ThreadPoolExecutor(1, thread_name_prefix=f"mavsdk-{system}")
        self._plugins: Plugins | None = None
        self._asked: list[_Asked] = []
        self._events: deque[VehicleEvent] = deque()
        self._frame: LocalFrame | None = None
        self._origin_asked: Future[Any] | None = None
        self._origin_us = 0
        self._wishes, self._round_us = Wishes(_WISHES), 0
        self._commands = Commands(Encoder(SYSTEM, COMPONENT), system)
        self._setpoint_until_us = 0
        self._now_us = 0
        self._heard_us = -to_us(1e6)
        self._complaints: deque[str] = deque(maxlen=4)
        self.state = VehicleState(waiting_for=("no heartbeat yet",))
        """Newest knowledge."""

    def do(self, command: Command, t_us: int) -> None:
        """Ask for something; a setpoint is taken over at once.

        Raises:
            ValueError: a setpoint that is not finite.
        """
        if isinstance(command, SetVelocity | SetPosition):
            self._follow(command, t_us)
            return
        plugins = self._plugins
        if plugins is None:
            self._events.append(Refused(command, "no heartbeat yet"))
            return
        if isinstance(command, TakeOff) and not 0.0 < command.height_m <= HIGHEST_M:
            reason = f"{command.height_m} m is no height to take off to"
            self._events.append(Refused(command, reason))
            return
        if isinstance(command, Follow):
            self._station.mute(self.system, False)
            self._setpoint_until_us = t_us + SETPOINT_LIFE_US
        answer = self._worker.submit(call_of(plugins, command, radians_to_degrees(self.state)))
        self._asked.append(_Asked(command, answer))

    def _follow(self, setpoint: SetVelocity | SetPosition, t_us: int) -> None:
        wanted = setpoint.velocity if isinstance(setpoint, SetVelocity) else setpoint.position
        yaw = setpoint.yaw_rad
        if not np.isfinite(wanted).all() or (yaw is not None and not isfinite(yaw)):
            raise ValueError(f"a setpoint must be finite, not {wanted}")
        if self._plugins is None:
            return
        heading = radians_to_degrees(self.state) if yaw is None else degrees(heading_to_yaw(yaw))
        x, y, z = (float(part) for part in wanted)
        frame = self._frame
        if isinstance(setpoint, SetVelocity):
            n, e, d = (y, x, -z) if frame is None else frame.velocity_to_local(x, y, z)
            self._plugins.velocity(n, e, d, heading)
        elif frame is not None:
            n, e, d = frame.to_local(x, y, z)
            self._plugins.position(n, e, d, heading)
        else:
            return
        self._setpoint_until_us = t_us + SETPOINT_LIFE_US
        self._station.mute(self.system, False)

    def advance(self, t_us: int) -> tuple[VehicleEvent, ...]:
        self._now_us = t_us
        if t_us > self._setpoint_until_us and not any(
            isinstance(asked.command, Follow) for asked in self._asked
        ):
            self._station.mute(self.system, True)
        if self._station.exchange(self._link):
            self._heard_us = t_us
        if self._plugins is None:
            found = self._station.system(self.system)
            if found is None:
                return self._take()
            self._plugins = Plugins(found, self._said)
        self._find_origin(self._plugins, t_us)
        self._ask_for_streams(t_us)
        self.state = self._look(self._plugins, t_us)
        for asked in list(self._asked):
            self._judge(asked, t_us)
        return self._take()

    def _take(self) -> tuple[VehicleEvent, ...]:
        events = []
        while self._events:  # MAVSDK's thread may add to it meanwhile
            events.append(self._events.popleft())
        return tuple(events)

    def _said(self, text: Any, _user_data: Any) -> None:
        severity = _SEVERITIES.get(text.type.name, 6)
        if severity <= _TROUBLE:
            self._complaints.append(text.text)
        self._events.append(Said(severity, text.text))

    def _find_origin(self, plugins: Plugins, t_us: int) -> None:
        if self._frame is not None:
            return
        asked = self._origin_asked
        if asked is None:
            if t_us >= self._origin_us:
                self._origin_us = t_us + _ORIGIN_US
                self._origin_asked = self._worker.submit(plugins.origin)
        elif asked.done():
            self._origin_asked = None
            if asked.exception() is None:
                self._frame = LocalFrame(asked.result(), self._origin)

    def _ask_for_streams(self, t_us: int) -> None:
        if t_us >= self._round_us:
            self._round_us = t_us + _ROUND_US
            for order in self._wishes.round():
                self._link.send(self._commands.frame(order))

    def _look(self, plugins: Plugins, t_us: int) -> VehicleState:
        seen = plugins.look()
        mode_text, armed = seen.mode, seen.armed
        position, velocity = self._motion(seen)
        connected = seen.connected and t_us - self._heard_us <= self._timeout_us
        waiting: list[str] = []
        if not connected:
            waiting.append(f"silent for {(t_us - self._heard_us) / 1e6:.1f} s")
        elif not armed:
            if self._frame is None:
                waiting.append("origin of its local frame not known yet")
            if not seen.armable:
                said = "; ".join(self._complaints)
                waiting.append("pre-arm checks fail" + (f": {said}" if said else ""))
        return VehicleState(
            t_us=self._heard_us,
            position=position,
            velocity=velocity,
            heading_rad=heading_to_yaw(radians(seen.heading_deg)),
            mode=_MODES.get(mode_text, Mode.MANUAL),
            mode_text=mode_text,
            armed=armed,
            in_air=seen.in_air,
            battery=seen.battery,
            has_position=self._frame is not None and bool(seen.place),
            link_ok=connected,
            waiting_for=tuple(waiting),
        )

    def _motion(self, seen: Seen) -> tuple[Any, Any]:
        frame = self._frame
        if frame is None or not seen.place:
            return np.zeros(3), np.zeros(3)
        n, e, d, vn, ve, vd = seen.place
        return np.array(frame.to_mission(n, e, d)), np.array(frame.velocity_to_mission(vn, ve, vd))

    def _judge(self, asked: _Asked, t_us: int) -> None:
        if not asked.answer.done():
            return
        fault = asked.answer.exception()
        if fault is not None:
            if not asked.until_us:  # texts that say why may come after the answer
                asked.until_us = t_us + _EXPLAIN_US
            elif t_us > asked.until_us:
                self._asked.remove(asked)
                self._events.append(Refused(asked.command, self._reason(fault)))
        elif self._shown(asked.command):
            self._asked.remove(asked)
            self._complaints.clear()
            self._events.append(Done(asked.command))
        elif not asked.until_us:
            asked.until_us = t_us + _CONFIRM_US
        elif t_us > asked.until_us:
            self._asked.remove(asked)
            reason = f"accepted, but not done: mode is {self.state.mode_text}"
            self._events.append(Refused(asked.command, reason))

    def _reason(self, fault: BaseException) -> str:
        reason = getattr(getattr(fault, "result", None), "name", str(fault))
        said = "; ".join(dict.fromkeys(self._complaints))
        return reason.lower().replace("_", " ") + (f": {said}" if said else "")

    def _shown(self, command: Command) -> bool:
        """The heartbeat shows what was asked for."""
        state = self.state
        if isinstance(command, Arm | Disarm):
            return state.armed == isinstance(command, Arm)
        mode = _SHOWN.get(type(command))
        if mode is None or state.mode is mode:
            return True
        if isinstance(command, TakeOff) and self._plugins and self._plugins.is_ardupilot:
            return state.mode is Mode.OFFBOARD
        return mode in _ENDED and not state.armed

    def close(self) -> None:
        self._worker.shutdown(wait=True, cancel_futures=True)
        self._station.leave(self.system)
        self._plugins = None
        SHARED.give_back()
        self._link.close()


def radians_to_degrees(state: VehicleState) -> float:
    """The present heading, from north, clockwise."""
    return degrees(heading_to_yaw(state.heading_rad))
