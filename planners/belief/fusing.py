"""Rules that mix the values of several agents: average, OGMM, modified OGMM.

Khan, Yanmaz and Rinner 2014, "Information merging in multi-UAV cooperative
search", Eqs. (3)-(8) and section IV-C.

| symbol | name |
| --- | --- |
| P_{i,c} | ``own`` |
| P_{k,c}, k != i | ``others`` |
| n | number of values mixed |
| v | ``ModifiedOgmm.v`` |

Section IV-C: only cells with different time stamps are merged, and the result
bears the newest stamp of its parts. The paper leaves open who merges, what n
counts, and what becomes of the 0.5 of an agent that never saw the cell; these
are parameters, and a live agent has the defaults.

DEVIATION: Eq. (3) asks whether the own value is 0.5; here, whether the cell was
never seen. With p = 1 - q a cell can come back to 0.5, and then the agent does know it.

Known faults of these rules, kept as the paper has them: OGMM counts a reading
again with every exchange (the paper's Table I), and an average forgets.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from planners.belief.maps import BeliefMap, stored
from planners.belief.newest import OneValue, copies
from planners.belief.rule import Records
from planners.types import F64, I64, Bools


class Cells(NamedTuple):
    """Values of cells: (...) of one's own, (..., n) of those heard."""

    value: F64
    stamp: I64  # -1: never seen
    origin: npt.NDArray[np.int32]


class Mixing(Protocol):
    """What ``mix`` must know of a rule."""

    @property
    def newest_keeps(self) -> bool:
        """Who holds the newest stamp keeps its value; else it merges with older ones too."""
        ...

    @property
    def distinct(self) -> bool:
        """Of values that bear one stamp only the first counts; else every sender does."""
        ...

    def combine(self, own: F64, seen: Bools, others: F64, used: Bools) -> F64:
        """Values (...) from own ones (...), ``seen`` or not, and others (..., n), used or not."""
        ...


def mix(rule: Mixing, own: Cells, heard: Cells, present: Bools) -> tuple[Cells, Bools]:
    """Merge what was heard into own cells, any number at once.

    Args:
        rule: how values are combined, and which.
        own: (...) each.
        heard: (..., n) each, broadcast against ``present``.
        present: (..., n) whether there is something in that place.

    Returns:
        own cells after it, (...) each, and which changed hands (...).
    """
    mine = own.stamp[..., None]
    used = present & ((heard.stamp > mine) if rule.newest_keeps else (heard.stamp != mine))
    changed = np.asarray(used.any(axis=-1))
    if not changed.any():
        return own, changed
    # Few cells change at a time: work on those alone.
    pick = np.nonzero(changed)
    used = used[pick]
    value = np.broadcast_to(heard.value, present.shape)[pick]
    stamp = np.broadcast_to(heard.stamp, present.shape)[pick]
    origin = np.broadcast_to(heard.origin, present.shape)[pick]
    if rule.distinct:
        used = _first_of_each_stamp(stamp, used)
    before = own.value[pick]
    fresh = stored(rule.combine(before, own.stamp[pick] >= 0, value, used))
    newest = np.where(used, stamp, -1).argmax(axis=-1)[:, None]
    latest = np.take_along_axis(stamp, newest, axis=-1)[:, 0]
    whose = np.take_along_axis(origin, newest, axis=-1)[:, 0]
    own_newer = own.stamp[pick] >= latest
    values, stamps, origins = own.value.copy(), own.stamp.copy(), own.origin.copy()
    values[pick] = fresh
    stamps[pick] = np.where(own_newer, own.stamp[pick], latest)
    origins[pick] = np.where(own_newer, own.origin[pick], whose)
    return Cells(values, stamps, origins), changed


def average(own: F64, seen: Bools, others: F64, used: Bools) -> F64:
    """Mean of those (..., n) that are used and of the own value (...) where seen: Eq. (3)."""
    total = np.where(used, others, 0.0).sum(axis=-1) + np.where(seen, own, 0.0)
    return np.asarray(total / (used.sum(axis=-1) + seen))


def occupancy(own: F64, seen: Bools, others: F64, used: Bools) -> F64:
    """Product of the odds, as a probability: Eqs. (4)-(6)."""
    odds = np.where(used, others / (1.0 - others), 1.0).prod(axis=-1)  # Eqs. (5), (6)
    odds = odds * np.where(seen, own / (1.0 - own), 1.0)
    return np.asarray(odds / (1.0 + odds))  # Eq. (4)


@dataclass(frozen=True, slots=True)
class FusingRule(OneValue):
    """What average, OGMM and modified OGMM have in common."""

    newest_keeps: bool = True
    distinct: bool = True

    @property
    def compared(self) -> tuple[str, ...]:
        return ("cell", "stamp_us")  # values of one stamp are not merged, however they differ

    def combine(self, own: F64, seen: Bools, others: F64, used: Bools) -> F64:
        raise NotImplementedError

    def merge(self, belief: BeliefMap, records: Records) -> tuple[BeliefMap, I64]:
        sound = records[self.valid(belief, records)]
        cells, heard, present = _by_cell(sound)
        own = Cells(
            belief.probability.reshape(-1)[cells],
            belief.stamp_us.reshape(-1)[cells],
            belief.origin.reshape(-1)[cells],
        )
        after, changed = mix(self, own, heard, present)
        if not changed.any():
            return belief, cells[changed]
        probability, stamp, origin = copies(belief)
        probability.reshape(-1)[cells] = after.value
        stamp.reshape(-1)[cells] = after.stamp
        origin.reshape(-1)[cells] = after.origin
        return BeliefMap(probability, stamp, origin), cells[changed]


@dataclass(frozen=True, slots=True)
class Average(FusingRule):
    """Average, Khan 2014, Eq. (3): what is known is averaged, what is unknown taken over."""

    name: str = "average"
    code: int = 3

    def combine(self, own: F64, seen: Bools, others: F64, used: Bools) -> F64:
        return average(own, seen, others, used)  # Eq. (3)


@dataclass(frozen=True, slots=True)
class Ogmm(FusingRule):
    """Occupancy grid map merging, Khan 2014, Eqs. (4)-(6): the odds are multiplied."""

    name: str = "ogmm"
    code: int = 4

    def combine(self, own: F64, seen: Bools, others: F64, used: Bools) -> F64:
        return occupancy(own, seen, others, used)


@dataclass(frozen=True, slots=True)
class ModifiedOgmm(FusingRule):
    """Modified OGMM, Khan 2014, Eqs. (7)-(8): average and OGMM, weighted."""

    name: str = "modified-ogmm"
    code: int = 5
    v: float = 0.7  # weight of the average
    untouched_counts: bool = True  # the own value of a cell never seen enters Eq. (8) all the same

    def combine(self, own: F64, seen: Bools, others: F64, used: Bools) -> F64:
        counts = np.ones_like(seen) if self.untouched_counts else seen
        mean = average(own, counts, others, used)  # Eq. (8)
        return np.asarray(self.v * mean + (1.0 - self.v) * occupancy(own, seen, others, used))


def _first_of_each_stamp(stamp: I64, used: Bools) -> Bools:
    """Of the used ones (m, n) that bear equal stamps, the first alone."""
    first = used.copy()
    for k in range(1, used.shape[-1]):
        again = (used[:, :k] & (stamp[:, :k] == stamp[:, k, None])).any(axis=-1)
        first[:, k] &= ~again
    return first


def _by_cell(records: Records) -> tuple[I64, Cells, Bools]:
    """Cells (m,) ascending, their records side by side (m, n), and where there are any."""
    order = np.argsort(records["cell"], kind="stable")
    ordered = records[order]
    cells, start, count = np.unique(
        ordered["cell"].astype(np.int64), return_index=True, return_counts=True
    )
    width = int(count.max()) if len(count) else 0
    place = np.arange(width)
    present = place < count[:, None]
    index = np.where(present, start[:, None] + place, 0)
    heard = ordered[index] if len(ordered) else np.zeros(index.shape, records.dtype)
    value = stored(heard["probability"])
    return cells, Cells(value, heard["stamp_us"], heard["origin"].astype(np.int32)), present
