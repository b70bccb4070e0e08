"""Bandwidth: what is sent faster than a radio carries it waits; a full queue loses it."""

from __future__ import annotations

from dataclasses import dataclass, field

from uavbridge.clock import SECOND_US


@dataclass(slots=True, eq=False)
class Queue:
    """First come, first served, at a constant rate.

    Attributes:
        bytes_per_s: how much goes out.
        longest_s: how long a message may wait before it goes out.
    """

    bytes_per_s: float
    longest_s: float
    _free_us: float = field(default=0.0, init=False)  # when all that waits now is out

    def leaves(self, size: int, t_us: float) -> float | None:
        """When a message of so many bytes is out (us), if it is put in at ``t_us``.

        None: the queue is full, and it is lost. Times must not go backwards.
        """
        start_us = max(t_us, self._free_us)
        if start_us - t_us > self.longest_s * SECOND_US:
            return None
        self._free_us = start_us + size / self.bytes_per_s * SECOND_US
        return self._free_us
