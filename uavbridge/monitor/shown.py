"""Belief maps as an onlooker puts them together: one of each agent, and the union of all."""

from __future__ import annotations

import numpy as np

from planners.belief.maps import blank
from planners.belief.merge import MERGE_RULES, BeliefMap, MergeRule, Records, SensorModel, unpack
from planners.grid import Grid
from planners.types import F64, I64, Bools
from uavbridge.bus.messages import FullMap
from uavbridge.bus.wire import Frame

RULES: dict[int, MergeRule] = {rule.code: rule for rule in MERGE_RULES.values()}


class AgentMap:
    """One agent's map, from what it says: whole maps, cells in its frames, whose frames it heard.

    Args:
        grid: the cells.
        prior: P(target) of a cell that nobody saw: one number, or (columns, rows).
        sensor: that rules which share readings need.
    """

    def __init__(self, grid: Grid, prior: float | F64, sensor: SensorModel) -> None:
        self.grid = grid
        self.probability: F64 = np.full(grid.shape, prior)
        self.stamp_us: I64 = np.full(grid.shape, -1, np.int64)
        self.t_us = -1  # of the newest message that it was made from
        self._prior, self._sensor = prior, sensor
        self._known: BeliefMap = blank(grid, prior)
        self._rule: MergeRule | None = None  # that ``_known`` belongs to

    @property
    def seen(self) -> Bools:
        """(columns, rows) cells that somebody saw, as far as the agent knows."""
        return np.asarray(self.stamp_us >= 0)

    def take_map(self, full: FullMap) -> None:
        """A whole map; where frames are newer than it, they stand."""
        if full.t_us >= self.t_us:
            self.t_us = full.t_us
            self.probability, self.stamp_us = full.probability.copy(), full.stamp_us.copy()
            return
        newer = full.stamp_us > self.stamp_us
        self.probability[newer], self.stamp_us[newer] = (
            full.probability[newer],
            full.stamp_us[newer],
        )

    def take_frame(self, frame: Frame, rule: MergeRule, records: Records) -> I64:
        """Cells in a frame of the agent's own; the flat cells (k,) that it told of."""
        self.t_us = max(self.t_us, frame.t_us)
        records = self._sound(rule, records, frame.t_us)
        if not tells_values(rule):
            return self._merge(rule, records)
        cells = records["cell"].astype(np.int64)
        probability, stamp_us = self.probability.reshape(-1), self.stamp_us.reshape(-1)
        probability[cells], stamp_us[cells] = records["probability"], records["stamp_us"]
        return cells

    def hear(self, frame: Frame, rule: MergeRule, records: Records) -> None:
        """Cells in a frame of another agent that this one heard."""
        if rule.onlooker == rule:  # else what an agent makes of it is its own affair
            self._merge(rule, self._sound(rule, records, frame.t_us))

    def _sound(self, rule: MergeRule, records: Records, t_us: int) -> Records:
        if self._rule is None or rule.code != self._rule.code:
            self._rule = rule
            self._known = rule.onlooker.empty(self.grid, self._prior, self._sensor)
        sound: Records = records[rule.valid(self._known, records, until_us=t_us)]
        return sound

    def _merge(self, rule: MergeRule, records: Records) -> I64:
        """Take in what tells more than is known; the flat cells (k,) that it told of."""
        probability, stamp_us = self.probability.reshape(-1), self.stamp_us.reshape(-1)
        if tells_values(rule):
            records = records[records["stamp_us"] > stamp_us[records["cell"]]]
            cells = records["cell"].astype(np.int64)
            probability[cells], stamp_us[cells] = records["probability"], records["stamp_us"]
            return cells
        # Readings, not values: the map follows from all that the agent told and heard.
        self._known, cells = rule.onlooker.merge(self._known, records)
        probability[cells] = self._known.probability.reshape(-1)[cells]
        stamp_us[cells] = self._known.stamp_us.reshape(-1)[cells]
        return cells


class UnionMap:
    """The union of all agents' maps, as the judge makes it; whole maps fill what was missed.

    Args:
        grid: the cells.
        prior: P(target) of a cell that nobody saw: one number, or (columns, rows).
        sensor: that rules which share readings need.
    """

    def __init__(self, grid: Grid, prior: float | F64, sensor: SensorModel) -> None:
        self.grid = grid
        self._prior, self._sensor = prior, sensor
        self._rule: MergeRule | None = None
        self._heard: BeliefMap = blank(grid, prior)
        self._base: F64 = np.full(grid.shape, prior)
        self._base_us: I64 = np.full(grid.shape, -1, np.int64)
        self._waiting: list[Records] = []

    def take_map(self, full: FullMap) -> None:
        """One agent's whole map."""
        newer = full.stamp_us > self._base_us
        self._base[newer], self._base_us[newer] = full.probability[newer], full.stamp_us[newer]

    def take_records(self, rule: MergeRule, records: Records) -> None:
        """Cells of any agent's frame."""
        if self._rule is None or rule.code != self._rule.code:
            self._flush()
            self._rule = rule
            self._heard = rule.onlooker.empty(self.grid, self._prior, self._sensor)
        if len(records):
            self._waiting.append(records)

    def shown(self) -> tuple[F64, I64]:
        """Probability and time of the newest look (-1: never), both (columns, rows)."""
        self._flush()
        heard = self._heard
        missed = self._base_us > heard.stamp_us
        if not missed.any():
            return heard.probability, heard.stamp_us
        probability: F64 = np.where(missed, self._base, heard.probability)
        stamp_us: I64 = np.where(missed, self._base_us, heard.stamp_us)
        return probability, stamp_us

    def _flush(self) -> None:
        """An onlooker's rule does not mind the order, so what waits is merged at once."""
        if self._waiting and self._rule is not None:
            records = np.concatenate(self._waiting)
            self._heard, _ = self._rule.onlooker.merge(self._heard, records)
        self._waiting.clear()


def tells_values(rule: MergeRule) -> bool:
    """Whether a record says what a cell's value is; else values follow from many readings."""
    return {"probability", "stamp_us"} <= set(rule.record.names or ())


def readable(frame: Frame) -> tuple[MergeRule, Records] | None:
    """Rule and records of a frame's cells; None when nobody here can read them."""
    rule = RULES.get(frame.rule)
    records = None if rule is None else unpack(rule, frame.cells)
    return None if rule is None or records is None else (rule, records)
