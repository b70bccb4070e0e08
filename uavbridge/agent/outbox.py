"""Records that an agent owes the others, and which go first when not all fit into a frame."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from itertools import islice, repeat
from math import isinf
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from planners.belief.merge import BeliefMap, MergeRule, Records
from planners.types import F64
from uavbridge.agent.relaying import UNKNOWN, Sources, always

SHARE = 0.25  # of the records that go: those that wait longest, and those that were asked for
COPIES = 3  # what so many others told is not passed on

Item: TypeAlias = tuple[int, ...]


class _Waiting(NamedTuple):
    record: bytes
    own: bool  # an own observation; else it was heard and is passed on
    change: float  # of the cell's probability since it was last told of
    place: int  # in the order of coming
    sources: Sources = UNKNOWN  # who told it
    copies: int = 0  # heard of it since


class Outbox:
    """What changed and was not told yet, and cells that others asked for.

    When not everything fits: first own observations, then what was heard from others, and of
    both first the cells whose probability changed most. A quarter of the records are those
    that wait longest, and a quarter is for what was asked for: nothing waits for ever. What
    several others told already is not passed on: who did not hear them asks. Nor is what all in
    reach heard themselves (``Relaying``).

    Args:
        rule: whose records they are.
    """

    def __init__(self, rule: MergeRule) -> None:
        self._rule = rule
        self._waiting: dict[Item, _Waiting] = {}
        self._asked: dict[int, int] = {}  # flat cell -> how many of its records have gone
        self._held: dict[Item, _Waiting] = {}  # heard, and it seems that nobody in reach needs it
        self._come = self._come_before = 0  # by now, by the last frame
        self._patience = self._answers = 0.0  # parts of a record that are due from before

    @property
    def waiting(self) -> int:
        """Changed records not told yet."""
        return len(self._waiting)

    @property
    def asked(self) -> int:
        """Cells that others asked for and were not told of yet."""
        return len(self._asked)

    def changed(
        self,
        records: Records,
        change: F64,
        *,
        own: bool,
        sources: Sequence[Sources] | None = None,
    ) -> None:
        """Records (k,) that are new here.

        Args:
            records: as they are now.
            change: (k,) of their cells' probability.
            own: observed here, not heard.
            sources: of each, who told it.
        """
        items = records[list(self._rule.item)].tolist()
        octets, size = records.tobytes(), records.itemsize
        whence = repeat(UNKNOWN, len(items)) if sources is None else sources
        for i, (item, moved, who) in enumerate(zip(items, change.tolist(), whence, strict=True)):
            record, before = octets[i * size : (i + 1) * size], self._waiting.get(item)
            if before is None:
                self._waiting[item] = _Waiting(record, own, moved, self._come, who)
                self._come += 1
            else:
                most, mine = max(moved, before.change), own or before.own
                self._waiting[item] = _Waiting(record, mine, most, before.place, who)

    def asked_for(self, cells: npt.ArrayLike) -> None:
        """Somebody lacks what is known of flat cells (m,)."""
        for cell in np.asarray(cells).tolist():
            self._asked.setdefault(cell, 0)

    def heard(self, records: Records) -> None:
        """Records (k,) that others told: who asked for their cells heard it too, or asks again."""
        if self._asked:
            for cell in records["cell"].tolist():
                self._asked.pop(cell, None)
        if not self._waiting:
            return
        octets, size = records.tobytes(), records.itemsize
        for i, item in enumerate(records[list(self._rule.item)].tolist()):
            mine = self._waiting.get(item)
            if mine is None or mine.own or mine.record != octets[i * size : (i + 1) * size]:
                continue
            if mine.copies + 1 >= COPIES:
                del self._waiting[item]
            else:
                self._waiting[item] = mine._replace(copies=mine.copies + 1)

    def take(
        self, belief: BeliefMap, room: float, needed: Callable[[Sources], bool] = always
    ) -> bytes:
        """Records for the next frame, at most ``room`` bytes of them, ascending cells.

        Args:
            belief: the map.
            room: bytes.
            needed: whether what was heard so is news to somebody in reach. What came since the
                last frame, and does not seem to be, is asked about again at the next.
        """
        self._hold(needed)
        most = sys.maxsize if isinf(room) else int(room) // self._rule.record.itemsize
        if not self._asked and len(self._waiting) <= most:
            told = self._changes(most)
        else:
            told = self._some(belief, most)
        if len(told) < 2:
            return b"".join(told)
        records = np.frombuffer(b"".join(dict.fromkeys(told)), self._rule.record)
        ordered: Records = records[np.argsort(records["cell"], kind="stable")]
        return ordered.tobytes()

    def _hold(self, needed: Callable[[Sources], bool]) -> None:
        held, self._held = self._held, {}
        fresh = [
            item
            for item, waiting in self._waiting.items()
            if not waiting.own
            and waiting.place >= self._come_before
            and not needed(waiting.sources)
        ]
        for item in fresh:
            self._held[item] = self._waiting.pop(item)
        for item, waiting in held.items():
            if item not in self._held and needed(waiting.sources):
                self._waiting.setdefault(item, waiting)  # what came since is newer
        self._come_before = self._come

    def _some(self, belief: BeliefMap, most: int) -> list[bytes]:
        told: list[bytes] = []
        if self._asked and len(self._waiting) > most * (1.0 - SHARE):
            self._answers += most * SHARE
            due = int(self._answers)
            self._answers -= due
            told = self._answer(belief, due)
        told += self._changes(most - len(told))
        return told + self._answer(belief, most - len(told))

    def _changes(self, most: int) -> list[bytes]:
        items = list(self._waiting) if most >= len(self._waiting) else self._urgent(most)
        return [self._waiting.pop(item).record for item in items]

    def _urgent(self, most: int) -> list[Item]:
        """The ``most`` that go first."""
        self._patience += most * SHARE
        due = int(self._patience)
        self._patience -= due
        order = sorted(self._waiting.items(), key=lambda entry: entry[1].place)
        rest = sorted(order[due:], key=lambda entry: (not entry[1].own, -entry[1].change))
        return [item for item, _ in order[:due] + rest[: most - due]]

    def _answer(self, belief: BeliefMap, most: int) -> list[bytes]:
        """Up to ``most`` records of cells that were asked for; a cell may take several frames."""
        if most <= 0 or not self._asked:
            return []
        cells = sorted(islice(self._asked, min(most, len(self._asked))))
        records = self._rule.records(belief, cells)
        ends = np.searchsorted(records["cell"], cells, side="right").tolist()
        told: list[bytes] = []
        start = 0
        for cell, end in zip(cells, ends, strict=True):
            first = start + self._asked[cell]
            last = min(end, first + most - len(told))
            told += [record.tobytes() for record in records[first:last]]
            if last < end:
                self._asked[cell] = last - start
                break
            del self._asked[cell]
            start = end
        return told
