"""Lattices for the experiments of Shao 2020: obstacles, targets, starts.

The paper shows obstacles and targets in pictures only; all of this is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.pheromone.field import around
from planners.types import F64, I64, Bools

_SIDE = 4  # cells, of the largest block of obstacles
_MOST = 10_000  # tries to place a block


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """Some runs' lattices, all of one size."""

    obstacles: Bools  # (runs, columns, rows)
    targets: I64  # (runs, T, 2) cells, all free and within reach of each other
    starts: I64  # (runs, n, 2) cells, free
    headings: I64  # (runs, n) 0..7


def draw(
    draws: list[np.random.Generator], size: int, targets: int, n: int, share: float, starts: str
) -> Ground:
    """Lattices at random, one a generator.

    Args:
        draws: one a run.
        size: columns, and rows.
        targets: a run.
        n: UAVs a run.
        share: of the cells that are obstacles, in blocks of up to 4 x 4.
        starts: "anywhere", or "corner": the south-western tenth of the map.
    """
    parts = [_one(each, size, targets, n, share, starts) for each in draws]
    return Ground(*(np.stack(part) for part in zip(*parts, strict=True)))


def _one(
    draw_: np.random.Generator, size: int, targets: int, n: int, share: float, starts: str
) -> tuple[Bools, I64, I64, I64]:
    """The layout does not depend on ``n``: teams of all sizes are compared on the same ground."""
    obstacles = _blocks(draw_, size, share)
    free = np.argwhere(~obstacles)
    targets_ = free[draw_.choice(len(free), targets, replace=False)]
    order = draw_.permutation(len(free))
    if starts == "corner":
        order = order[(free[order] < max(size // 10, 1)).all(axis=1)]
    places = free[order[np.arange(n) % max(len(order), 1)]] if len(order) else free[:1].repeat(n, 0)
    return obstacles, targets_, places, draw_.integers(0, 8, n)


def _blocks(draw_: np.random.Generator, size: int, share: float) -> Bools:
    """Rectangles at random; pockets that nobody could reach are obstacles too."""
    obstacles = np.zeros((size, size), np.bool_)
    for _ in range(_MOST):
        if obstacles.sum() >= share * size * size:
            break
        column, row = draw_.integers(0, size, 2)
        width, height = draw_.integers(1, _SIDE + 1, 2)
        obstacles[column : column + width, row : row + height] = True
    return ~reached(~obstacles)


def reached(free: Bools) -> Bools:
    """The largest part of the free cells (columns, rows) within which all can be reached."""
    left, largest = free.copy(), np.zeros_like(free)
    while left.sum() > largest.sum():
        part = np.zeros_like(free)
        part[tuple(np.argwhere(left)[0])] = True
        grown = 0
        while part.sum() > grown:
            grown = int(part.sum())
            part = left & (part | (around(part.astype(np.float64)) > 0.0))
        left &= ~part
        if part.sum() > largest.sum():
            largest = part
    return largest


def shares(covered: Bools) -> F64:
    """Share (runs,) of all cells that are covered (runs, columns, rows)."""
    return np.asarray(covered.mean(axis=(1, 2)))
