"""Conflict-free merging: every agent counts its own readings, and counts merge by maximum.

A map holds for each cell and each agent how many positive and how many negative
readings that agent took there. Only the agent itself ever raises its counts, so
the greater number is the newer one, and merging is the element-wise maximum:
idempotent, commutative, associative. By whatever route a count arrives, how
often and in which order, it is counted once. The probability of a cell follows
from the sums over agents (``planners.belief.evidence``), as with sensed data
sharing (Khan, Yanmaz and Rinner 2014, section IV-B.4), but the bytes do not grow
with the number of looks.

An agent that restarts has lost its counts. It begins a new life: counts are
kept by (agent, ``born``), the second of mission time of its first reading since
its start, so that the old life's counts stay what they are. (Lives that begin
within one second share their counts, and readings are lost, never doubled.)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from planners.belief.evidence import EvidenceMap, posterior
from planners.belief.maps import BeliefMap, SensorModel, blank
from planners.belief.rule import MergeRule, Records, latest_us
from planners.grid import Grid
from planners.types import I64, MICROSECONDS, Bools

_RECORD: np.dtype[Any] = np.dtype(
    [
        ("cell", "<u4"),
        ("agent", "<u2"),
        ("born", "<u4"),  # second of mission time
        ("positive", "<u2"),
        ("negative", "<u2"),
        ("stamp_ms", "<u4"),  # of the last of these readings
    ]
)
_CELLS = 1 << 24  # a key holds cell, agent and birth, 24 + 16 + 24 bits
_BIRTHS = 1 << 24
_MOST = 2**16 - 1  # readings of a kind, by one agent in one cell


@dataclass(frozen=True, slots=True, eq=False)
class Tally(EvidenceMap):
    """A map with the counts that it follows from; arrays (k,), ascending keys."""

    key: npt.NDArray[np.uint64]  # cell, agent and birth
    positive: I64
    negative: I64
    stamp_ms: I64
    born: int  # second of the own first reading; -1: none yet


@dataclass(frozen=True, slots=True)
class Counts:
    """Counts of readings by agent and cell, merged by element-wise maximum."""

    name: str = "counts"
    code: int = 7

    @property
    def record(self) -> np.dtype[Any]:
        return _RECORD

    @property
    def item(self) -> tuple[str, ...]:
        return ("cell", "agent", "born")

    @property
    def compared(self) -> tuple[str, ...]:
        return ("cell", "agent", "born", "positive", "negative", "stamp_ms")

    @property
    def onlooker(self) -> MergeRule:
        return self

    def empty(
        self, grid: Grid, prior: npt.ArrayLike, sensor: SensorModel | None = None
    ) -> BeliefMap:
        if grid.size > _CELLS:
            raise ValueError(f"merging by counts knows {_CELLS} cells, not {grid.size}")
        bare, none = blank(grid, prior), np.zeros(0, np.int64)
        return Tally(
            bare.probability,
            bare.stamp_us,
            bare.origin,
            prior=bare.probability,
            sensor=sensor or SensorModel(),
            key=np.zeros(0, np.uint64),
            positive=none,
            negative=none,
            stamp_ms=none,
            born=-1,
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
        known = _tally(belief)
        if known.born < 0:
            known = replace(known, born=min(t_us // MICROSECONDS, _BIRTHS - 1))
        flat = cell[0] * belief.probability.shape[1] + cell[1]
        own = np.zeros(1, _RECORD)
        own["cell"], own["agent"], own["born"] = flat, agent, known.born
        place = _places(known.key, _keys(own))[0]
        before = (known.positive[place], known.negative[place]) if place >= 0 else (0, 0)
        own["positive"] = min(int(before[0]) + bool(detected), _MOST)
        own["negative"] = min(int(before[1]) + (not detected), _MOST)
        own["stamp_ms"] = max(t_us, known.born * MICROSECONDS) // 1000
        return _with(replace(known, sensor=sensor), own)[0]

    def valid(self, belief: BeliefMap, records: Records, until_us: int | None = None) -> Bools:
        stamp_us = records["stamp_ms"].astype(np.int64) * 1000
        born_ms = records["born"].astype(np.int64) * 1000
        known = (records["cell"] < belief.size) & (stamp_us <= latest_us(until_us))
        known &= (records["born"] < _BIRTHS) & (born_ms <= records["stamp_ms"])
        return np.asarray(known & ((records["positive"] > 0) | (records["negative"] > 0)))

    def merge(self, belief: BeliefMap, records: Records) -> tuple[BeliefMap, I64]:
        return _with(_tally(belief), records[self.valid(belief, records)])

    def records(self, belief: BeliefMap, cells: npt.ArrayLike) -> Records:
        known = _tally(belief)
        wanted = np.zeros(belief.size, np.bool_)
        wanted[np.asarray(cells, np.int64).reshape(-1)] = True
        pick = wanted[_cell_of(known.key)]
        key = known.key[pick]
        out = np.zeros(len(key), _RECORD)
        out["cell"] = key >> np.uint64(40)
        out["agent"] = (key >> np.uint64(24)) & np.uint64(0xFFFF)
        out["born"] = key & np.uint64(_BIRTHS - 1)
        out["positive"], out["negative"] = known.positive[pick], known.negative[pick]
        out["stamp_ms"] = known.stamp_ms[pick]
        return out


def _with(known: Tally, records: Records) -> tuple[Tally, I64]:
    """The element-wise maximum of a map's counts and records, and the cells that changed."""
    given = _keys(records)
    key = np.union1d(known.key, given)
    table = np.zeros((3, len(key)), np.int64)
    table[:, np.searchsorted(key, known.key)] = (known.positive, known.negative, known.stamp_ms)
    before = table.copy()
    place = np.searchsorted(key, given)
    for row, name in zip(table, ("positive", "negative", "stamp_ms"), strict=True):
        np.maximum.at(row, place, records[name].astype(np.int64))
    changed = np.unique(_cell_of(key[(table != before).any(axis=0)]))
    if not len(changed):
        return known, changed
    after = replace(known, key=key, positive=table[0], negative=table[1], stamp_ms=table[2])
    return _shown(after, changed), changed


def _shown(known: Tally, changed: I64) -> Tally:
    """The map with probability, stamp and origin of the changed cells (m,) worked out anew."""
    cell = _cell_of(known.key)
    place = np.searchsorted(changed, cell)
    mine = (place < len(changed)) & (changed[np.minimum(place, len(changed) - 1)] == cell)
    place, key, stamp = place[mine], known.key[mine], known.stamp_ms[mine]
    hits = np.bincount(place, known.positive[mine], len(changed))
    misses = np.bincount(place, known.negative[mine], len(changed))
    order = np.lexsort((key, stamp, place))  # the newest of each cell comes last
    last = order[np.append(np.diff(place[order]) > 0, True)]
    probability, stamp_us, origin = (
        known.probability.copy(),
        known.stamp_us.copy(),
        known.origin.copy(),
    )
    prior = known.prior.reshape(-1)[changed]
    probability.reshape(-1)[changed] = posterior(prior, hits, misses, known.sensor)
    stamp_us.reshape(-1)[changed] = stamp[last] * 1000
    origin.reshape(-1)[changed] = (key[last] >> np.uint64(24)) & np.uint64(0xFFFF)
    return replace(known, probability=probability, stamp_us=stamp_us, origin=origin)


def _keys(records: Records) -> npt.NDArray[np.uint64]:
    cell, agent = records["cell"].astype(np.uint64), records["agent"].astype(np.uint64)
    born = records["born"].astype(np.uint64)
    joined: npt.NDArray[np.uint64] = (cell << np.uint64(40)) | (agent << np.uint64(24)) | born
    return joined


def _cell_of(key: npt.NDArray[np.uint64]) -> I64:
    return (key >> np.uint64(40)).astype(np.int64)


def _places(key: npt.NDArray[np.uint64], wanted: npt.NDArray[np.uint64]) -> I64:
    """Where the wanted keys are; -1: nowhere."""
    place = np.searchsorted(key, wanted)
    inside = np.minimum(place, max(len(key) - 1, 0))
    found = (
        (place < len(key)) & (key[inside] == wanted) if len(key) else np.zeros(len(wanted), bool)
    )
    return np.where(found, place, -1).astype(np.int64)


def _tally(belief: BeliefMap) -> Tally:
    if not isinstance(belief, Tally):
        raise TypeError(f"merging by counts needs its own map, not a {type(belief).__name__}")
    return belief
