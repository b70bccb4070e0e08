"""One vehicle's MAVLink side: hands each packet to the service that knows it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

from sim_vehicles.autopilot import Autopilot
from sim_vehicles.codec import Encoder, Packet, mav
from sim_vehicles.craft import Craft
from sim_vehicles.flavour import Flavour
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.protocol.items import Item
from sim_vehicles.report import Report
from sim_vehicles.telemetry import Telemetry

COMPONENT: Final[int] = mav.MAV_COMP_ID_AUTOPILOT1
_TEXT_BYTES: Final = 50


@dataclass(frozen=True, slots=True, eq=False)
class Services:
    """What all vehicles of a fleet share."""

    pilot: Autopilot
    telemetry: Telemetry
    report: Report
    origin: Geodetic  # of the fleet frame

    @property
    def craft(self) -> Craft:
        """What the vehicles are."""
        return self.pilot.craft

    @property
    def flavour(self) -> Flavour:
        """How they say things."""
        return self.pilot.craft.flavour


@dataclass(slots=True)
class Upload:
    """A mission on its way in."""

    peer: tuple[int, int]  # system and component that send it
    mission_type: int
    count: int
    items: list[Item]
    asked_us: int  # the newest request
    heard_us: int  # the newest item


@dataclass(slots=True, eq=False)
class Endpoint:
    """Vehicle ``index`` towards its MAVLink peers.

    Attributes:
        out: frames to be sent, oldest first.
        busy: has timers running, wants ``tick``.
    """

    index: int
    services: Services
    encoder: Encoder
    out: list[bytes] = field(default_factory=list)
    busy: bool = False
    stored: dict[int, tuple[Item, ...]] = field(default_factory=dict)  # mission type -> items
    upload: Upload | None = None
    uploaded: tuple[tuple[int, int], int, int] | None = None  # newest: peer, type, count
    next_parameter: int | None = None  # of a list being sent
    texts: int = 0  # long ones sent

    @property
    def system(self) -> int:
        return self.encoder.system

    @property
    def pilot(self) -> Autopilot:
        return self.services.pilot

    @property
    def now_us(self) -> int:
        return self.services.pilot.now_us

    def send(self, name: str, **fields: Any) -> None:
        """Queue a message."""
        self.out.append(self.encoder.pack(name, **fields))

    def say(self, severity: int, text: str) -> None:
        """Queue a text, in chunks if it is long."""
        data = text.encode()
        if len(data) <= _TEXT_BYTES:
            self.send("STATUSTEXT", severity=severity, text=data)
            return
        self.texts = self.texts % 0xFFFF + 1
        for chunk, start in enumerate(range(0, len(data), _TEXT_BYTES)):
            part = data[start : start + _TEXT_BYTES]
            self.send("STATUSTEXT", severity=severity, text=part, id=self.texts, chunk_seq=chunk)

    def show(self, name: str) -> bool:
        """Queue a telemetry message as it is now; whether there is such a one."""
        services = self.services
        services.report.update()
        snapshot = services.report.snapshot
        frame = services.telemetry.one(self.index, name, self.now_us, snapshot)
        if frame is not None:
            self.out.append(frame)
        return frame is not None

    def handle(self, packet: Packet, handlers: Handlers) -> None:
        """Do what a packet asks, if it is for this vehicle."""
        message = packet.message
        handler = handlers.get(message.msgname)
        if handler is None or (packet.system == self.system and packet.component == COMPONENT):
            return
        if getattr(message, "target_system", 0) not in (0, self.system):
            return
        if getattr(message, "target_component", 0) not in (0, COMPONENT):
            return
        handler(self, packet)


Handler: TypeAlias = Callable[[Endpoint, Packet], None]
Handlers: TypeAlias = dict[str, Handler]
