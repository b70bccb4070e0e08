"""Telemetry streams of all vehicles: what is due at a time, as one datagram a vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from sim_vehicles.codec import BatchPacker, Encoder, Frames, join
from sim_vehicles.dynamics.model import F64
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.streams import FILLS, Fill, Ints, Readings, TelemetrySnapshot

__all__ = ["DEFAULT_INTERVALS_US", "Telemetry", "TelemetrySnapshot"]

DEFAULT_INTERVALS_US: Final[dict[str, int]] = {
    "HEARTBEAT": 1_000_000,
    "ATTITUDE": 100_000,
    "LOCAL_POSITION_NED": 100_000,
    "GLOBAL_POSITION_INT": 100_000,
    "SYS_STATUS": 500_000,
    "BATTERY_STATUS": 500_000,
    "EXTENDED_SYS_STATE": 500_000,
    "GPS_RAW_INT": 500_000,
    "VFR_HUD": 500_000,
    "SYSTEM_TIME": 1_000_000,
    "HOME_POSITION": 2_000_000,
}
"""Sent unasked, microseconds of simulated time between two."""

_OFF: Final = -1
_NEVER: Final = np.iinfo(np.int64).max


@dataclass(frozen=True, slots=True, eq=False)
class _Stream:
    """One message that can be streamed."""

    msgid: int
    name: str
    fill: Fill
    packer: BatchPacker
    default_us: int  # _OFF: not sent unasked


class Telemetry:
    """Builds the due messages of n vehicles.

    Streams of one rate are due at the same moments for all vehicles (multiples of their
    interval), so that they are packed together.

    Args:
        systems: (n,) system id of each vehicle, 1..255; ids may repeat.
        origin: of the fleet frame (ENU).
        homes: (n, 3) ENU m, where each vehicle starts: the zero of its local frame, and its
            home until ``homes`` is written to.

    Attributes:
        encoders: one a vehicle, for replies; they number their frames together with the
            telemetry of that vehicle.
        homes: (n, 3) ENU m; write a row to move that vehicle's home.
    """

    def __init__(self, systems: Sequence[int], origin: Geodetic, homes: F64) -> None:
        n = len(systems)
        numbers = bytearray(n)
        self.encoders = tuple(
            Encoder(system, sequences=numbers, index=index) for index, system in enumerate(systems)
        )
        self.homes = np.array(homes, dtype=np.float64).reshape(n, 3)
        self._starts = self.homes.copy()
        self._origin = origin
        self._systems = np.array(systems, dtype=np.uint8)
        self._sequences = np.frombuffer(numbers, dtype=np.uint8)  # the encoders' own bytes
        self._streams = tuple(_stream(name, fill) for name, fill in FILLS.items())
        self._columns = {stream.msgid: j for j, stream in enumerate(self._streams)}
        defaults = np.array([stream.default_us for stream in self._streams], dtype=np.int64)
        self._intervals = np.tile(defaults, (n, 1))  # (n, streams) us
        self._due = np.where(self._intervals > 0, 0, _NEVER)  # (n, streams) us
        self._soonest = self._due.min(axis=0, initial=_NEVER).tolist()

    def set_interval(self, index: int, message_id: int, interval_us: int) -> bool:
        """Stream a message of vehicle ``index`` every ``interval_us``, from the next build on.

        0 means its default rate, -1 off. False if the message is none that can be streamed.
        """
        column = self._columns.get(message_id)
        if column is None:
            return False
        if interval_us == 0:
            interval_us = self._streams[column].default_us
        self._intervals[index, column] = interval_us if interval_us > 0 else _OFF
        self._due[index, column] = 0 if interval_us > 0 else _NEVER
        self._soonest[column] = int(self._due[:, column].min())
        return True

    def interval(self, index: int, message_id: int) -> int:
        """What MESSAGE_INTERVAL says: us between two, -1 switched off, 0 not available."""
        column = self._columns.get(message_id)
        return 0 if column is None else int(self._intervals[index, column])

    def one(
        self, index: int, message_name: str, t_us: int, snapshot: TelemetrySnapshot
    ) -> bytes | None:
        """One message of vehicle ``index`` now; None if it is none of those known here."""
        for stream in self._streams:
            if stream.name == message_name:
                rows = np.array([index])
                return self._frames(stream, self._readings(t_us, snapshot, rows), rows).split()[0]
        return None

    def build(self, t_us: int, snapshot: TelemetrySnapshot) -> list[tuple[int, bytes]]:
        """Everything due up to ``t_us``: (vehicle index, datagram), at most one a vehicle."""
        due = [j for j, soonest in enumerate(self._soonest) if soonest <= t_us]
        if not due:
            return []
        n = len(self._systems)
        everyone = self._readings(t_us, snapshot, slice(None))
        whole: list[Frames] = []
        some: dict[int, list[bytes]] = {}
        for column in due:
            stream = self._streams[column]
            rows = self._take_due(column, t_us)
            if len(rows) == n:
                whole.append(self._frames(stream, everyone, slice(None)))
                continue
            few = self._readings(t_us, snapshot, rows)
            frames = self._frames(stream, few, rows).split()
            for index, frame in zip(rows.tolist(), frames, strict=True):
                some.setdefault(index, []).append(frame)
        return _datagrams(join(whole), some)

    def _take_due(self, column: int, t_us: int) -> Ints:
        """Indices of the vehicles that send this stream now; sets when they send it next."""
        due = self._due[:, column]
        rows = np.flatnonzero(due <= t_us)
        intervals = self._intervals[rows, column]
        due[rows] = (t_us // intervals + 1) * intervals
        self._soonest[column] = int(due.min())
        return rows

    def _readings(self, t_us: int, snapshot: TelemetrySnapshot, rows: slice | Ints) -> Readings:
        return Readings(t_us, snapshot, rows, self._origin, self._starts, self.homes)

    def _frames(self, stream: _Stream, now: Readings, rows: slice | Ints) -> Frames:
        systems = self._systems[rows]
        records = stream.packer.records(len(systems))
        stream.fill(records, now)
        frames = stream.packer.frames(records, systems, self._sequences[rows])
        self._sequences[rows] += 1  # wraps at 256
        return frames


def _datagrams(whole: list[bytes], some: dict[int, list[bytes]]) -> list[tuple[int, bytes]]:
    """Join what all vehicles send with what only some send."""
    if not whole:
        return [(index, b"".join(frames)) for index, frames in sorted(some.items())]
    for index, frames in some.items():
        whole[index] += b"".join(frames)
    return list(enumerate(whole))


def _stream(name: str, fill: Fill) -> _Stream:
    packer = BatchPacker(name)
    return _Stream(packer.msgid, name, fill, packer, DEFAULT_INTERVALS_US.get(name, _OFF))
