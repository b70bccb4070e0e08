"""The detector of obstacles: which columns stand within its reach."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

AGAIN_S = 5.0  # between two reports of a column that stays in sight


class ObstacleSeen(NamedTuple):
    """One column in sight of one vehicle."""

    vehicle: int  # its row
    column: int  # its row


class ObstacleDetector:
    """One detector a vehicle. It makes no errors.

    A column is reported as soon as it is in reach, and again every ``AGAIN_S`` as long as it is.

    Args:
        columns: (k, 3) x, y and radius in m; they begin on the ground and have no end.
        reach_m: from a vehicle to a column's surface.
        vehicles: how many.
    """

    def __init__(self, columns: npt.NDArray[np.float64], reach_m: float, vehicles: int) -> None:
        self._columns, self._reach_m = columns, reach_m
        self._next_us = np.zeros((vehicles, len(columns)), np.int64)

    def look(self, t_us: int, position: npt.NDArray[np.float64]) -> list[ObstacleSeen]:
        """Reports due at ``t_us`` from positions (n, 3) ENU m, by vehicles, then columns."""
        apart = position[:, None, :2] - self._columns[:, :2]
        room_m = np.hypot(apart[..., 0], apart[..., 1]) - self._columns[:, 2]
        sees = room_m <= self._reach_m
        due = sees & (t_us >= self._next_us)
        self._next_us[due] = t_us + round(AGAIN_S * 1e6)
        self._next_us[~sees] = 0
        return [ObstacleSeen(i, j) for i, j in np.argwhere(due).tolist()]
