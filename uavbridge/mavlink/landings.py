"""A landing for aircraft that land by a mission alone: looked for, uploaded, taken away again.

Sans-I/O, one job at a time. A landing that an operator has put into the autopilot's mission
(DO_LAND_START) is left as it is and serves; a mission without one is left alone, too, and
refuses the job. Only where there is nothing, or a landing of this kind, one is uploaded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from math import cos, sin
from typing import Any, Final, TypeAlias

from sim_vehicles.codec import Encoder, mav
from sim_vehicles.geodesy import Geodetic
from uavbridge.mavlink.commands import Verdict
from uavbridge.mavlink.exchange import Event, Exchange, Patience, State
from uavbridge.mavlink.local_frame import shifted

APPROACH_M: Final = 400.0  # from where it comes down in circles to where it touches down
HEIGHT_M: Final = 35.0  # to which it comes down there: five degrees to the ground
_ABORT_M: Final = 33.0  # height of a landing broken off; also how we know our own
_START, _CIRCLE, _LAND = (
    int(mav.MAV_CMD_DO_LAND_START),
    int(mav.MAV_CMD_NAV_LOITER_TO_ALT),
    int(mav.MAV_CMD_NAV_LAND),
)
_MISSION: Final = int(mav.MAV_MISSION_TYPE_MISSION)
_FRAME: Final = int(mav.MAV_FRAME_GLOBAL_RELATIVE_ALT)
_PATIENCE: Final = Patience(tries=18, retry_s=0.5)
_MOST: Final = 1000  # items of a mission that is looked through


@dataclass(frozen=True, slots=True)
class Item:
    """One item of a mission: command, parameters 1 to 4, place (None: nowhere), height in m."""

    command: int
    params: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    place: Geodetic | None = None
    height_m: float = 0.0


@dataclass(frozen=True, slots=True)
class Runway:
    """Where an aircraft lands.

    Attributes:
        place: of touch-down.
        heading_rad: of the landing, from north, clockwise.
    """

    place: Geodetic
    heading_rad: float

    def items(self) -> tuple[Item, ...]:
        """The landing: down in circles before the runway, then straight to the ground."""
        back_n, back_e = -APPROACH_M * cos(self.heading_rad), -APPROACH_M * sin(self.heading_rad)
        before = shifted(self.place, (back_n, back_e, 0.0))
        return (
            Item(int(mav.MAV_CMD_NAV_WAYPOINT), place=self.place),  # the first is home
            Item(_START),
            Item(_CIRCLE, (1.0, 0.0, 0.0, 1.0), before, HEIGHT_M),
            Item(_LAND, (_ABORT_M, 0.0, 0.0, 0.0), self.place),
        )


Runways: TypeAlias = Callable[[], Runway]


class _Stage(Enum):
    COUNT = "count"  # how many items are there
    READ = "read"  # them
    WRITE = "write"
    CLEAR = "clear"


class Landings:
    """Of one autopilot.

    Args:
        encoder: packs for this end.
        system: the autopilot's.
        runway: asked when a landing is uploaded.
    """

    def __init__(self, encoder: Encoder, system: int, runway: Runways) -> None:
        self.system, self.component = system, 1
        self._encoder, self._runway = encoder, runway
        self._ticket = 0
        self._wanted = False  # of the job: a landing; otherwise: none of ours
        self._stage: _Stage | None = None
        self._exchange = Exchange(_PATIENCE, 0)
        self._count = 0
        self._found: list[tuple[int, float]] = []  # command and first parameter of each item
        self._items: tuple[Item, ...] = ()
        self._reason = ""
        self._send: list[bytes] = []
        self._verdicts: list[Verdict] = []

    @property
    def busy(self) -> bool:
        """A job is on its way."""
        return self._stage is not None

    @property
    def idle(self) -> bool:
        """Nothing is on its way, and nothing to tell."""
        return self._stage is None and not self._verdicts and not self._send

    def provide(self, t_us: int) -> int:
        """See to it that the autopilot has a landing; ``take`` tells of the returned ticket."""
        return self._begin(t_us, wanted=True)

    def remove(self, t_us: int) -> int:
        """Take away what ``provide`` uploaded, even in an earlier life."""
        return self._begin(t_us, wanted=False)

    def _begin(self, t_us: int, *, wanted: bool) -> int:
        self._ticket += 1
        self._wanted, self._found, self._reason = wanted, [], ""
        self._enter(_Stage.COUNT, t_us)
        return self._ticket

    def drop(self, ticket: int) -> None:
        """Forget a job."""
        if ticket == self._ticket:
            self._stage = None

    def _enter(self, stage: _Stage, t_us: int) -> None:
        self._stage, self._exchange = stage, Exchange(_PATIENCE, t_us)

    def _finish(self, reason: str = "") -> None:
        self._stage = None
        self._verdicts.append(Verdict(self._ticket, not reason, reason))

    def take(self) -> list[Verdict]:
        """Verdicts since the last call."""
        verdicts, self._verdicts = self._verdicts, []
        return verdicts

    def hear(self, message: Any, t_us: int) -> None:
        """Take a MISSION_COUNT, _ITEM_INT, _REQUEST, _REQUEST_INT or _ACK for us."""
        if self._stage is None or getattr(message, "mission_type", _MISSION) != _MISSION:
            return
        name = message.msgname
        if name == "MISSION_COUNT" and self._stage is _Stage.COUNT:
            self._count = min(message.count, _MOST)
            self._read_on(t_us)
        elif name == "MISSION_ITEM_INT" and self._stage is _Stage.READ:
            if message.seq == len(self._found):
                self._found.append((message.command, message.param1))
                self._read_on(t_us)
        elif name in ("MISSION_REQUEST", "MISSION_REQUEST_INT") and self._stage is _Stage.WRITE:
            if message.seq < len(self._items):
                self._exchange.hear(Event.PROGRESS, t_us)
                self._send.append(self._item(message.seq))
        elif name == "MISSION_ACK" and self._stage in (_Stage.WRITE, _Stage.CLEAR):
            accepted = message.type == mav.MAV_MISSION_ACCEPTED
            self._finish("" if accepted else f"landing: {_result(message.type)}")

    def _read_on(self, t_us: int) -> None:
        """Read the next item, or go on with what they are."""
        if len(self._found) < self._count:
            self._enter(_Stage.READ, t_us)
            return
        if self._count:
            self._send.append(self._pack("MISSION_ACK", type=int(mav.MAV_MISSION_ACCEPTED)))
        commands = [command for command, _ in self._found]
        ours = commands[1:] == [_START, _CIRCLE, _LAND] and self._found[-1][1] == _ABORT_M
        if not self._wanted:
            if ours:
                self._enter(_Stage.CLEAR, t_us)
            else:
                self._finish()
        elif ours or self._count <= 1:
            self._items = self._runway().items()
            self._enter(_Stage.WRITE, t_us)
        else:
            there = _START in commands
            self._finish("" if there else "its mission has no landing (DO_LAND_START)")

    def due(self, t_us: int) -> list[bytes]:
        """Frames to send now."""
        frames, self._send = self._send, []
        if self._stage is None:
            return frames
        if self._exchange.due(t_us):
            frames.append(self._question())
        elif self._exchange.state is State.SILENT:
            self._finish(f"landing: no answer ({self._stage.value})")
        return frames

    def _question(self) -> bytes:
        if self._stage is _Stage.COUNT:
            return self._pack("MISSION_REQUEST_LIST")
        if self._stage is _Stage.READ:
            return self._pack("MISSION_REQUEST_INT", seq=len(self._found))
        if self._stage is _Stage.WRITE:
            return self._pack("MISSION_COUNT", count=len(self._items))
        return self._pack("MISSION_CLEAR_ALL")

    def _item(self, number: int) -> bytes:
        item = self._items[number]
        p1, p2, p3, p4 = item.params
        at = item.place
        return self._pack(
            "MISSION_ITEM_INT",
            seq=number,
            frame=_FRAME,
            command=item.command,
            current=0,
            autocontinue=1,
            param1=p1,
            param2=p2,
            param3=p3,
            param4=p4,
            x=0 if at is None else round(at.latitude_deg * 1e7),
            y=0 if at is None else round(at.longitude_deg * 1e7),
            z=item.height_m,
        )

    def _pack(self, name: str, **fields: Any) -> bytes:
        target = {"target_system": self.system, "target_component": self.component}
        return self._encoder.pack(name, mission_type=_MISSION, **target, **fields)


def _result(number: int) -> str:
    entry = mav.enums["MAV_MISSION_RESULT"].get(number)
    return f"result {number}" if entry is None else entry.name.removeprefix("MAV_MISSION_").lower()
