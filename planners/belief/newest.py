"""Rules that keep one value a cell: belief update, and no merging at all.

Khan, Yanmaz and Rinner 2014, "Information merging in multi-UAV cooperative
search": Eq. (1) on an own reading, Eq. (2) (belief update) on a received cell,
time stamps of section IV-C.

| symbol | name |
| --- | --- |
| P_{i,c} | ``BeliefMap.probability[c]`` of agent i |
| time stamp | ``BeliefMap.stamp_us`` |
| O_{i,c,t} | ``detected`` |

DEVIATION: Eq. (2) leaves open what happens when stamps are equal. Cells are
ordered by (stamp, origin, value) and the greatest wins, so that merging is
commutative, associative and idempotent: maps converge whatever the order and
however often a record arrives.

DEVIATION: an own reading that is not later than the cell's stamp (late sensor,
clocks apart) is stamped one microsecond after it, for its value already holds
what the older record told; otherwise two different values would bear one stamp.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from planners.belief.maps import BeliefMap, SensorModel, blank, stored
from planners.belief.rule import MergeRule, Records, latest_us
from planners.grid import Grid
from planners.types import F64, I64, Bools

RECORD: np.dtype[Any] = np.dtype(
    [("cell", "<u4"), ("origin", "<u2"), ("probability", "<f4"), ("stamp_us", "<i8")]
)


@dataclass(frozen=True, slots=True)
class OneValue:
    """What rules have in common that keep and send one stamped probability a cell."""

    @property
    def record(self) -> np.dtype[Any]:
        return RECORD

    @property
    def item(self) -> tuple[str, ...]:
        return ("cell",)

    @property
    def compared(self) -> tuple[str, ...]:
        return ("cell", "origin", "probability", "stamp_us")

    @property
    def onlooker(self) -> MergeRule:
        return BeliefUpdate()

    def empty(
        self,
        grid: Grid,
        prior: npt.ArrayLike,
        sensor: SensorModel | None = None,
    ) -> BeliefMap:
        return blank(grid, prior)

    def observe(
        self,
        belief: BeliefMap,
        cell: tuple[int, int],
        detected: bool,
        sensor: SensorModel,
        *,
        t_us: int,
        agent: int,
    ) -> BeliefMap:
        probability, stamp, origin = copies(belief)
        probability[cell] = stored(sensor.after(belief.probability[cell], detected))  # Eq. (1)
        stamp[cell] = max(t_us, int(belief.stamp_us[cell]) + 1)
        origin[cell] = agent
        return BeliefMap(probability, stamp, origin)

    def valid(self, belief: BeliefMap, records: Records, until_us: int | None = None) -> Bools:
        value, stamp = records["probability"], records["stamp_us"]
        known = (records["cell"] < belief.size) & (stamp >= 0) & (stamp <= latest_us(until_us))
        return np.asarray(known & (value >= 0.0) & (value <= 1.0))  # NaN compares false

    def records(self, belief: BeliefMap, cells: npt.ArrayLike) -> Records:
        flat = np.asarray(cells, dtype=np.int64).reshape(-1)
        flat = flat[belief.stamp_us.reshape(-1)[flat] >= 0]
        out = np.zeros(len(flat), RECORD)
        out["cell"] = flat
        out["origin"] = belief.origin.reshape(-1)[flat]
        out["probability"] = belief.probability.reshape(-1)[flat]
        out["stamp_us"] = belief.stamp_us.reshape(-1)[flat]
        return out


@dataclass(frozen=True, slots=True)
class BeliefUpdate(OneValue):
    """Belief update, Khan 2014, Eq. (2): the latest observation of a cell wins."""

    name: str = "belief-update"
    code: int = 1

    def merge(self, belief: BeliefMap, records: Records) -> tuple[BeliefMap, I64]:
        best = _best_of_each_cell(records[self.valid(belief, records)])
        cells = best["cell"].astype(np.int64)
        value = stored(best["probability"])
        wins = beats(
            best["stamp_us"],
            best["origin"],
            value,
            belief.stamp_us.reshape(-1)[cells],
            belief.origin.reshape(-1)[cells],
            belief.probability.reshape(-1)[cells],
        )
        changed = cells[wins]
        if not len(changed):
            return belief, changed
        probabilities, stamps, origins = copies(belief)
        probabilities.reshape(-1)[changed] = value[wins]  # Eq. (2)
        stamps.reshape(-1)[changed] = best["stamp_us"][wins]
        origins.reshape(-1)[changed] = best["origin"][wins]
        return BeliefMap(probabilities, stamps, origins), changed


@dataclass(frozen=True, slots=True)
class Uncoordinated(OneValue):
    """Own readings alone, the paper's reference: what others send changes nothing.

    It is sent all the same, so that onlookers see what the team has seen.
    """

    name: str = "uncoordinated"
    code: int = 2

    @property
    def compared(self) -> tuple[str, ...]:
        return ()

    def merge(self, belief: BeliefMap, records: Records) -> tuple[BeliefMap, I64]:
        return belief, np.zeros(0, np.int64)


def beats(
    stamp: npt.ArrayLike,
    origin: npt.ArrayLike,
    value: npt.ArrayLike,
    own_stamp: npt.ArrayLike,
    own_origin: npt.ArrayLike,
    own_value: npt.ArrayLike,
) -> Bools:
    """Whether (stamp, origin, value) is the greater: Eq. (2) with time stamps. Broadcasts."""
    s, o, v = np.asarray(stamp), np.asarray(origin), np.asarray(value)
    level = (o > own_origin) | ((o == own_origin) & (v > own_value))
    return np.asarray((s > own_stamp) | ((s == own_stamp) & level))


def copies(belief: BeliefMap) -> tuple[F64, I64, npt.NDArray[np.int32]]:
    """The map's arrays, free to change."""
    return belief.probability.copy(), belief.stamp_us.copy(), belief.origin.copy()


def _best_of_each_cell(records: Records) -> Records:
    """The greatest (stamp, origin, value) of every cell, ascending cells."""
    if len(records) < 2:
        return records
    order = np.lexsort(
        (records["probability"], records["origin"], records["stamp_us"], records["cell"])
    )
    ordered = records[order]
    cells, last = ordered["cell"], np.ones(len(ordered), np.bool_)
    np.not_equal(cells[1:], cells[:-1], out=last[:-1])
    best: Records = ordered[last]
    return best
