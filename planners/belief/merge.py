"""Belief maps and the rules by which agents merge them.

Khan, Yanmaz and Rinner 2014, "Information merging in multi-UAV cooperative
search": Eq. (1) on an own reading, Eq. (2) (belief update) on a received cell,
time stamps of section IV-C.

| symbol | name |
| --- | --- |
| P_{i,c} | ``BeliefMap.probability[c]`` of agent i |
| time stamp | ``BeliefMap.stamp_us`` |
| p, q | ``SensorModel.p``, ``SensorModel.q`` |
| O_{i,c,t} | ``detected`` |

DEVIATION: Eq. (2) leaves open what happens when stamps are equal. Cells are
ordered by (stamp, origin, value) and the greatest wins, so that merging is
commutative, associative and idempotent: maps converge whatever the order and
however often a record arrives.

DEVIATION: an own reading that is not later than the cell's stamp (late sensor,
clocks apart) is stamped one microsecond after it, for its value already holds
what the older record told; otherwise two different values would bear one stamp.

DEVIATION: stored probabilities are rounded to single precision, as they travel,
and kept within [1e-7, 1 - 1e-7]: at exactly 0 or 1 Eq. (1) cannot move any more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from planners.belief.bayes import UPDATES
from planners.grid import Grid
from planners.types import F64, I64, Bools

Records: TypeAlias = npt.NDArray[np.void]

FLOOR = 1e-7  # probabilities stay this far from 0 and 1
_LAST_US = 2**62  # no honest stamp comes near
_GRACE_US = 1000  # stamps may run ahead of the clock by one microsecond a reading, see above


@dataclass(frozen=True, slots=True)
class SensorModel:
    """What the agents believe of their payload sensor.

    Raises:
        ValueError: p or q is not strictly between 0 and 1, the update is not known,
            or p < q with Liu's update (probabilities would leave [0, 1]).
    """

    p: float = 0.9  # P(positive reading, target in the cell)
    q: float = 0.05  # P(positive reading, no target in the cell)
    update: str = "bayes"  # a key of planners.belief.bayes.UPDATES

    def __post_init__(self) -> None:
        for name, value in (("p", self.p), ("q", self.q)):
            if not 0.0 < value < 1.0:
                raise ValueError(f"{name} must lie strictly between 0 and 1, not {value}")
        if self.update not in UPDATES:
            raise ValueError(f"update must be one of {', '.join(UPDATES)}, not {self.update!r}")
        if self.update == "liu" and self.p < self.q:
            raise ValueError(f"update 'liu' needs p >= q, not p = {self.p}, q = {self.q}")

    def after(self, prior: npt.ArrayLike, detected: npt.ArrayLike) -> F64:
        """Probabilities (...) after one reading each."""
        return UPDATES[self.update](prior, detected, self.p, self.q)


@dataclass(frozen=True, slots=True, eq=False)
class BeliefMap:
    """One agent's map; arrays of shape (columns, rows)."""

    probability: F64  # P(target in the cell)
    stamp_us: I64  # when it was last observed, as far as known; -1: never
    origin: npt.NDArray[np.int32]  # who observed it then; -1: nobody

    @property
    def seen(self) -> Bools:
        """(columns, rows) observed by somebody."""
        return np.asarray(self.stamp_us >= 0)

    @property
    def size(self) -> int:
        """Number of cells."""
        return int(self.probability.size)


class MergeRule(Protocol):
    """How a map takes in own readings and what others send. Changes no argument."""

    @property
    def name(self) -> str:
        """As mission files spell it."""
        ...

    @property
    def code(self) -> int:
        """On the wire."""
        ...

    @property
    def record(self) -> np.dtype[Any]:
        """Packed little-endian wire record of one cell; its first field is ``cell``."""
        ...

    def empty(self, grid: Grid, prior: npt.ArrayLike) -> BeliefMap:
        """Map of an agent that has seen nothing; ``prior`` (columns, rows) or one number."""
        ...

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
        """Map after an own reading of ``cell`` (column, row)."""
        ...

    def valid(self, belief: BeliefMap, records: Records, until_us: int | None = None) -> Bools:
        """Which records (k,) make sense; ``until_us``: none can have been observed after it."""
        ...

    def merge(self, belief: BeliefMap, records: Records) -> tuple[BeliefMap, I64]:
        """Map after received records (k,), and the flat cells that changed, ascending.

        Records that are not ``valid`` are ignored.
        """
        ...

    def records(self, belief: BeliefMap, cells: npt.ArrayLike) -> Records:
        """What to send of the flat cells (column * rows + row); none of a cell never seen."""
        ...


@dataclass(frozen=True, slots=True)
class BeliefUpdate:
    """Belief update, Khan 2014, Eq. (2): the latest observation of a cell wins."""

    name: str = "belief-update"
    code: int = 1

    @property
    def record(self) -> np.dtype[Any]:
        return _RECORD

    def empty(self, grid: Grid, prior: npt.ArrayLike) -> BeliefMap:
        value = np.broadcast_to(np.asarray(prior, dtype=np.float64), grid.shape)
        if not ((value >= 0.0) & (value <= 1.0)).all():
            raise ValueError("prior probabilities must lie in [0, 1]")
        return BeliefMap(
            _stored(value), np.full(grid.shape, -1, np.int64), np.full(grid.shape, -1, np.int32)
        )

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
        probability, stamp, origin = _copies(belief)
        probability[cell] = _stored(sensor.after(belief.probability[cell], detected))  # Eq. (1)
        stamp[cell] = max(t_us, int(belief.stamp_us[cell]) + 1)
        origin[cell] = agent
        return BeliefMap(probability, stamp, origin)

    def valid(self, belief: BeliefMap, records: Records, until_us: int | None = None) -> Bools:
        last = _LAST_US if until_us is None else min(until_us + _GRACE_US, _LAST_US)
        value, stamp = records["probability"], records["stamp_us"]
        known = (records["cell"] < belief.size) & (stamp >= 0) & (stamp <= last)
        return np.asarray(known & (value >= 0.0) & (value <= 1.0))  # NaN compares false

    def merge(self, belief: BeliefMap, records: Records) -> tuple[BeliefMap, I64]:
        best = _best_of_each_cell(records[self.valid(belief, records)])
        cells = best["cell"].astype(np.int64)
        value = _stored(best["probability"])
        mine = belief.probability.reshape(-1)[cells]
        stamp = belief.stamp_us.reshape(-1)[cells]
        origin = belief.origin.reshape(-1)[cells]
        later = best["stamp_us"] > stamp
        level = best["stamp_us"] == stamp
        tie = (best["origin"] > origin) | ((best["origin"] == origin) & (value > mine))
        wins = later | (level & tie)
        changed = cells[wins]
        if not len(changed):
            return belief, changed
        probabilities, stamps, origins = _copies(belief)
        probabilities.reshape(-1)[changed] = value[wins]  # Eq. (2)
        stamps.reshape(-1)[changed] = best["stamp_us"][wins]
        origins.reshape(-1)[changed] = best["origin"][wins]
        return BeliefMap(probabilities, stamps, origins), changed

    def records(self, belief: BeliefMap, cells: npt.ArrayLike) -> Records:
        flat = np.asarray(cells, dtype=np.int64).reshape(-1)
        flat = flat[belief.stamp_us.reshape(-1)[flat] >= 0]
        out = np.zeros(len(flat), _RECORD)
        out["cell"] = flat
        out["origin"] = belief.origin.reshape(-1)[flat]
        out["probability"] = belief.probability.reshape(-1)[flat]
        out["stamp_us"] = belief.stamp_us.reshape(-1)[flat]
        return out


_RECORD: np.dtype[Any] = np.dtype(
    [("cell", "<u4"), ("origin", "<u2"), ("probability", "<f4"), ("stamp_us", "<i8")]
)

MERGE_RULES: Mapping[str, MergeRule] = {"belief-update": BeliefUpdate()}


def unpack(rule: MergeRule, data: bytes) -> Records | None:
    """Records (k,) that a frame carries, or None when the bytes are not whole records."""
    if len(data) % rule.record.itemsize:
        return None
    return np.frombuffer(data, rule.record)


def _stored(value: npt.ArrayLike) -> F64:
    single = np.clip(np.asarray(value, dtype=np.float64), FLOOR, 1.0 - FLOOR).astype(np.float32)
    return single.astype(np.float64)


def _copies(belief: BeliefMap) -> tuple[F64, I64, npt.NDArray[np.int32]]:
    return belief.probability.copy(), belief.stamp_us.copy(), belief.origin.copy()


def _best_of_each_cell(records: Records) -> Records:
    """The greatest (stamp, origin, value) of every cell, ascending cells."""
    if len(records) < 2:
        return records
    order = np.lexsort(
        (records["probability"], records["origin"], records["stamp_us"], records["cell"])
    )
    ordered = records[order]
    last = np.append(ordered["cell"][1:] != ordered["cell"][:-1], True)
    best: Records = ordered[last]
    return best
