"""Sensed data sharing: the readings themselves travel, and no value is merged.

Khan, Yanmaz and Rinner 2014, "Information merging in multi-UAV cooperative
search", section IV-B.4: "each UAV keeps a record of sensor observations for
each and every cell" and applies Eq. (1) to all of them.

| symbol | name |
| --- | --- |
| O_{i,c,t} | (t_us, agent, detected) in ``History.readings[c]`` |

A reading is known by cell, agent and time, so that none counts twice. What is
sent of a cell is its whole history: maps converge whatever is lost, late or
repeated, and the price is bytes that grow with every look.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from planners.belief.evidence import EvidenceMap, posterior
from planners.belief.maps import BeliefMap, SensorModel, blank
from planners.belief.rule import MergeRule, Records, latest_us
from planners.grid import Grid
from planners.types import I64, Bools

Look: TypeAlias = tuple[int, int, bool]  # t_us, agent, detected

_RECORD: np.dtype[Any] = np.dtype(
    [("cell", "<u4"), ("origin", "<u2"), ("detected", "u1"), ("stamp_us", "<i8")]
)


@dataclass(frozen=True, slots=True, eq=False)
class History(EvidenceMap):
    """A map with the readings that it follows from."""

    readings: Mapping[int, frozenset[Look]]  # by flat cell


@dataclass(frozen=True, slots=True)
class SensedData:
    """Sensed data sharing, Khan 2014, section IV-B.4."""

    name: str = "sensed-data"
    code: int = 6

    @property
    def record(self) -> np.dtype[Any]:
        return _RECORD

    @property
    def item(self) -> tuple[str, ...]:
        return ("cell", "origin", "detected", "stamp_us")

    @property
    def compared(self) -> tuple[str, ...]:
        return ("cell", "origin", "detected", "stamp_us")

    @property
    def onlooker(self) -> MergeRule:
        return self

    def empty(
        self, grid: Grid, prior: npt.ArrayLike, sensor: SensorModel | None = None
    ) -> BeliefMap:
        bare = blank(grid, prior)
        return History(
            bare.probability,
            bare.stamp_us,
            bare.origin,
            bare.probability,
            sensor or SensorModel(),
            {},
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
        known = _history(belief)
        flat = cell[0] * belief.probability.shape[1] + cell[1]
        own = [t for t, who, _ in known.readings.get(flat, ()) if who == agent]
        look = (max(t_us, max(own, default=-1) + 1), agent, bool(detected))
        return _with(replace(known, sensor=sensor), {flat: {look}})

    def valid(self, belief: BeliefMap, records: Records, until_us: int | None = None) -> Bools:
        stamp = records["stamp_us"]
        known = (records["cell"] < belief.size) & (stamp >= 0) & (stamp <= latest_us(until_us))
        return np.asarray(known & (records["detected"] <= 1))

    def merge(self, belief: BeliefMap, records: Records) -> tuple[BeliefMap, I64]:
        known = _history(belief)
        sound = records[self.valid(belief, records)]
        new: dict[int, set[Look]] = {}
        for cell, agent, detected, t_us in sound.tolist():
            look = (t_us, agent, bool(detected))
            if look not in known.readings.get(cell, ()):
                new.setdefault(cell, set()).add(look)
        if not new:
            return belief, np.zeros(0, np.int64)
        return _with(known, new), np.array(sorted(new), np.int64)

    def records(self, belief: BeliefMap, cells: npt.ArrayLike) -> Records:
        readings = _history(belief).readings
        out = [
            (cell, agent, detected, t_us)
            for cell in np.asarray(cells, np.int64).reshape(-1).tolist()
            for t_us, agent, detected in sorted(readings.get(cell, ()))
        ]
        return np.array(out, _RECORD)


def _with(known: History, new: Mapping[int, set[Look]]) -> History:
    """The map after readings that it did not have."""
    readings = {**known.readings}
    probability, stamp = known.probability.copy(), known.stamp_us.copy()
    origin = known.origin.copy()
    cells = list(new)
    for cell in cells:
        readings[cell] = readings.get(cell, frozenset()) | new[cell]
        stamp.reshape(-1)[cell], origin.reshape(-1)[cell], _ = max(readings[cell])
    hits = [sum(detected for *_, detected in readings[cell]) for cell in cells]
    misses = [len(readings[cell]) - hit for cell, hit in zip(cells, hits, strict=True)]
    prior = known.prior.reshape(-1)[cells]
    probability.reshape(-1)[cells] = posterior(prior, hits, misses, known.sensor)
    return History(probability, stamp, origin, known.prior, known.sensor, readings)


def _history(belief: BeliefMap) -> History:
    if not isinstance(belief, History):
        raise TypeError(f"sensed data sharing needs its own map, not a {type(belief).__name__}")
    return belief
