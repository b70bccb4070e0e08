"""Who hears whom, and when: the one place that decides a delivery, live and in experiments.

The decision is a function of what was sent and where both ends were; nothing here depends
on the order of arrival: chance is drawn by (seed, sender, receiver, tick).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from math import inf, isfinite, sqrt

import numpy as np
import numpy.typing as npt

from planners.types import F64, I64, Bools
from uavbridge.clock import SECOND_US
from uavbridge.radio.draws import Purpose, draw, in_burst
from uavbridge.radio.quality import PLAIN, Link, Quality, spread


class Verdict(IntEnum):
    """What becomes of one transmission at one receiver."""

    DELIVERED = 0
    OWN = 1  # an agent does not hear itself
    OUT_OF_RANGE = 2
    LOSS = 3
    BURST = 4  # lost in a burst
    QUEUE = 5  # no bandwidth, and the queue was full
    HELD = 6  # on its way: decided, but not delivered yet

    @property
    def reason(self) -> str:
        """In words, as accounts and recordings have it."""
        return self.name.lower().replace("_", " ")


_DELIVERED, _OUT_OF_RANGE, _OWN = (
    np.uint8(verdict.value) for verdict in (Verdict.DELIVERED, Verdict.OUT_OF_RANGE, Verdict.OWN)
)


@dataclass(frozen=True, slots=True, eq=False)
class Transmissions:
    """What was sent, one a row, with where the sender was at that time."""

    sender: I64  # (f,) ids
    tick: I64  # (f,) with sender and receiver, the key of every draw
    position: F64  # (f, 3) ENU m at sending time
    size: I64  # (f,) bytes


@dataclass(frozen=True, slots=True)
class Radio:
    """The links between any two agents.

    Attributes:
        range_m: longest link, inclusive, straight-line distance; infinity: unlimited.
        seed: of the mission.
        quality: what all links do; its range is ``range_m``, its bandwidth that of each sender.
        links: exceptions; of two for one link the later one counts. A bandwidth here is that of
            the link alone, beside the sender's.
        longest_m: range of the longest link.
        needs_positions: whether a verdict depends on where anybody is.
        delivers_at_once: whether what is delivered is so as soon as it has arrived.
        only_range: whether nothing but distance decides.

    Raises:
        ValueError: a number is out of its bounds.
    """

    range_m: float
    seed: int = 0
    quality: Quality = PLAIN
    links: tuple[Link, ...] = ()

    longest_m: float = field(init=False, repr=False, compare=False)
    needs_positions: bool = field(init=False, repr=False, compare=False)
    delivers_at_once: bool = field(init=False, repr=False, compare=False)
    only_range: bool = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        quality = replace(self.quality, range_m=self.range_m)
        ranges = [link.over(quality).range_m for link in (Link(), *self.links)]
        slow = quality.delay_s or quality.jitter_s or isfinite(quality.bytes_per_s)
        for name, value in (
            ("quality", quality),
            ("longest_m", max(ranges)),
            ("needs_positions", isfinite(min(ranges))),
            ("delivers_at_once", not slow and not any(link.slows for link in self.links)),
            ("only_range", not (slow or self.links or quality.loss or quality.burst_enter)),
        ):
            object.__setattr__(self, name, value)

    def words(self) -> str:
        """What is emulated, in short; empty: nothing but a radio that always delivers."""
        said = self.quality.words()
        if self.links:
            said.append(f"{len(self.links)} links of their own")
        return ", ".join(said)

    def reaches(self, sender: npt.ArrayLike, receivers: npt.ArrayLike) -> Bools:
        """Which links are short enough, but for exceptions.

        Args:
            sender: (..., 3) ENU m at sending time.
            receivers: (..., 3) ENU m at the same time; broadcast against ``sender``.

        Returns:
            (...) bools. A position that is not a number reaches nobody.
        """
        return _within(sender, receivers, np.array(self.range_m))

    def reaches_one(self, sender: Sequence[float], receiver: Sequence[float]) -> bool:
        """``reaches`` for one link, (3,) ENU m each."""
        x, y, z = sender[0] - receiver[0], sender[1] - receiver[1], sender[2] - receiver[2]
        return sqrt(x * x + y * y + z * z) <= self.range_m or not self.needs_positions

    def judge(self, sent: Transmissions, receiver: I64, position: F64) -> npt.NDArray[np.uint8]:
        """The verdict on each transmission at each receiver.

        Args:
            sent: f transmissions.
            receiver: (k,) ids.
            position: (f, k, 3) ENU m of the receivers when each was sent.

        Returns:
            (f, k) values of ``Verdict``.
        """
        range_m = self._spread("range_m", sent, receiver)
        within = _within(sent.position[:, None, :], position, range_m)
        verdict = np.where(within, _DELIVERED, _OUT_OF_RANGE)
        if self.links or self.quality.burst_enter:
            self._burst(sent, receiver, verdict)
        if self.links or self.quality.loss:
            self._lose(Verdict.LOSS, "loss", Purpose.LOSS, sent, receiver, verdict)
        verdict[sent.sender[:, None] == receiver] = _OWN
        return verdict

    def latency_us(self, sent: Transmissions, receiver: I64) -> F64:
        """Time (f, k) from a transmission to its delivery, in us; bandwidth not counted."""
        late = np.zeros((len(sent.sender), len(receiver)))
        late += self._spread("delay_s", sent, receiver)
        jitter_s = self._spread("jitter_s", sent, receiver)
        if jitter_s.any():
            sender, tick = sent.sender[:, None], sent.tick[:, None]
            late += jitter_s * draw(self.seed, Purpose.JITTER, sender, receiver, tick)
        return np.rint(late * SECOND_US)

    def link_bytes_per_s(self, sent: Transmissions, receiver: I64) -> F64:
        """Bandwidth (f, k) of the links alone; infinity: none of their own."""
        free = replace(self.quality, bytes_per_s=inf)
        rate = spread("bytes_per_s", free, self.links, sent.sender, receiver)
        return np.broadcast_to(rate, (len(sent.sender), len(receiver)))

    def _spread(self, name: str, sent: Transmissions, receiver: I64) -> F64:
        return spread(name, self.quality, self.links, sent.sender, receiver)

    def _burst(self, sent: Transmissions, receiver: I64, verdict: npt.NDArray[np.uint8]) -> None:
        """Strike out what falls into a burst."""
        enter = np.broadcast_to(self._spread("burst_enter", sent, receiver), verdict.shape)
        rows, columns = np.nonzero((verdict == Verdict.DELIVERED) & (enter > 0.0))
        if not len(rows):
            return
        leave = np.broadcast_to(self._spread("burst_leave", sent, receiver), verdict.shape)
        at = rows, columns
        bad = in_burst(
            self.seed, sent.sender[rows], receiver[columns], sent.tick[rows], enter[at], leave[at]
        )
        hit = np.full(verdict.shape, Verdict.DELIVERED, np.uint8)
        self._lose(Verdict.BURST, "burst_loss", Purpose.BURST_LOSS, sent, receiver, hit)
        verdict[at] = np.where(bad, hit[at], verdict[at])

    def _lose(
        self,
        fate: Verdict,
        name: str,
        purpose: Purpose,
        sent: Transmissions,
        receiver: I64,
        verdict: npt.NDArray[np.uint8],
    ) -> None:
        """Strike out what chance takes of what is delivered so far."""
        chance = self._spread(name, sent, receiver)
        if not chance.any():
            return
        u = draw(self.seed, purpose, sent.sender[:, None], receiver, sent.tick[:, None])
        verdict[(u < chance) & (verdict == Verdict.DELIVERED)] = fate


def _within(sender: npt.ArrayLike, receivers: npt.ArrayLike, range_m: F64) -> Bools:
    apart = np.asarray(receivers, np.float64) - np.asarray(sender, np.float64)
    if np.isinf(range_m).all():
        return np.ones(apart.shape[:-1], np.bool_)
    distance: F64 = np.sqrt(np.einsum("...i,...i->...", apart, apart))
    within: Bools = np.asarray(distance <= range_m)
    return within
