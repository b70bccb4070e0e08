"""A rectangular search area cut into square cells.

Cells are named (column, row): column 0 is the western one, row 0 the southern
one, so that ``cell = floor((point - origin) / cell_m)``. Maps over a grid are
arrays of shape (..., columns, rows).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True)
class Grid:
    """Origin (south-west corner, ENU m), side of a cell (m) and number of cells."""

    west_m: float
    south_m: float
    cell_m: float
    columns: int
    rows: int

    def __post_init__(self) -> None:
        if not self.cell_m > 0:
            raise ValueError(f"cell_m must be positive, not {self.cell_m}")
        if self.columns < 1 or self.rows < 1:
            raise ValueError(f"a grid needs cells, not {self.columns} x {self.rows}")

    @property
    def shape(self) -> tuple[int, int]:
        """(columns, rows)."""
        return self.columns, self.rows

    @property
    def size(self) -> int:
        """Number of cells."""
        return self.columns * self.rows

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """West, south, east, north in ENU m."""
        return (
            self.west_m,
            self.south_m,
            self.west_m + self.columns * self.cell_m,
            self.south_m + self.rows * self.cell_m,
        )

    def cell_of(self, points: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Cells that hold the points.

        Args:
            points: (..., 2 or more) ENU m; only x and y count.

        Returns:
            (..., 2) column and row; outside the area they lie outside the grid
            (the far edges belong to the last cell).
        """
        xy = np.asarray(points, dtype=np.float64)[..., :2]
        offset = xy - (self.west_m, self.south_m)
        cell = np.floor(offset / self.cell_m).astype(np.int64)
        extent = np.array(self.shape, dtype=np.float64) * self.cell_m
        return np.where(offset == extent, cell - 1, cell)

    def inside(self, cells: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which of the cells (..., 2) lie in the grid."""
        cell = np.asarray(cells)
        column, row = cell[..., 0], cell[..., 1]
        within: npt.NDArray[np.bool_] = np.asarray(
            (column >= 0) & (column < self.columns) & (row >= 0) & (row < self.rows)
        )
        return within

    def centre_of(self, cells: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Centres (..., 2) in ENU m of cells (..., 2)."""
        corner: npt.NDArray[np.float64] = np.asarray(cells, dtype=np.float64) + 0.5
        return corner * self.cell_m + (self.west_m, self.south_m)

    def contains(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which of the points (..., 2 or more) lie in the area, edges included."""
        return self.inside(self.cell_of(points))

    def clip(self, points: npt.ArrayLike, margin_m: float = 0.0) -> npt.NDArray[np.float64]:
        """Points (..., 2) moved into the area, ``margin_m`` from its edges."""
        west, south, east, north = self.bounds
        low = np.array([west + margin_m, south + margin_m])
        high = np.array([east - margin_m, north - margin_m])
        return np.clip(np.asarray(points, dtype=np.float64), low, np.maximum(low, high))
