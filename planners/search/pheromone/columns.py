"""Columns that nobody may fly through, as closed cells of the lattice."""

from __future__ import annotations

import numpy as np

from planners.grid import Grid
from planners.types import F64, I64, Bools


def closed_cells(grid: Grid, columns: F64, cells: I64, clearance_m: float) -> Bools:
    """Which cells have their centre in a column, or too near to one.

    Args:
        grid: the lattice.
        columns: (k, 3) x, y, radius in m.
        cells: (..., 2).
        clearance_m: kept from a column's surface.
    """
    apart = grid.centre_of(cells)[..., None, :] - columns[:, :2]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    return np.asarray((distance < columns[:, 2] + clearance_m).any(axis=-1))
