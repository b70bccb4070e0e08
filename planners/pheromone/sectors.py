"""The eight headings of the lattice, and what lies in the sector of each (Shao 2020, Figs 3, 8)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from planners.pheromone.field import disc
from planners.types import F64, I64, Bools

# Heading h is h times 45 degrees from east, counter-clockwise.
STEPS: I64 = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
HEADINGS = len(STEPS)


def inside(cells: I64, shape: tuple[int, int]) -> Bools:
    """Which cells (..., 2) lie on a map of (columns, rows)."""
    column, row = cells[..., 0], cells[..., 1]
    return np.asarray((column >= 0) & (column < shape[0]) & (row >= 0) & (row < shape[1]))


def gathered(values: F64, cells: I64, offsets: I64) -> tuple[F64, Bools]:
    """Values around cells.

    Args:
        values: (..., columns, rows).
        cells: (..., n, 2).
        offsets: (k, 2).

    Returns:
        (..., n, k) values, 0 off the map, and which of the cells are on the map.
    """
    columns, rows = values.shape[-2:]
    around = cells[..., None, :] + offsets
    on_map = inside(around, (columns, rows))
    place = np.where(on_map, around[..., 0] * rows + around[..., 1], 0)
    flat = values.reshape(-1, columns * rows)
    found = np.take_along_axis(flat, place.reshape(len(flat), -1), axis=1).reshape(place.shape)
    return np.where(on_map, found, 0.0), on_map


def sector_means(values: F64, known: Bools, radius: float) -> F64:
    """Means (..., 8) over the cells of each heading's sector of 45 degrees.

    Args:
        values: (..., k) of the cells within ``radius``, in the order of ``sectors``.
        known: (..., k) which of them count: a cell off the map does not.
        radius: of the sensor, cells.

    Returns:
        Means; 0 for a sector without cells.
    """
    _, members = sectors(radius)
    return np.asarray((np.where(known, values, 0.0) @ members) / np.maximum(known @ members, 1.0))


@lru_cache(maxsize=16)
def sectors(radius: float) -> tuple[I64, F64]:
    """Cells (k, 2) within a radius but the own one, and in which of 8 sectors (k, 8) each is."""
    offsets = disc(radius)
    offsets = offsets[(offsets != 0).any(axis=1)]
    angle = np.arctan2(offsets[:, 1], offsets[:, 0])
    sector = np.round(angle / (np.pi / 4.0)).astype(np.int64) % HEADINGS
    return offsets, np.eye(HEADINGS)[sector]
