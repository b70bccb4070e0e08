"""True positions over time, for the radio's decision alone."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from planners.types import F64, I64, Bools
from uavbridge.bus import keys
from uavbridge.bus.api import Bus, Mailbox
from uavbridge.bus.messages import decode_truth
from uavbridge.bus.wire import Vector

MEMORY = 256  # samples
_ROWS = 16


class _Moment(NamedTuple):
    """Between which two samples a time lies."""

    t_us: int
    start: list[list[float]]
    end: list[list[float]]
    share: float  # of the way from one to the other
    inside: bool  # the time is in the memory


class TruthTrack:
    """The last true positions of the simulated vehicles, by time.

    Between two samples it interpolates; before the first and after the last it
    knows nothing. Other vehicles than before begin a new memory.

    Args:
        bus: follow ``world/truth`` there; None: fed by ``add`` alone.
        memory: samples kept, at least.

    Attributes:
        ids: the vehicles it knows, ascending.
        row: place of each in ``ids``.
        rejects: samples that could not be read, by reason.
    """

    def __init__(self, bus: Bus | None = None, *, memory: int = MEMORY) -> None:
        self.ids: tuple[int, ...] = ()
        self.row: dict[int, int] = {}
        self.rejects: Counter[str] = Counter()
        self._mailbox: Mailbox | None = bus.subscribe(keys.TRUTH) if bus else None
        self._memory = memory
        # twice the memory: when it is full the older half goes, and samples stay in one piece
        self._times = np.zeros(2 * memory, np.int64)
        self._positions = np.zeros((2 * memory, 0, 3))
        self._count = 0
        self._stamps: list[int] = []  # the times again, for single look-ups
        self._rows: dict[int, list[list[float]]] = {}  # and some of the positions
        self._moment: _Moment | None = None  # that was asked for last

    def add(self, t_us: int, ids: Sequence[int], positions: npt.ArrayLike) -> None:
        """Note where the vehicles are; a sample older than the newest is dropped.

        Args:
            t_us: mission time.
            ids: (n,) ascending.
            positions: (n, 3) ENU m; copied.
        """
        newest_us = self.newest_us
        if newest_us is not None and t_us < newest_us:
            return
        if self.ids != tuple(ids):
            self.ids = tuple(ids)
            self.row = {agent: i for i, agent in enumerate(self.ids)}
            self._positions = np.zeros((2 * self._memory, len(self.ids), 3))
            self._count = 0
            self._stamps.clear()
            self._rows.clear()
        elif t_us == newest_us:
            self._count -= 1
            self._stamps.pop()
            self._rows.pop(t_us, None)
        elif self._count == 2 * self._memory:
            self._times[: self._memory] = self._times[self._memory :]
            self._positions[: self._memory] = self._positions[self._memory :]
            self._count = self._memory
            del self._stamps[: self._memory]
        self._moment = None
        self._stamps.append(t_us)
        self._times[self._count] = t_us
        self._positions[self._count] = positions
        self._count += 1

    def poll(self, latest_us: int) -> None:
        """Take in what the bus brought; what is dated after ``latest_us`` is counted alone."""
        if self._mailbox is None:
            return
        for sample in self._mailbox.drain():
            truth = decode_truth(sample.data, self.rejects)
            if truth is not None and truth.t_us > latest_us:
                self.rejects["future"] += 1
            elif truth is not None:
                self.add(truth.t_us, truth.ids, truth.position)

    @property
    def newest_us(self) -> int | None:
        """Time of the newest sample; None before the first."""
        return int(self._times[self._count - 1]) if self._count else None

    def when(self, t_us: I64) -> tuple[F64, Bools]:
        """Where all vehicles were.

        Args:
            t_us: (f,) times.

        Returns:
            (f, n, 3) ENU m in the order of ``ids``, and (f,) whether the time is in
            the memory; where it is not, the nearest sample stands.

        Raises:
            LookupError: nothing is known at all.
        """
        if not self._count:
            raise LookupError("no true position is known yet")
        times, positions = self._times[: self._count], self._positions[: self._count]
        inside: Bools = np.asarray((t_us >= times[0]) & (t_us <= times[-1]))
        after = np.minimum(np.searchsorted(times, t_us), self._count - 1)
        before = np.maximum(after - 1, 0)
        gap = np.maximum(times[after] - times[before], 1)
        share = np.minimum(np.maximum((t_us - times[before]) / gap, 0.0), 1.0)[:, None, None]
        return positions[before] + share * (positions[after] - positions[before]), inside

    def two(
        self, t_us: int, one: int, other: int
    ) -> tuple[Sequence[float] | None, Sequence[float] | None, bool]:
        """Like ``when`` for two vehicles at one time; None for one that is not known.

        Raises:
            LookupError: nothing is known at all.
        """
        moment = self._moment
        if moment is None or moment.t_us != t_us:
            moment = self._moment = self._moment_at(t_us)
        _, start, end, share, inside = moment
        i, j = self.row.get(one), self.row.get(other)
        first = None if i is None else _between(start[i], end[i], share)
        return first, None if j is None else _between(start[j], end[j], share), inside

    def _moment_at(self, t_us: int) -> _Moment:
        stamps = self._stamps
        if not stamps:
            raise LookupError("no true position is known yet")
        after = min(bisect_left(stamps, t_us), len(stamps) - 1)
        before = max(after - 1, 0)
        gap = max(stamps[after] - stamps[before], 1)
        share = min(max((t_us - stamps[before]) / gap, 0.0), 1.0)
        start, end = self._at_sample(before), self._at_sample(after)
        return _Moment(t_us, start, end, share, stamps[0] <= t_us <= stamps[-1])

    def _at_sample(self, index: int) -> list[list[float]]:
        """Positions of all vehicles as plain numbers."""
        stamp = self._stamps[index]
        rows = self._rows.get(stamp)
        if rows is None:
            if len(self._rows) >= _ROWS:
                self._rows.clear()
            rows = self._rows[stamp] = self._positions[index].tolist()
        return rows

    def at(self, t_us: int, agent: int) -> Vector | None:
        """True position of one vehicle (ENU m) at one time; None when not known."""
        if agent not in self.row:
            return None
        positions, inside = self.when(np.array([t_us]))
        if not inside[0]:
            return None
        x, y, z = positions[0, self.row[agent]].tolist()
        return x, y, z


def _between(start: Sequence[float], end: Sequence[float], share: float) -> Vector:
    (x, y, z), (u, v, w) = start, end
    return x + share * (u - x), y + share * (v - y), z + share * (w - z)
