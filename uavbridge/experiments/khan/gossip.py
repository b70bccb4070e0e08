"""Maps that merge over a radio which loses, delays and has few bytes to give.

A UAV keeps what it can tell as items: cells under the value rules, readings
under SDS, an agent's counts in a cell under COUNTS. Every step it broadcasts as
many as its budget of bytes allows, in the sizes of the wire records: first
those that changed since it last told them, the newest first; then those that
it told longest ago. It does not know who hears. What is heard is told on.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from planners.belief.counts import Counts
from planners.belief.evidence import posterior
from planners.belief.fusing import Cells
from planners.types import F64, I64, Bools
from uavbridge.experiments.khan.choices import KhanParams, rules
from uavbridge.experiments.khan.teams import ValueTeam, places, team_of
from uavbridge.experiments.khan.world import Team

COUNTS = "COUNTS"
_GROWTH = 64  # steps by which the log of readings grows


Told: TypeAlias = tuple[npt.NDArray[Any], ...]


class Store(Protocol):
    """What UAVs know, as items that can be told one by one."""

    @property
    def probability(self) -> F64:
        """(runs, N, cells)."""
        ...

    @property
    def items(self) -> int:
        """How many a UAV may know."""
        ...

    def observe(self, cells: I64, detected: Bools, t_us: int) -> I64:
        """Own readings (runs, N); the item (runs, N) that each changed."""
        ...

    def told(self, items: I64) -> Told:
        """What is sent of items (runs, N, b): arrays of that shape."""
        ...

    def hear(self, run: I64, uav: I64, items: I64, told: Told) -> Bools:
        """Items (m,) reach UAVs, with what is told (m,) of each; which of them were news."""
        ...

    def keep(self, runs: Bools) -> None:
        """Go on with these runs alone."""
        ...


class ValueStore:
    """Items are cells, told as stamped values."""

    def __init__(self, rule: str, choices: KhanParams, runs: int, uavs: int) -> None:
        self._team = ValueTeam(rules(choices)[rule], choices, runs, uavs)
        self.items = choices.columns * choices.rows

    @property
    def probability(self) -> F64:
        """(runs, N, cells)."""
        return self._team.probability

    def observe(self, cells: I64, detected: Bools, t_us: int) -> I64:
        self._team.observe(cells, detected, np.arange(cells.shape[1]), t_us)
        return cells

    def told(self, items: I64) -> Told:
        run, uav = np.ogrid[: items.shape[0], : items.shape[1]]
        cells = self._team.cells(places(self.probability, run[..., None], uav[..., None], items))
        return tuple(cells)

    def hear(self, run: I64, uav: I64, items: I64, told: Told) -> Bools:
        at = places(self.probability, run, uav, items)
        value, stamp, origin = (part[:, None] for part in told)
        heard = Cells(value.astype(np.float64), stamp.astype(np.int64), origin.astype(np.int32))
        changed = self._team.merge(at, heard, np.ones((len(at), 1), np.bool_))
        return np.isin(at, changed)

    def keep(self, runs: Bools) -> None:
        self._team.keep(runs)


class _Evidence:
    """Numbers of readings by cell, and the probabilities that follow."""

    def __init__(self, choices: KhanParams, runs: int, uavs: int) -> None:
        shape = (runs, uavs, choices.columns * choices.rows)
        self.probability = np.full(shape, 0.5)
        self._hits, self._misses = np.zeros(shape, np.int32), np.zeros(shape, np.int32)
        self._sensor = choices.sensor

    def add(self, run: I64, uav: I64, cell: I64, hits: I64 | Bools, misses: I64 | Bools) -> None:
        """Readings (m,) that UAVs now know of."""
        at = places(self.probability, run, uav, cell)
        h, m = self._hits.reshape(-1), self._misses.reshape(-1)
        np.add.at(h, at, hits.astype(np.int32))
        np.add.at(m, at, misses.astype(np.int32))
        self.probability.reshape(-1)[at] = posterior(0.5, h[at], m[at], self._sensor)

    def _keep(self, runs: Bools) -> None:
        self.probability = self.probability[runs]
        self._hits, self._misses = self._hits[runs], self._misses[runs]


class CountStore(_Evidence):
    """Items are (agent, cell), told as the agent's counts there; the greater is the newer."""

    def __init__(self, choices: KhanParams, runs: int, uavs: int) -> None:
        super().__init__(choices, runs, uavs)
        self._cells = choices.columns * choices.rows
        self.items = uavs * self._cells
        self._known = np.zeros((2, runs, uavs, self.items), np.int32)  # positive, negative

    def observe(self, cells: I64, detected: Bools, t_us: int) -> I64:
        run, uav = np.indices(cells.shape)
        items = np.asarray(uav * self._cells + cells)
        self._known[0, run, uav, items] += detected
        self._known[1, run, uav, items] += ~detected
        hit = detected.reshape(-1)
        self.add(run.reshape(-1), uav.reshape(-1), cells.reshape(-1), hit, ~hit)
        return items

    def told(self, items: I64) -> Told:
        run, uav = np.ogrid[: items.shape[0], : items.shape[1]]
        at = (run[..., None], uav[..., None], items)
        return self._known[0][at].astype(np.int64), self._known[1][at].astype(np.int64)

    def hear(self, run: I64, uav: I64, items: I64, told: Told) -> Bools:
        more = []
        for known, heard in zip(self._known, told, strict=True):
            before = known[run, uav, items]
            known[run, uav, items] = np.maximum(before, heard)
            more.append((known[run, uav, items] - before).astype(np.int64))
        news = (more[0] > 0) | (more[1] > 0)
        cell = items[news] % self._cells
        self.add(run[news], uav[news], cell, more[0][news], more[1][news])
        return np.asarray(news)

    def keep(self, runs: Bools) -> None:
        self._keep(runs)
        self._known = self._known[:, runs]


class ReadingStore(_Evidence):
    """Items are (step, agent): single readings, never counted twice."""

    def __init__(self, choices: KhanParams, runs: int, uavs: int) -> None:
        super().__init__(choices, runs, uavs)
        self._uavs, self._steps = uavs, 0
        self._cell = np.zeros((runs, 0), np.int64)
        self._hit = np.zeros((runs, 0), np.bool_)
        self._knows = np.zeros((runs, uavs, 0), np.bool_)
        self.items = 0

    def observe(self, cells: I64, detected: Bools, t_us: int) -> I64:
        first = self._steps * self._uavs
        if first == self.items:
            self._grow()
        run, uav = np.indices(cells.shape)
        items = np.asarray(first + uav)
        self._cell[:, first : first + self._uavs] = cells
        self._hit[:, first : first + self._uavs] = detected
        self._knows[run, uav, items] = True
        self._steps += 1
        hit = detected.reshape(-1)
        self.add(run.reshape(-1), uav.reshape(-1), cells.reshape(-1), hit, ~hit)
        return items

    def told(self, items: I64) -> Told:
        return ()  # a reading is what it is: the log has it

    def hear(self, run: I64, uav: I64, items: I64, told: Told) -> Bools:
        news = ~self._knows[run, uav, items]
        run, uav, items = run[news], uav[news], items[news]
        self._knows[run, uav, items] = True
        hit = np.asarray(self._hit[run, items])
        self.add(run, uav, self._cell[run, items], hit, ~hit)
        return np.asarray(news)

    def keep(self, runs: Bools) -> None:
        self._keep(runs)
        self._cell, self._hit = self._cell[runs], self._hit[runs]
        self._knows = self._knows[runs]

    def _grow(self) -> None:
        more = _GROWTH * self._uavs
        self._cell = np.pad(self._cell, ((0, 0), (0, more)))
        self._hit = np.pad(self._hit, ((0, 0), (0, more)))
        self._knows = np.pad(self._knows, ((0, 0), (0, 0), (0, more)))
        self.items += more


class _Message(NamedTuple):
    items: I64  # (runs, N, b)
    valid: Bools  # (runs, N, b)
    told: Told
    reach: Bools  # (runs, receivers, senders)


class GossipTeam:
    """UAVs that broadcast a few items a step.

    Args:
        store: what they know.
        record_bytes: of an item on the wire.
        budget_bytes: a UAV may send each step, carried over in parts of an item.
        delay: steps until a message arrives.
        runs: how many.
        uavs: N.
    """

    def __init__(
        self,
        store: Store,
        record_bytes: int,
        budget_bytes: float,
        delay: int,
        runs: int,
        uavs: int,
    ) -> None:
        self.bytes_sent = np.zeros(runs)
        self._store = store
        self._record_bytes, self._budget = record_bytes, budget_bytes
        self._delay, self._step = delay, 0
        self._changed = np.full((runs, uavs, store.items), -1, np.int32)  # -1: not known
        self._sent = np.full((runs, uavs, store.items), -1, np.int32)
        self._air: list[_Message] = []

    @property
    def probability(self) -> F64:
        """(runs, N, cells)."""
        return self._store.probability

    def observe(self, cells: I64, detected: Bools, who: I64, t_us: int) -> None:
        items = self._store.observe(cells, detected, t_us)
        missing = self._store.items - self._changed.shape[2]
        if missing:
            pad = ((0, 0), (0, 0), (0, missing))
            self._changed = np.pad(self._changed, pad, constant_values=-1)
            self._sent = np.pad(self._sent, pad, constant_values=-1)
        np.put_along_axis(self._changed, items[..., None], 2 * self._step, axis=2)

    def exchange(self, reach: Bools, cells: I64, who: I64) -> None:
        self._air.append(self._message(reach))
        if len(self._air) > self._delay:
            self._deliver(self._air.pop(0))
        self._step += 1

    def fade(self, share: float) -> None:
        raise ValueError("maps that forget do not gossip")

    def keep(self, runs: Bools) -> None:
        self._store.keep(runs)
        self.bytes_sent = self.bytes_sent[runs]
        self._changed, self._sent = self._changed[runs], self._sent[runs]
        self._air = [
            _Message(m.items[runs], m.valid[runs], tuple(t[runs] for t in m.told), m.reach[runs])
            for m in self._air
        ]

    def _message(self, reach: Bools) -> _Message:
        """What everybody sends now, by who changed it when and who sent it when."""
        share = self._budget / self._record_bytes
        count = int(share * (self._step + 1)) - int(share * self._step)
        count = min(count, self._changed.shape[2])
        now = 2 * self._step
        urgent = np.where(self._changed > self._sent, now + 1 + self._changed, -self._sent - 1)
        urgent = np.where(self._changed >= 0, urgent, np.iinfo(np.int32).min)
        if count < urgent.shape[2]:
            items = np.argpartition(-urgent.astype(np.int64), max(count - 1, 0), axis=2)
        else:
            items = np.broadcast_to(np.arange(count), urgent.shape)
        items = items[..., :count]
        valid = np.take_along_axis(self._changed, items, axis=2) >= 0
        before = np.take_along_axis(self._sent, items, axis=2)
        np.put_along_axis(self._sent, items, np.where(valid, now, before), axis=2)
        self.bytes_sent = self.bytes_sent + valid.sum(axis=(1, 2)) * float(self._record_bytes)
        return _Message(items, valid, self._store.told(items), reach)

    def _deliver(self, message: _Message) -> None:
        """One sender after the other; nobody hears itself."""
        width = message.items.shape[2]
        for sender in range(message.items.shape[1]):
            run, uav = np.nonzero(message.reach[:, :, sender])
            if not len(run) or not width:
                continue
            valid = message.valid[run, sender].reshape(-1)
            items = message.items[run, sender].reshape(-1)[valid]
            told = tuple(part[run, sender].reshape(-1)[valid] for part in message.told)
            run, uav = np.repeat(run, width)[valid], np.repeat(uav, width)[valid]
            news = self._store.hear(run, uav, items, told)
            self._changed[run[news], uav[news], items[news]] = 2 * self._step + 1


def record_bytes(rule: str, choices: KhanParams) -> int:
    """Bytes of one item on the wire."""
    if rule == COUNTS:
        return Counts().record.itemsize
    return rules(choices)[rule].record.itemsize


def gossip_of(
    rule: str, choices: KhanParams, runs: int, uavs: int, *, budget_bytes: float, delay: int = 0
) -> Team:
    """A fresh team under one of the paper's rules, or under COUNTS."""
    store: Store
    if rule == "UNC":
        return team_of(rule, choices, runs, uavs)  # nobody listens: nobody need send
    if rule == COUNTS:
        store = CountStore(choices, runs, uavs)
    elif rule == "SDS":
        store = ReadingStore(choices, runs, uavs)
    else:
        store = ValueStore(rule, choices, runs, uavs)
    return GossipTeam(store, record_bytes(rule, choices), budget_bytes, delay, runs, uavs)
