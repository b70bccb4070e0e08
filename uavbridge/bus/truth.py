"""True positions over time, for the radio's decision alone."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, deque
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from planners.types import F64
from uavbridge.bus import keys
from uavbridge.bus.api import Bus, Mailbox
from uavbridge.bus.messages import Truth, decode_truth
from uavbridge.bus.wire import Vector

MEMORY = 1024  # samples


class TruthTrack:
    """The last true positions of the simulated vehicles, by time.

    Between two samples of the same vehicles it interpolates; before the first and
    after the last it knows nothing.

    Args:
        bus: follow ``world/truth`` there; None: fed by ``add`` alone.
        memory: samples kept.
    """

    def __init__(self, bus: Bus | None = None, *, memory: int = MEMORY) -> None:
        self.rejects: Counter[str] = Counter()
        self._samples: deque[Truth] = deque(maxlen=memory)
        self._mailbox: Mailbox | None = bus.subscribe(keys.TRUTH) if bus else None

    def add(self, t_us: int, ids: Sequence[int], positions: npt.ArrayLike) -> None:
        """Note where the vehicles are; a sample older than the newest is dropped.

        Args:
            t_us: mission time.
            ids: (n,) ascending.
            positions: (n, 3) ENU m; copied.
        """
        self._append(Truth(t_us, tuple(ids), np.array(positions, np.float64).reshape(-1, 3)))

    def poll(self) -> None:
        """Take in what the bus brought."""
        if self._mailbox is None:
            return
        for sample in self._mailbox.drain():
            truth = decode_truth(sample.data, self.rejects)
            if truth is not None:
                self._append(truth)

    @property
    def newest_us(self) -> int | None:
        """Time of the newest sample; None before the first."""
        return self._samples[-1].t_us if self._samples else None

    def when(self, t_us: int) -> Truth | None:
        """All positions at one time; None when that is outside the memory."""
        samples = self._samples
        if not samples or not samples[0].t_us <= t_us <= samples[-1].t_us:
            return None
        i = bisect_left(samples, t_us, key=lambda sample: sample.t_us)
        after = samples[i]
        if after.t_us == t_us:
            return after
        before = samples[i - 1]
        if before.ids != after.ids:
            return before
        share = (t_us - before.t_us) / (after.t_us - before.t_us)
        return Truth(t_us, after.ids, before.position + share * (after.position - before.position))

    def nearest(self, t_us: int) -> Truth | None:
        """The sample at the end of the memory that is closer to ``t_us``; None when empty."""
        if not self._samples:
            return None
        return self._samples[-1] if t_us > self._samples[-1].t_us else self._samples[0]

    def at(self, t_us: int, agent: int) -> Vector | None:
        """True position of one vehicle (ENU m) at one time; None when not known."""
        truth = self.when(t_us)
        if truth is None or agent not in truth.ids:
            return None
        x, y, z = truth.position[truth.ids.index(agent)].tolist()
        return x, y, z

    def _append(self, truth: Truth) -> None:
        if self._samples and truth.t_us <= self._samples[-1].t_us:
            if truth.t_us == self._samples[-1].t_us:
                self._samples[-1] = truth
            return
        self._samples.append(truth)


def rows_of(truth: Truth, agents: Sequence[int], known: F64) -> F64:
    """True positions (k, 3) of agents; those the truth does not know keep their ``known`` one."""
    row = {agent: i for i, agent in enumerate(truth.ids)}
    found = [(i, row[agent]) for i, agent in enumerate(agents) if agent in row]
    position = known.copy()
    if found:
        here, there = np.array(found).T
        position[here] = truth.position[there]
    return position
