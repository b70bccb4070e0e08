"""The no-fly columns that one agent has seen so far."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from planners.types import F64
from uavbridge.bus.messages import Obstacle


class Sighted:
    """What an agent's detector has told it of obstacles, by the numbers that it gave them.

    Attributes:
        columns: (k, 3) x, y, radius in m, as planners are shown them.
    """

    def __init__(self) -> None:
        self.columns: F64 = np.zeros((0, 3))
        self._seen: dict[int, Obstacle] = {}

    def learn(self, obstacles: Iterable[Obstacle]) -> bool:
        """Remember what was seen; whether anything of it is new."""
        before = dict(self._seen)
        self._seen.update((one.number, one) for one in obstacles)
        if self._seen == before:
            return False
        self.columns = np.array([(one.x, one.y, one.radius_m) for one in self._each()])
        return True

    def kept_off(self) -> tuple[tuple[float, float, float], ...]:
        """x, y and radius in m of what vehicles must stay out of: the columns with their room."""
        return tuple((one.x, one.y, one.radius_m + one.room_m) for one in self._each())

    def _each(self) -> list[Obstacle]:
        return [self._seen[number] for number in sorted(self._seen)]
