"""Who is there: the vehicles behind a port, before anything is flown.

A scout listens to one system and asks it for what it does not tell unasked; a
survey holds a scout for each system behind a hub. Neither commands anything but
messages.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

from sim_vehicles.codec import Counts, Encoder, decode
from sim_vehicles.geodesy import Geodetic
from uavbridge.clock import SECOND_US
from uavbridge.mavlink.commands import Commands, Order
from uavbridge.mavlink.frames import is_signed
from uavbridge.mavlink.hub import Hub
from uavbridge.mavlink.identity import heartbeat
from uavbridge.mavlink.telemetry import Telemetry
from uavbridge.mavlink.texts import Texts
from uavbridge.mavlink.wishes import Wish, Wishes, once
from uavbridge.vehicle.readiness import Readiness

_FIX_3D: Final = 3
_WISHES: Final = (
    Wish("GLOBAL_POSITION_INT", 4.0),
    Wish("LOCAL_POSITION_NED", 4.0),
    Wish("EXTENDED_SYS_STATE", 1.0),
    Wish("SYS_STATUS", 1.0),
    Wish("GPS_RAW_INT", 1.0),
)
_ROUND_US: Final = 2 * SECOND_US


def place_of(latitude_1e7: int, longitude_1e7: int, altitude_mm: int) -> Geodetic | None:
    """A place in MAVLink's units; None for one that is none, and for 0, 0: no fix yet."""
    if not (latitude_1e7 or longitude_1e7):
        return None
    try:
        return Geodetic(latitude_1e7 * 1e-7, longitude_1e7 * 1e-7, altitude_mm * 1e-3)
    except ValueError:
        return None


@dataclass(frozen=True, slots=True)
class Firmware:
    """What AUTOPILOT_VERSION says."""

    version: tuple[int, int, int]
    kind: int  # FIRMWARE_VERSION_TYPE: 0 development .. 255 release
    revision: str  # first bytes of the source's hash, hexadecimal; "" where not told

    def __str__(self) -> str:
        return ".".join(map(str, self.version)) + ("" if self.kind == 255 else " (no release)")


class Scout:
    """What one system says of itself.

    Args:
        system: its id.
        encoder: packs for this end.
    """

    def __init__(self, system: int, encoder: Encoder) -> None:
        self.system = system
        self.component = 0  # of the autopilot; 0: not heard yet
        self.telemetry = Telemetry(Geodetic(0.0, 0.0, 0.0))
        self.readiness = Readiness(system, self.telemetry)
        self.home: Geodetic | None = None
        self.here: Geodetic | None = None
        """Where it is by its own estimate, or by its GPS while there is none."""
        self._altitude_m: float | None = None  # by its GPS
        self.vehicle_type = 0
        self.firmware: Firmware | None = None
        self.signs = False
        """Its frames are signed: without the key it will not listen."""
        self.counts = Counts()
        self.texts: list[tuple[int, str]] = []
        """(severity, text) of what it said, oldest first."""
        self._encoder = encoder
        self._commands = Commands(encoder, system)
        self._parts = Texts()
        self._wishes = Wishes(_WISHES)
        self._round_us = 0
        self._first: tuple[int, int] | None = None  # (our time us, its time ms)
        self._last: tuple[int, int] | None = None
        self.handlers: dict[str, Callable[[Any, int], None]] = {
            "HOME_POSITION": self._home_position,
            "GLOBAL_POSITION_INT": self._position,
            "GPS_RAW_INT": self._gps,
            "AUTOPILOT_VERSION": self._version,
            "STATUSTEXT": self._text,
        }
        """What to do with a message (message, our time in microseconds), beside telemetry."""

    @property
    def heard(self) -> bool:
        """An autopilot's heartbeat came."""
        return self.component > 0

    @property
    def name(self) -> str:
        """The make, as people call it; empty while it is unknown or not supported."""
        flavour = self.telemetry.flavour
        return "" if isinstance(flavour, str) else flavour.name

    @property
    def start(self) -> Geodetic | None:
        """Its home, or where it is while that is unknown.

        ArduRover sets its home before it knows its height, and never mends it: of rovers the
        height is the GPS's.
        """
        place, flavour = self.home or self.here, self.telemetry.flavour
        drives = not isinstance(flavour, str) and flavour.kind == "rover"
        if place is None or self._altitude_m is None or not drives:
            return place
        return replace(place, altitude_m=self._altitude_m)

    @property
    def rate(self) -> float | None:
        """Seconds of its clock in one second of ours; None before a second was watched."""
        if self._first is None or self._last is None:
            return None
        watched_us = self._last[0] - self._first[0]
        if watched_us < SECOND_US:
            return None
        return (self._last[1] - self._first[1]) * 1000 / watched_us

    def hear(self, datagram: bytes, t_us: int) -> None:
        """Take what came from it."""
        for packet in decode(datagram, self.counts):
            message = packet.message
            self.signs |= is_signed(packet.raw)
            if message.msgname == "HEARTBEAT" and self.component in (0, packet.component):
                self._heartbeat(message, packet.component, t_us)
            elif packet.component == self.component:
                self._message(message, t_us)

    def _heartbeat(self, message: Any, component: int, t_us: int) -> None:
        self.telemetry.handlers["HEARTBEAT"](message, t_us)
        if self.telemetry.heartbeats:
            flavour = self.telemetry.flavour
            if not self.component and not isinstance(flavour, str):
                self._wishes = Wishes((*_WISHES, *flavour.streams))
            self.component = component
            self._commands.component = component
            self.vehicle_type = message.type

    def _message(self, message: Any, t_us: int) -> None:
        name = message.msgname
        boot_ms = getattr(message, "time_boot_ms", None)
        if boot_ms is not None:
            self._watch_clock(t_us, boot_ms)
        known = self.telemetry.handlers.get(name)
        if known is not None:
            known(message, t_us)
        handler = self.handlers.get(name)
        if handler is not None:
            handler(message, t_us)
        if name in self._wishes.heard:
            self._wishes.heard[name] += 1

    def _watch_clock(self, t_us: int, boot_ms: int) -> None:
        if self._first is None or self._last is None or boot_ms < self._first[1]:
            self._first = (t_us, boot_ms)
        self._last = (t_us, boot_ms)

    def _home_position(self, m: Any, t_us: int) -> None:
        self.home = place_of(m.latitude, m.longitude, m.altitude) or self.home

    def _position(self, m: Any, t_us: int) -> None:
        self.here = place_of(m.lat, m.lon, m.alt) or self.here

    def _gps(self, m: Any, t_us: int) -> None:
        if m.fix_type >= _FIX_3D:
            self._altitude_m = m.alt * 1e-3
            self.here = self.here or place_of(m.lat, m.lon, m.alt)

    def _version(self, m: Any, t_us: int) -> None:
        number = m.flight_sw_version
        version = (number >> 24 & 255, number >> 16 & 255, number >> 8 & 255)
        revision = bytes(m.flight_custom_version).rstrip(b"\0").hex()
        self.firmware = Firmware(version, number & 255, revision)

    def _text(self, m: Any, t_us: int) -> None:
        for severity, text in self._parts.hear(m, self.component):
            self.texts.append((severity, text))
            self.readiness.said(severity, text, t_us)

    def due(self, t_us: int) -> list[bytes]:
        """Frames to send now: what is missing is asked for."""
        if not self.component or t_us < self._round_us:
            return []
        self._round_us = t_us + _ROUND_US
        orders: list[Order] = self._wishes.round()
        if self.home is None:
            orders.append(once("HOME_POSITION"))
        if not self.telemetry.frame_exact:
            orders.append(once("GPS_GLOBAL_ORIGIN"))
        if self.firmware is None:
            orders.append(once("AUTOPILOT_VERSION"))
        return [self._commands.frame(order) for order in orders]


class Survey:
    """All systems behind one hub.

    Args:
        hub: read as long as the survey goes on.
        encoder: packs for this end.
    """

    def __init__(self, hub: Hub, encoder: Encoder) -> None:
        self.hub = hub
        self.scouts: dict[int, Scout] = {}
        self._encoder = encoder
        self._call_us = 0

    @property
    def vehicles(self) -> list[Scout]:
        """Those whose autopilot was heard, ascending system ids."""
        return [scout for _, scout in sorted(self.scouts.items()) if scout.heard]

    def step(self, t_us: int) -> None:
        """Hear what came, ask for what is missing."""
        self.hub.read()
        for system, parts in self.hub.take().items():
            scout = self.scouts.get(system)
            if scout is None:
                scout = self.scouts[system] = Scout(system, self._encoder)
            for part in parts:
                scout.hear(part, t_us)
        if t_us >= self._call_us:
            self._call_us = t_us + SECOND_US
            self.hub.call(heartbeat(self._encoder))
        for system, scout in self.scouts.items():
            frames = scout.due(t_us)
            if frames:
                self.hub.send(system, b"".join(frames))
