"""Messages on their way: a link takes its time, and has only so much bandwidth."""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heappop, heappush
from typing import Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from planners.types import I64
from uavbridge.radio import Queue, Radio, Transmissions, Verdict

T = TypeVar("T")


class Ripe(NamedTuple, Generic[T]):
    """A message that is delivered now."""

    receiver: int  # place among the agents of this process
    message: T


class Late(Generic[T]):
    """Holds what the radio delivers until it is due.

    Args:
        radio: decides how long that takes.
        receivers: (k,) ids of the agents of this process.
    """

    def __init__(self, radio: Radio, receivers: I64) -> None:
        self._radio, self._receivers = radio, receivers
        self._held: list[tuple[float, int, int, int, int, T]] = []
        self._queues: dict[tuple[int, int], Queue] = {}
        self._count = 0  # so that messages themselves are never compared

    def hold(
        self,
        messages: Sequence[T],
        sent: Transmissions,
        left_us: Sequence[float],
        verdicts: npt.NDArray[np.uint8],
        t_us: int,
    ) -> npt.NDArray[np.bool_]:
        """Keep what is not due yet; what finds a link's queue full is struck out.

        Args:
            messages: f, by sender and then by tick.
            sent: the same for the radio.
            left_us: (f,) when each left its sender.
            verdicts: (f, k), changed in place.
            t_us: now.

        Returns:
            (f, k) what is held, and no longer to be counted as delivered now.
        """
        due_us = np.array(left_us)[:, None] + self._radio.latency_us(sent, self._receivers)
        rate = self._radio.link_bytes_per_s(sent, self._receivers)
        for i, j in np.argwhere((verdicts == Verdict.DELIVERED) & np.isfinite(rate)).tolist():
            out_us = self._through(sent, i, j, float(rate[i, j]), left_us[i])
            if out_us is None:
                verdicts[i, j] = Verdict.QUEUE
            else:
                due_us[i, j] += out_us - left_us[i]
        held = (verdicts == Verdict.DELIVERED) & (due_us > t_us)
        for i, j in np.argwhere(held).tolist():
            self._count += 1
            order = (float(due_us[i, j]), int(sent.sender[i]), int(sent.tick[i]), j, self._count)
            heappush(self._held, (*order, messages[i]))
        return np.asarray(held)

    def due(self, t_us: int) -> list[Ripe[T]]:
        """What was held until now, by receiver, due time, sender and tick."""
        ripe = []
        while self._held and self._held[0][0] <= t_us:
            *_, receiver, _, message = heappop(self._held)
            ripe.append(Ripe(receiver, message))
        return sorted(ripe, key=lambda one: one.receiver)

    def _through(
        self, sent: Transmissions, i: int, j: int, rate: float, left_us: float
    ) -> float | None:
        link = int(sent.sender[i]), int(self._receivers[j])
        queue = self._queues.get(link)
        if queue is None:
            queue = self._queues[link] = Queue(rate, self._radio.quality.queue_s)
        return queue.leaves(int(sent.size[i]), left_us)
