"""The eight headings of the lattice, and what lies in the sector of each (Shao 2020, Figs 3, 8)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from planners.pheromone.field import disc
from planners.types import F64, I64, Bools

# Heading h is h times 45 degrees from east, counter-clockwise.
STEPS: I64 = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
HEADINGS = len(STEPS)


def inside(cells: I64, shape: tuple[int, ...]) -> Bools:
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
    place, on_map = places(cells, offsets, values.shape[-2:])
    return np.where(on_map, taken(values, place), 0.0), on_map


def places(cells: I64, offsets: I64, shape: tuple[int, ...]) -> tuple[I64, Bools]:
    """Flat indices (..., n, k) on a map of (columns, rows) around cells, and which are on it."""
    around = cells[..., None, :] + offsets
    on_map = inside(around, shape)
    return np.where(on_map, around[..., 0] * shape[1] + around[..., 1], 0), on_map


def taken(values: F64, place: I64) -> F64:
    """Values (..., n, k) of maps (..., columns, rows) at flat indices."""
    size = values.shape[-2] * values.shape[-1]
    lots = values.size // size
    start = np.arange(lots).reshape(-1, 1) * size
    return np.asarray(values.reshape(-1)[place.reshape(lots, -1) + start].reshape(place.shape))


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
