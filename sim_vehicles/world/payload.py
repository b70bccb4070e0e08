"""The payload sensor: does the cell below hold a target?

Khan 2014, Eq. (1)'s sensor: a reading is positive with probability p over a
cell with a target and q over one without. A vehicle takes one reading when it
enters a cell (as Liu 2022's numbers demand), and, if a period is given, further
ones for as long as it stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from planners.grid import Grid


class Sighting(NamedTuple):
    """One reading of one vehicle's sensor."""

    vehicle: int  # its row
    cell: tuple[int, int]  # (column, row)
    detected: bool


class Sensor(Protocol):
    """Looks at the world from all vehicles at once."""

    def look(self, t_us: int, position: npt.NDArray[np.float64]) -> list[Sighting]:
        """Readings due at ``t_us`` from positions (n, 3) ENU m, in order of the vehicles."""
        ...


@dataclass(frozen=True, slots=True)
class CellSensorSpec:
    """True properties of the sensor."""

    p: float = 0.9  # P(positive, target in the cell)
    q: float = 0.05  # P(positive, no target in the cell)
    period_s: float = 0.0  # between readings within one cell; 0: only when entering it
    height_min_m: float = 5.0  # below it the sensor sees nothing
    reach_m: float = 0.0  # cells whose centre is this near to that of the vehicle's are seen, too


class CellSensor:
    """One sensor a vehicle, each with its own random stream.

    Args:
        grid: the cells.
        targets: (m, 2) ENU m, true positions.
        spec: true sensor properties.
        generators: one a vehicle; draws depend on nothing but its own earlier readings.
    """

    def __init__(
        self,
        grid: Grid,
        targets: npt.NDArray[np.float64],
        spec: CellSensorSpec,
        generators: Sequence[np.random.Generator],
    ) -> None:
        self._grid = grid
        self._spec = spec
        self._generators = generators
        self._truth = np.zeros(grid.shape, dtype=np.bool_)
        for column, row in grid.cell_of(np.reshape(targets, (-1, 2))):
            self._truth[column, row] = True
        n = len(generators)
        self._cell = np.full((n, 2), -1, dtype=np.int64)  # last looked at; -1: none
        self._next_us = np.zeros(n, dtype=np.int64)
        self._around = _around(spec.reach_m / grid.cell_m)

    def look(self, t_us: int, position: npt.NDArray[np.float64]) -> list[Sighting]:
        cells = self._grid.cell_of(position)
        sees = self._grid.inside(cells) & (position[:, 2] >= self._spec.height_min_m)
        entered = (cells != self._cell).any(axis=1)
        due = sees & entered
        if self._spec.period_s > 0:
            due |= sees & (t_us >= self._next_us)
        self._cell[sees] = cells[sees]
        indices = np.flatnonzero(due).tolist()
        seen = [(i, cells[i] + offset) for i in indices for offset in self._around]
        return [self._read(i, t_us, cell) for i, cell in seen if self._grid.inside(cell)]

    def _read(self, index: int, t_us: int, cell: npt.NDArray[np.int64]) -> Sighting:
        column, row = cell.tolist()
        chance = self._spec.p if self._truth[column, row] else self._spec.q
        self._next_us[index] = t_us + round(self._spec.period_s * 1e6)
        return Sighting(index, (column, row), bool(self._generators[index].random() < chance))


def _around(reach: float) -> npt.NDArray[np.int64]:
    """Offsets (k, 2) of the cells within a reach, the own one first."""
    side = np.arange(-int(reach), int(reach) + 1)
    offsets = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(-1, 2)
    distance = np.hypot(offsets[:, 0], offsets[:, 1])
    order = np.argsort(distance, kind="stable")
    return np.asarray(offsets[order[distance[order] <= reach]])
