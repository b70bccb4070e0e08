"""An agent's belief map: what it sensed and heard, what it owes the others, what it declares."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np

from planners.belief.merge import BeliefMap, Records, unpack
from planners.types import Reading
from uavbridge.agent.plan import AgentPlan
from uavbridge.bus.wire import Frame


class Mapping:
    """Belief, changed cells not yet sent, declared targets."""

    def __init__(self, plan: AgentPlan) -> None:
        self._plan = plan
        self._grid = plan.scenario.grid
        self.belief: BeliefMap = plan.rule.empty(self._grid, plan.prior, plan.sensor)
        self.declared: dict[int, int] = {}  # flat cell -> t_us of its declaration
        self.unreadable = 0  # frames of another merge rule, records that make no sense
        self._changed: set[int] = set()

    def observe(self, reading: Reading) -> None:
        """A look of the own sensor."""
        if not self._grid.inside(reading.cell):
            return
        self.belief = self._plan.rule.observe(
            self.belief,
            reading.cell,
            reading.detected,
            self._plan.sensor,
            t_us=reading.t_us,
            agent=self._plan.agent,
        )
        flat = reading.cell[0] * self._grid.rows + reading.cell[1]
        self._changed.add(flat)
        self._declare([flat], reading.t_us)

    def merge(self, frames: Sequence[Frame]) -> None:
        """Cells that others sent. What was heard together is merged together."""
        rule = self._plan.rule
        parts = [part for frame in frames if len(part := self._sound(frame))]
        if not parts:
            return
        self.belief, changed = rule.merge(self.belief, np.concatenate(parts))
        cells: list[int] = changed.tolist()
        self._changed.update(cells)
        self._declare(cells, max(frame.t_us for frame in frames))

    def _sound(self, frame: Frame) -> Records:
        """The records of a frame that make sense; the rest is counted."""
        rule = self._plan.rule
        records = unpack(rule, frame.cells) if frame.rule == rule.code else None
        if records is None:
            self.unreadable += 1
            return np.zeros(0, rule.record)
        # Nothing can have been observed after it was sent: a clock ahead must not win for ever.
        honest = rule.valid(self.belief, records, until_us=frame.t_us)
        self.unreadable += int(len(records) - honest.sum())
        return records[honest]

    def _declare(self, cells: list[int], t_us: int) -> None:
        flat = self.belief.probability.reshape(-1)
        for cell in cells:
            p = float(flat[cell])
            if isfinite(p) and p >= self._plan.scenario.detection_threshold:
                self.declared.setdefault(cell, t_us)

    def take_changed(self) -> bytes:
        """Records of the cells changed since the last call."""
        cells = np.array(sorted(self._changed), dtype=np.int64)
        self._changed.clear()
        return self._plan.rule.records(self.belief, cells).tobytes()

    def take_all(self) -> bytes:
        """Records of all cells that anybody has seen."""
        self._changed.clear()
        cells = np.flatnonzero(self.belief.seen.reshape(-1))
        return self._plan.rule.records(self.belief, cells).tobytes()
