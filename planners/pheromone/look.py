"""What a UAV is told of the field around it: the local pheromone map within its sensor radius."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.pheromone.field import Field
from planners.pheromone.law import Weights
from planners.pheromone.sectors import STEPS, gathered, places, sector_means, sectors, taken
from planners.types import F64, I64, Bools


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Pheromones of the cells around UAVs, in the order of ``sectors(radius)``.

    Values are those of single precision, as they travel.
    """

    target: F64  # (..., n, k)
    obstacle: F64  # (..., n, k)
    path: F64  # (..., n, k)
    known: Bools  # (..., n, k) on the map, and its place agent has answered
    radius: float

    def means(self, weights: Weights) -> F64:
        """Weighted sums (..., n, 8) of the mean pheromones in each sector (Fig. 3, Eq. 9)."""
        combined = (
            weights.target * self.target
            + weights.obstacle * self.obstacle
            + weights.path * self.path
        )
        return sector_means(combined, self.known, self.radius)


def look(field: Field, cells: I64, radius: float) -> Look:
    """The field around cells (..., n, 2)."""
    offsets, _ = sectors(radius)
    place, on_map = places(cells, offsets, field.path.shape[-2:])
    target, obstacle, path = (
        taken(layer, place).astype(np.float32).astype(np.float64)
        for layer in (field.target, field.obstacle, field.path)
    )
    return Look(target, obstacle, path, on_map, radius)


def free_steps(blocked: Bools, cells: I64) -> Bools:
    """Which of the eight neighbours (..., n, 8) of cells can be entered.

    Args:
        blocked: (..., columns, rows) known obstacles.
        cells: (..., n, 2).
    """
    closed, on_map = gathered(blocked.astype(np.float64), cells, STEPS)
    return np.asarray(on_map & (closed == 0.0))
