"""What a mission was like before somebody joined: kept by its judge, told on request."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

import msgspec
from msgspec import Struct

from uavbridge.agent.report import AgentReport
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.text import read
from uavbridge.clock import to_s
from uavbridge.recording.topics import EventRecord
from uavbridge.recording.topics import decode as decode_record
from uavbridge.thinned import keep

MOST_EVENTS = 2000
MOST_PLACES = 1800  # of one agent; then every other one goes


class PastPoint(Struct, frozen=True, array_like=True):
    """The mission in numbers at one second; None where a number is not known."""

    t_us: int
    coverage: float | None
    entropy: float | None
    uncertainty: float | None
    declared: int
    found: int
    separation_m: float | None
    bytes_sent: int = 0
    bytes_heard: int = 0
    frames_sent: int = 0
    frames_heard: int = 0


class PastEvent(Struct, frozen=True, array_like=True):
    """Something that happened to an agent."""

    t_us: int
    agent: int
    kind: str
    text: str


class Past(Struct, frozen=True):
    """JSON on ``world/past``."""

    points: list[PastPoint]
    tracks: dict[int, list[tuple[float, float, float, float]]]  # t in s, ENU m
    events: list[PastEvent]


_DECODER = msgspec.json.Decoder(Past)


class Chronicle:
    """Keeps the past and answers for it.

    Args:
        bus: the mission's.
    """

    def __init__(self, bus: Bus) -> None:
        self._told = bus.subscribe(keys.event("*"))
        self._points: list[PastPoint] = []
        self._tracks: dict[int, list[tuple[float, float, float, float]]] = {}
        self._events: deque[PastEvent] = deque(maxlen=MOST_EVENTS)
        bus.serve(keys.PAST, lambda _key: self._encoded())

    def add(self, point: PastPoint, reports: Iterable[AgentReport]) -> None:
        """A second has passed.

        Args:
            point: the mission now.
            reports: of the agents whose position is known.
        """
        keep(self._points, point)
        for report in reports:
            x, y, z = report.position
            place = (to_s(point.t_us), round(x, 1), round(y, 1), round(z, 1))
            keep(self._tracks.setdefault(report.agent, []), place, MOST_PLACES)
        for key, data in self._told.drain():
            agent = keys.agent_of(key.removesuffix("/event"))
            try:
                event = decode_record(EventRecord, data)
            except msgspec.DecodeError:
                continue
            if agent is not None:
                self._events.append(PastEvent(point.t_us, agent, event.kind, event.text))

    def _encoded(self) -> bytes:
        # On the bus's thread: copies of what the judge's thread goes on changing.
        tracks = {agent: list(track) for agent, track in list(self._tracks.items())}
        return msgspec.json.encode(Past(list(self._points), tracks, list(self._events)))


def decode(data: bytes) -> Past:
    """From JSON. Raises msgspec.DecodeError for anything else."""
    return read(_DECODER, data)
