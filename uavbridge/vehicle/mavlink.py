"""A vehicle behind a MAVLink link: PX4, ArduPilot, or our simulator."""

from __future__ import annotations

import logging
from collections.abc import Callable
from math import inf
from typing import Any, Final

from sim_vehicles.codec import Counts, Encoder, decode, mav
from sim_vehicles.geodesy import Geodetic
from uavbridge.clock import to_us
from uavbridge.mavlink.commands import Commands, Order
from uavbridge.mavlink.exchange import Patience
from uavbridge.mavlink.flavour import Flavour
from uavbridge.mavlink.identity import COMPONENT, SYSTEM, heartbeat
from uavbridge.mavlink.landings import Landings
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.parameters import Parameters
from uavbridge.mavlink.reposition import Repositions
from uavbridge.mavlink.setpoints import Setpoint, setpoint_of, standstill
from uavbridge.mavlink.telemetry import Telemetry
from uavbridge.mavlink.texts import Texts
from uavbridge.mavlink.wishes import ROUND_S, STREAMS, Wishes, once
from uavbridge.vehicle.api import (
    HIGHEST_M,
    Arm,
    Command,
    Disarm,
    Follow,
    Mode,
    RestoreNet,
    Said,
    SetNet,
    SetPosition,
    SetVelocity,
    TakeOff,
    VehicleEvent,
    VehicleState,
)
from uavbridge.vehicle.errands import Errands
from uavbridge.vehicle.readiness import Readiness
from uavbridge.vehicle.safety_net import SafetyNet

logger = logging.getLogger(__name__)

SETPOINT_LIFE_US: Final = to_us(0.5)
SETPOINT_PERIOD_US: Final = to_us(0.2)
_SECOND_US = to_us(1.0)
_ROUND_US = to_us(ROUND_S)
_CRITICAL, _WARNING = 2, 4
_REORDERED = 128  # numbers by which a frame may have been overtaken
_SELDOM = 8  # rounds between two questions that stay unanswered, at most
_NET_PATIENCE = Patience(tries=18, retry_s=0.5)


class MavlinkVehicle:
    """One vehicle, told apart from others on the link by its system id.

    To the autopilot this end is a ground station (MAV_TYPE_GCS) with ids 245/190,
    that shows itself once a second of mission time: an autopilot that no longer
    hears it may take its data-link-loss action.

    Args:
        link: carries the datagrams; closed with the vehicle.
        system: the vehicle's system id.
        origin: the mission's home, where the mission's ENU frame is zero.
        link_timeout_s: silence after which ``link_ok`` is False.
        source: system and component id of this end.
        twins: asked for the places from which this system is heard, if there are several.
    """

    def __init__(
        self,
        link: Link,
        system: int,
        *,
        origin: Geodetic,
        link_timeout_s: float = 3.0,
        source: tuple[int, int] = (SYSTEM, COMPONENT),
        twins: Callable[[], tuple[str, ...]] = tuple,
    ) -> None:
        self.system = system
        self.counts = Counts()
        """What was good and bad of all that came over the link."""
        self.strangers = 0
        """Good packets that were of other systems, or of others than the autopilot."""
        self._link = link
        self._source = source
        self._timeout_us = to_us(link_timeout_s)
        self._encoder = Encoder(*source)
        self._component = 0  # 0: no autopilot heard yet
        self._telemetry = Telemetry(origin)
        self._commands = Commands(self._encoder, system)
        self._parameters = Parameters(self._encoder, system)
        self._landings = Landings(self._encoder, system, self._telemetry.runway)
        self._errands = Errands(self._commands, self._parameters, self._landings, self._telemetry)
        self._net_next: SetNet | RestoreNet | None = None  # waits for the landing of before
        self._net_parameters = Parameters(self._encoder, system, patience=_NET_PATIENCE)
        self.net = SafetyNet(self._net_parameters)
        self._readiness = Readiness(system, self._telemetry)
        self._wishes = Wishes()
        self._texts = Texts()
        self._places = Repositions(origin)
        self._twins = twins
        self._twins_told: tuple[str, ...] = ()
        self._beat = (0, -_SECOND_US)  # number and time of the newest heartbeat
        self._handlers: dict[str, Callable[[Any, int], None]] = self._telemetry.handlers | {
            "COMMAND_ACK": self._ack,
            "PARAM_VALUE": self._parameter,
            "MISSION_COUNT": self._mission,
            "MISSION_ITEM_INT": self._mission,
            "MISSION_REQUEST": self._mission,
            "MISSION_REQUEST_INT": self._mission,
            "MISSION_ACK": self._mission,
        }
        self._now_us = 0
        self._heard_us: float = -inf
        self._heartbeat_us = 0
        self._round_us = 0
        self._asked_once = 0
        self._restarts = 0
        self._setpoint: Setpoint | None = None
        self._setpoint_until_us = 0
        self._setpoint_due_us = 0
        self._said: list[VehicleEvent] = []
        self._state: VehicleState | None = None

    @property
    def parameters(self) -> dict[str, float]:
        """The autopilot's parameters heard so far."""
        return dict(self._parameters.values)

    @property
    def state(self) -> VehicleState:
        if self._state is None:
            silent_us = self._now_us - self._heard_us
            link_ok = silent_us <= self._timeout_us
            waiting_for = self._readiness.waiting_for(self._now_us, None if link_ok else silent_us)
            stale = self._now_us - self._telemetry.position_us > self._timeout_us
            self._state = self._telemetry.state(
                link_ok=link_ok, waiting_for=waiting_for, stale=stale
            )
        return self._state

    def do(self, command: Command, t_us: int) -> None:
        """Ask for something; a setpoint goes out at once.

        Raises:
            ValueError: a setpoint that is not finite.
        """
        flavour = self._telemetry.flavour
        if isinstance(command, SetVelocity | SetPosition):
            if not isinstance(flavour, str) and flavour.repositions:
                self._reposition(command, t_us)
                return
            self._setpoint = setpoint_of(command, self._telemetry.frame)
            if self._setpoint is not None:
                self._setpoint_until_us = t_us + SETPOINT_LIFE_US
                self._link.send(self._setpoint_frame(t_us))
            return
        if isinstance(flavour, str):
            self._errands.refuse(command, flavour)
            return
        if isinstance(command, SetNet | RestoreNet):
            if self._net_next is None and self.net.idle:
                self._before_net(command, flavour, t_us)
            return
        if isinstance(command, TakeOff) and not 0.0 < command.height_m <= HIGHEST_M:
            self._errands.refuse(command, f"{command.height_m} m is no height to take off to")
            return
        if not isinstance(command, Arm | Disarm | Follow):
            self._setpoint = None
        self._errands.start(command, flavour.plan(command), t_us)

    def _before_net(self, command: SetNet | RestoreNet, flavour: Flavour, t_us: int) -> None:
        """What an earlier flight left is put away."""
        self._net_next = command
        telemetry = self._telemetry
        sets_out = isinstance(command, SetNet) and telemetry.mode is not Mode.MANUAL
        if not telemetry.armed and (sets_out or flavour.lands_by_mission):
            for order in flavour.stand_by:
                self._commands.ask(order, t_us)
        if flavour.lands_by_mission:
            self._landings.remove(t_us)

    def _start_net(self, command: SetNet | RestoreNet, t_us: int) -> None:
        flavour = self._telemetry.flavour
        if isinstance(command, RestoreNet):
            self.net.restore(t_us)
        elif not isinstance(flavour, str):
            self.net.start(command, flavour.net(command.net), t_us)

    def advance(self, t_us: int) -> tuple[VehicleEvent, ...]:
        self._now_us = t_us
        self._state = None
        for datagram in self._link.receive():
            self._hear(datagram, t_us)
        out: list[bytes] = []
        if t_us >= self._heartbeat_us:
            self._heartbeat_us = t_us + _SECOND_US
            out.append(heartbeat(self._encoder))
            self._look_for_twins()
        if self._component and t_us >= self._round_us:
            self._round_us = t_us + _ROUND_US
            out += [self._commands.frame(order) for order in self._wanted()]
        events = self._said
        if events:
            self._said = []
        if not self._errands.idle:
            told, frames = self._errands.advance(t_us)
            events = events + told
            out += frames
        if self._net_next is not None and not self._landings.busy:
            self._start_net(self._net_next, t_us)
            self._net_next = None
        if not self.net.idle:
            told, frames = self.net.advance(t_us)
            events = events + told
            out += frames
        self._stream(t_us, out)
        if out:
            self._link.send(b"".join(out))
        return tuple(events)

    def close(self) -> None:
        self._link.close()

    def _hear(self, datagram: bytes, t_us: int) -> None:
        handlers, heard = self._handlers, self._wishes.heard
        for packet in decode(datagram, self.counts):
            name = packet.message.msgname
            if packet.system != self.system:
                self.strangers += 1
            elif packet.component == self._component:
                self._heard_us = t_us
                if name == "HEARTBEAT" and self._overtaken(packet.sequence, t_us):
                    continue
                handler = handlers.get(name)
                if handler is not None:
                    handler(packet.message, t_us)
                    if name in heard:
                        heard[name] += 1
                elif name == "STATUSTEXT":
                    self._say(packet.message, packet.component, t_us)
            elif name == "STATUSTEXT":
                self._say(packet.message, packet.component, t_us)
            elif not self._component and name == "HEARTBEAT":
                self._meet(packet.message, packet.component, t_us)
            else:
                self.strangers += 1
        if len(self._telemetry.restarts_us) != self._restarts:
            self._restarted()

    def _overtaken(self, sequence: int, t_us: int) -> bool:
        """A heartbeat that was sent before one heard already: what it says is over."""
        age = (self._beat[0] - sequence) & 255
        late = 0 < age < _REORDERED and t_us - self._beat[1] < _SECOND_US
        if not late:
            self._beat = (sequence, t_us)
        return late

    def _meet(self, heartbeat: Any, component: int, t_us: int) -> None:
        """The first heartbeat: is it the autopilot, and which one?"""
        self._telemetry.handlers["HEARTBEAT"](heartbeat, t_us)
        if not self._telemetry.heartbeats:
            return
        self._component = component
        self._heard_us = t_us
        self._commands.component = component
        flavour = self._telemetry.flavour
        self._landings.component = component
        for parameters in (self._parameters, self._net_parameters):
            parameters.component = component
            if not isinstance(flavour, str):
                parameters.bytewise = flavour.bytewise_parameters
        if not isinstance(flavour, str) and flavour.streams:
            self._wishes = Wishes((*STREAMS, *flavour.streams))

    def _look_for_twins(self) -> None:
        places = self._twins()
        if places != self._twins_told:
            self._twins_told = places
            text = f"two vehicles have system id {self.system}: {' and '.join(places)}"
            self._said.append(Said(_CRITICAL, text))

    def _restarted(self) -> None:
        self._restarts = len(self._telemetry.restarts_us)
        self._readiness.forget()
        self._setpoint = None
        self._round_us = self._now_us
        self._asked_once = 0
        self._said.append(Said(_WARNING, f"system {self.system} has restarted"))

    def _reposition(self, setpoint: SetVelocity | SetPosition, t_us: int) -> None:
        """What this vehicle takes for a setpoint, in the mode that is ours alone."""
        if self._telemetry.mode is not Mode.OFFBOARD:
            self._places.forget()
            return
        x, y, z = self.state.position.tolist()
        order = self._places.order(setpoint, (x, y, z), t_us)
        if order is not None:
            self._link.send(self._commands.frame(order))

    def _parameter(self, message: Any, t_us: int) -> None:
        self._parameters.hear(message, t_us)
        self.net.hear(message, t_us)

    def _ack(self, message: Any, t_us: int) -> None:
        if self._is_for_us(message):
            self._commands.hear(message, t_us)

    def _mission(self, message: Any, t_us: int) -> None:
        if self._is_for_us(message):
            self._landings.hear(message, t_us)

    def _is_for_us(self, message: Any) -> bool:
        system, component = self._source
        return message.target_system in (0, system) and message.target_component in (0, component)

    def _say(self, message: Any, component: int, t_us: int) -> None:
        for severity, text in self._texts.hear(message, component):
            self._said.append(Said(severity, text))
            self._errands.said(severity, text, t_us)
            self._readiness.said(severity, text, t_us)

    def _wanted(self) -> list[Order]:
        """What to ask the autopilot for in this round."""
        orders = self._wishes.round()
        telemetry = self._telemetry
        if not (telemetry.frame_exact and telemetry.has_home):
            self._asked_once += 1
            asked = self._asked_once
            if asked & (asked - 1) == 0 or asked % _SELDOM == 0:
                orders += [once("GPS_GLOBAL_ORIGIN"), once("HOME_POSITION")]
        return orders

    def _stream(self, t_us: int, out: list[bytes]) -> None:
        """Repeat the setpoint while it lives; lead into offboard with a standstill."""
        if self._errands.leading:
            self._setpoint = self._setpoint or standstill()
            self._setpoint_until_us = t_us + SETPOINT_LIFE_US
        if self._setpoint is None:
            return
        if t_us > self._setpoint_until_us:
            self._setpoint = None
        elif t_us > self._setpoint_due_us:
            out.append(self._setpoint_frame(t_us))

    def _setpoint_frame(self, t_us: int) -> bytes:
        self._setpoint_due_us = t_us + SETPOINT_PERIOD_US
        return self._encoder.pack(
            "SET_POSITION_TARGET_LOCAL_NED",
            time_boot_ms=t_us // 1000 & 0xFFFFFFFF,
            target_system=self.system,
            target_component=self._commands.component,
            coordinate_frame=mav.MAV_FRAME_LOCAL_NED,
            **(self._setpoint or standstill()),
        )
