"""Telemetry streams of all vehicles: what is due at a time, as one datagram a vehicle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from sim_vehicles.codec import BatchPacker, Encoder, mav
from sim_vehicles.dynamics.model import F64
from sim_vehicles.geodesy import Geodetic, LocalGeodesy
from sim_vehicles.streams import (
    DEFAULT_INTERVALS_US,
    FILLS,
    Fill,
    Ints,
    Readings,
    TelemetrySnapshot,
)

__all__ = ["DEFAULT_INTERVALS_US", "Telemetry", "TelemetrySnapshot"]

_OFF: Final = -1


@dataclass(slots=True, eq=False)
class _Rate:
    """The vehicles that send one message at one interval, all at the same moments."""

    members: set[int]
    next_us: int = 0
    rows: Ints | None = None  # members in order, made when needed


@dataclass(slots=True)
class _Stream:
    """One message: who sends it how often."""

    name: str
    intervals_us: list[int]  # of each vehicle, _OFF: not sent
    rates: dict[int, _Rate] = field(default_factory=dict)  # interval -> senders


class Telemetry:
    """Builds the due messages of n vehicles.

    Streams of one interval are due at the same moments for all vehicles (its multiples), so
    that they are packed together.

    Args:
        systems: (n,) system id of each vehicle, 1..255; ids may repeat.
        origin: of the fleet frame (ENU).
        homes: (n, 3) ENU m, where each vehicle starts: the zero of its local frame, and its
            home until ``homes`` is written to.
        fills: the messages that there are.
        intervals_us: those sent unasked, microseconds of simulated time between two.

    Attributes:
        encoders: one a vehicle, for replies; they number their frames together with the
            telemetry of that vehicle.
        homes: (n, 3) ENU m; write a row to move that vehicle's home.
    """

    def __init__(
        self,
        systems: Sequence[int],
        origin: Geodetic,
        homes: F64,
        *,
        fills: Mapping[str, Fill] = FILLS,
        intervals_us: Mapping[str, int] = DEFAULT_INTERVALS_US,
    ) -> None:
        n = len(systems)
        self._fills, self._intervals_us = fills, intervals_us
        numbers = bytearray(n)
        self.encoders = tuple(
            Encoder(system, sequences=numbers, index=index) for index, system in enumerate(systems)
        )
        self.homes = np.array(homes, dtype=np.float64).reshape(n, 3)
        self._starts = self.homes.copy()
        self._geodesy = LocalGeodesy(origin)
        self._systems = np.array(systems, dtype=np.uint8)
        self._sequences = np.frombuffer(numbers, dtype=np.uint8)  # the encoders' own bytes
        self._streams = {
            getattr(mav, f"MAVLINK_MSG_ID_{name}"): _stream(name, n, intervals_us.get(name, _OFF))
            for name in fills
        }
        self._packers: dict[tuple[str, ...], BatchPacker] = {}
        self._next_us = 0  # nothing is due before

    def set_interval(self, index: int, message_id: int, interval_us: int) -> bool:
        """Stream a message of vehicle ``index`` every ``interval_us``, in step with the others.

        0 means its default rate, below 0 off. False if it is no message that can be streamed.
        """
        stream = self._streams.get(message_id)
        if stream is None:
            return False
        if interval_us == 0:
            interval_us = self._intervals_us.get(stream.name, _OFF)
        before = stream.intervals_us[index]
        stream.intervals_us[index] = interval_us = max(interval_us, _OFF)
        if before != _OFF:
            rate = stream.rates[before]
            rate.members.discard(index)
            rate.rows = None
            if not rate.members:
                del stream.rates[before]
        if interval_us != _OFF:
            rate = stream.rates.setdefault(interval_us, _Rate(set()))
            rate.members.add(index)
            rate.rows = None
        self._next_us = 0
        return True

    def interval(self, index: int, message_id: int) -> int:
        """What MESSAGE_INTERVAL says: us between two, -1 switched off, 0 not available."""
        stream = self._streams.get(message_id)
        return 0 if stream is None else stream.intervals_us[index]

    def one(
        self, index: int, message_name: str, t_us: int, snapshot: TelemetrySnapshot
    ) -> bytes | None:
        """One message of vehicle ``index`` now; None if it is none of those known here."""
        if message_name not in self._fills:
            return None
        return self._pack((message_name,), np.array([index]), t_us, snapshot)[0]

    def build(self, t_us: int, snapshot: TelemetrySnapshot) -> list[tuple[int, bytes]]:
        """Everything due up to ``t_us``: (vehicle index, datagram), at most one a vehicle.

        Sorted by index. Times must not go back.
        """
        if t_us < self._next_us:
            return []
        everyone: list[str] = []
        others: dict[bytes, tuple[Ints, list[str]]] = {}
        for stream in self._streams.values():
            for interval_us, rate in stream.rates.items():
                if rate.next_us > t_us:
                    continue
                rate.next_us = (t_us // interval_us + 1) * interval_us
                if len(rate.members) == len(self._systems):
                    everyone.append(stream.name)
                    continue
                if rate.rows is None:
                    rate.rows = np.array(sorted(rate.members), dtype=np.int64)
                others.setdefault(rate.rows.tobytes(), (rate.rows, []))[1].append(stream.name)
        rates = (rate for stream in self._streams.values() for rate in stream.rates.values())
        self._next_us = min((rate.next_us for rate in rates), default=t_us)
        parts: list[tuple[int, bytes]] = []
        if everyone:
            parts = list(enumerate(self._pack(tuple(everyone), slice(None), t_us, snapshot)))
        for rows, names in others.values():
            frames = self._pack(tuple(names), rows, t_us, snapshot)
            parts.extend(zip(rows.tolist(), frames, strict=True))
        return _merged(parts) if others else parts

    def _pack(
        self, names: tuple[str, ...], rows: slice | Ints, t_us: int, snapshot: TelemetrySnapshot
    ) -> list[bytes]:
        """The named messages of some vehicles, one datagram each."""
        packer = self._packers.get(names)
        if packer is None:
            packer = self._packers[names] = BatchPacker(*names)
        now = Readings(t_us, snapshot, rows, self._geodesy, self._starts, self.homes)
        systems = self._systems[rows]
        records = packer.records(len(systems))
        for name in names:
            self._fills[name](records[name], now)
        datagrams = packer.pack(records, systems, self._sequences[rows])
        self._sequences[rows] += len(names)  # wraps at 256
        return datagrams


def _merged(parts: list[tuple[int, bytes]]) -> list[tuple[int, bytes]]:
    """One datagram a vehicle of several parts."""
    joined: dict[int, bytes] = {}
    for index, data in parts:
        joined[index] = joined[index] + data if index in joined else data
    return sorted(joined.items())


def _stream(name: str, n: int, interval_us: int) -> _Stream:
    stream = _Stream(name, [interval_us] * n)
    if interval_us != _OFF and n:
        stream.rates[interval_us] = _Rate(set(range(n)))
    return stream
