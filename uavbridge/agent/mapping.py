"""An agent's belief map: what it sensed and heard, what it owes the others, what it declares."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate, groupby
from math import inf, isfinite
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from planners.belief.merge import BeliefMap, MergeRule, Records
from planners.types import I64, Reading
from uavbridge.agent.catching_up import CatchingUp
from uavbridge.agent.obstacles import Sighted
from uavbridge.agent.outbox import Outbox
from uavbridge.agent.plan import AgentPlan
from uavbridge.agent.relaying import UNKNOWN, Relaying, Sources
from uavbridge.bus.wire import Frame, Probe, heard_size


class Told(NamedTuple):
    """What a frame says of the map."""

    cells: bytes  # records of the merge rule
    whole: bool  # of every cell known
    root: int
    heard: int  # whose frames of one tick before were heard
    probes: tuple[Probe, ...]


class Mapping:
    """Belief, what others are to be told of it, declared targets."""

    def __init__(self, plan: AgentPlan) -> None:
        self._plan = plan
        self._grid = plan.scenario.grid
        self.belief: BeliefMap = plan.rule.empty(self._grid, plan.prior, plan.sensor)
        self.declared: dict[int, int] = {}  # flat cell -> t_us of its declaration
        self.obstacles = Sighted()
        self.unreadable = 0  # frames of another merge rule, records that make no sense
        self._outbox = Outbox(plan.rule)
        self._catching_up = CatchingUp(plan.agent, plan.rule, self._grid.size, self._outbox)
        self._compared = _compared(plan.rule)
        self._relaying = Relaying(plan.agent, plan.scenario.team)

    def observe(self, reading: Reading) -> None:
        """A look of the own sensor."""
        if not self._grid.inside(reading.cell):
            return
        before = self.belief
        self.belief = self._plan.rule.observe(
            before,
            reading.cell,
            reading.detected,
            self._plan.sensor,
            t_us=reading.t_us,
            agent=self._plan.agent,
        )
        flat = reading.cell[0] * self._grid.rows + reading.cell[1]
        self._learn(before, np.array([flat]), own=True)
        self._declare([flat], reading.t_us)

    def merge(self, frames: Sequence[Frame]) -> None:
        """Cells that others sent. What was heard together is merged together."""
        rule = self._plan.rule
        heard = self._sound(frames)
        if len(heard):
            before = self.belief
            self.belief, changed = rule.merge(before, heard)
            self._learn(before, changed, own=False, frames=frames)
            self._outbox.heard(heard)
            self._declare(changed.tolist(), max(frame.t_us for frame in frames))
        ours = [frame for frame in frames if frame.rule == rule.code]
        self._relaying.heard(ours)
        self.unreadable += self._catching_up.heard(ours)

    def _learn(
        self, before: BeliefMap, cells: I64, *, own: bool, frames: Sequence[Frame] = ()
    ) -> None:
        """Cells (m,) changed, by what frames told: others are to be told what is new in them."""
        if not len(cells):
            return
        rule, size = self._plan.rule, self._plan.rule.record.itemsize
        old = set(_each(rule.records(before, cells).tobytes(), size))
        records = rule.records(self.belief, cells)
        new = records[[record not in old for record in _each(records.tobytes(), size)]]
        at = new["cell"]
        now, then = self.belief.probability.reshape(-1)[at], before.probability.reshape(-1)[at]
        self._outbox.changed(new, np.abs(now - then), own=own, sources=self._sources(new, frames))
        self._catching_up.learned(self.belief, cells)

    def _sources(self, new: Records, frames: Sequence[Frame]) -> list[Sources]:
        """Whose frames told each of some records (k,); of several ticks the last counts."""
        rule, size = self._plan.rule, self._plan.rule.record.itemsize
        if not frames:
            return [UNKNOWN] * len(new)
        wanted = self._contents(new.tobytes())
        found = dict.fromkeys(wanted, UNKNOWN)
        for frame in frames:
            if not frame.cells or frame.rule != rule.code or len(frame.cells) % size:
                continue
            told = found.keys() & self._contents(frame.cells)
            if told:
                source = self._relaying.source(frame)
                found.update({content: source.joined(found[content]) for content in told})
        return [found[content] for content in wanted]

    def _contents(self, records: bytes) -> list[bytes]:
        """What each of some records says that merging looks at."""
        parts, whole = self._compared, _each(records, self._plan.rule.record.itemsize)
        if not parts:
            return whole
        return [b"".join([record[part] for part in parts]) for record in whole]

    def _sound(self, frames: Sequence[Frame]) -> Records:
        """The records of frames that make sense, in their order; the rest is counted."""
        rule, good = self._plan.rule, []
        size = rule.record.itemsize
        for frame in frames:
            if frame.rule == rule.code and len(frame.cells) % size == 0:
                good.append(frame)
            else:
                self.unreadable += 1
        telling = [frame for frame in good if frame.cells]
        parts = [
            self._honest(b"".join(frame.cells for frame in together), until_us)
            for until_us, together in groupby(telling, attrgetter("t_us"))
        ]
        if not parts:
            return np.zeros(0, rule.record)
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def _honest(self, cells: bytes, sent_us: int) -> Records:
        """Those of some records that can be true; nothing was observed after it was sent."""
        rule = self._plan.rule
        records = np.frombuffer(cells, rule.record)
        honest = rule.valid(self.belief, records, until_us=sent_us)
        if honest.all():
            return records
        self.unreadable += int(len(records) - honest.sum())
        sound: Records = records[honest]
        return sound

    def _declare(self, cells: list[int], t_us: int) -> None:
        flat = self.belief.probability.reshape(-1)
        for cell in cells:
            p = float(flat[cell])
            if isfinite(p) and p >= self._plan.scenario.detection_threshold:
                self.declared.setdefault(cell, t_us)

    def tell(self, tick: int, room: float = inf, *, whole: bool = False) -> Told:
        """What the next frame says of the map; call it once a frame.

        Args:
            tick: of the frame.
            room: bytes for records and probes.
            whole: tell all that is known, as far as there is room; the rest goes later.
        """
        record = self._plan.rule.record.itemsize
        heard = self._relaying.tell(tick)
        room -= heard_size(heard)
        # a probe may fill a small frame, but not every one
        probes = self._catching_up.probes(tick, room if tick % 2 else room - record)
        room -= sum(probe.size for probe in probes)
        if whole:
            self._outbox.asked_for(np.flatnonzero(self.belief.seen.reshape(-1)))
        cells = self._outbox.take(self.belief, room, self._relaying.needed)
        rest = self._outbox.waiting or self._outbox.asked
        return Told(cells, whole and not rest, self._catching_up.root, heard, probes)


def _compared(rule: MergeRule) -> list[slice]:
    """Where in a record's bytes the fields are that the rule compares; none: everywhere."""
    names = rule.record.names or ()
    if rule.compared == names:
        return []
    sizes = [rule.record[name].itemsize for name in names]
    ends = dict(zip(names, accumulate(sizes), strict=True))
    return [slice(ends[name] - rule.record[name].itemsize, ends[name]) for name in rule.compared]


def _each(data: bytes, size: int) -> list[bytes]:
    """The bytes of each record of a size."""
    return [data[start : start + size] for start in range(0, len(data), size)]
