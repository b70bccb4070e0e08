"""Links that wrap a link: record what passes, lose some of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np

from uavbridge.mavlink.link import Link

Direction: TypeAlias = Literal["received", "sent"]
Sink: TypeAlias = Callable[[int, Direction, bytes], None]
"""Gets (mission time in microseconds, direction, one datagram of raw frames)."""


class TlogLink:
    """Shows every datagram, both ways, to a sink, in order.

    Args:
        link: what carries them.
        sink: is given each.
        now: tells mission time in microseconds.
    """

    def __init__(self, link: Link, sink: Sink, now: Callable[[], int]) -> None:
        self._link, self._sink, self._now = link, sink, now

    def send(self, data: bytes) -> None:
        self._sink(self._now(), "sent", data)
        self._link.send(data)

    def receive(self) -> list[bytes]:
        datagrams = self._link.receive()
        if datagrams:
            t_us = self._now()
            for datagram in datagrams:
                self._sink(t_us, "received", datagram)
        return datagrams

    def close(self) -> None:
        self._link.close()


class LossyLink:
    """Loses datagrams both ways, each with the same probability.

    Args:
        link: what carries the rest.
        loss: probability 0..1 that a datagram is lost.
        rng: drawn once for every datagram.
    """

    def __init__(self, link: Link, loss: float, rng: np.random.Generator) -> None:
        if not 0.0 <= loss <= 1.0:
            raise ValueError(f"loss must be 0..1, not {loss}")
        self._link, self._loss, self._rng = link, loss, rng
        self.dropped = 0

    def _lost(self) -> bool:
        lost = bool(self._rng.random() < self._loss)
        self.dropped += lost
        return lost

    def send(self, data: bytes) -> None:
        if not self._lost():
            self._link.send(data)

    def receive(self) -> list[bytes]:
        return [data for data in self._link.receive() if not self._lost()]

    def close(self) -> None:
        self._link.close()
