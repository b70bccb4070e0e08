"""Sweeps of a grid: lists of cells (column, row), and closed loops made of them.

Khan, Yanmaz and Rinner 2014 let UAVs follow "a standard sweep model" without
saying which; these are the readings. A loop is flown for ever: after its last
cell comes its first. Where the two are not the same or adjacent, a straight
flight joins them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Cells: TypeAlias = npt.NDArray[np.int64]


def snake(
    columns: int, rows: int, *, along_rows: bool = True, east: bool = False, north: bool = False
) -> Cells:
    """Boustrophedon (columns * rows, 2) over all cells from one corner.

    Args:
        columns: of the grid.
        rows: of the grid.
        along_rows: rows are flown along, one after the other; else columns.
        east: start at the eastern end, else at the western.
        north: start at the northern end, else at the southern.
    """
    column_order = range(columns)[::-1] if east else range(columns)
    row_order = range(rows)[::-1] if north else range(rows)
    outer, inner = (row_order, column_order) if along_rows else (column_order, row_order)
    cells = []
    for turn, a in enumerate(outer):
        for b in inner if turn % 2 == 0 else inner[::-1]:
            cells.append((b, a) if along_rows else (a, b))
    return np.array(cells, dtype=np.int64)


def snake_and_back(columns: int, rows: int) -> Cells:
    """Row by row, then the same way back."""
    return there_and_back(snake(columns, rows))


def snake_and_jump(columns: int, rows: int) -> Cells:
    """Row by row, then straight to the first cell again."""
    return snake(columns, rows)


def closed_tour(columns: int, rows: int) -> Cells:
    """A round trip through every cell once, by steps to adjacent cells.

    With both numbers odd there is no such trip; the way home then has one
    straight flight. With a single row or column it goes there and back.
    """
    if min(columns, rows) == 1:
        return snake_and_back(columns, rows)
    if rows % 2 and columns % 2 == 0:
        return closed_tour(rows, columns)[:, ::-1].copy()
    inner = snake(columns - 1, rows) + np.array((1, 0))
    home = np.array([(0, row) for row in range(rows)[::-1]], dtype=np.int64)
    return np.concatenate((inner, home))


def columns_and_rows(columns: int, rows: int) -> Cells:
    """Column by column, then row by row from the corner reached, and so on until it closes."""
    corner, along_rows = (False, False), False
    parts: list[Cells] = []
    while not parts or (corner, along_rows) != ((False, False), False):
        east, north = corner
        part = snake(columns, rows, along_rows=along_rows, east=east, north=north)
        parts.append(part if not parts else part[1:])
        lines, across = (rows, columns) if along_rows else (columns, rows)
        inner_flips, outer_flips = lines % 2 == 1 and across > 1, lines > 1
        flips = (inner_flips, outer_flips) if along_rows else (outer_flips, inner_flips)
        corner = (corner[0] != flips[0], corner[1] != flips[1])
        along_rows = not along_rows
    loop = np.concatenate(parts)
    return loop[:-1] if len(loop) > 1 and (loop[-1] == loop[0]).all() else loop


def there_and_back(cells: Cells) -> Cells:
    """The loop that flies ``cells`` (k, 2) forwards, then backwards."""
    return np.concatenate((cells, cells[-2:0:-1]))


def corners(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """The points (m, 2) of a loop (k, 2) at which it turns.

    The first point stays, be it a turn or not; a point equal to its
    predecessor goes.
    """
    loop = np.asarray(points, dtype=np.float64)
    loop = loop[(loop != np.roll(loop, 1, axis=0)).any(axis=-1) | (np.arange(len(loop)) == 0)]
    before, after = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    dot = (before * after).sum(axis=-1)
    turns = (cross != 0.0) | (dot < 0.0)
    turns[0] = True
    kept: npt.NDArray[np.float64] = loop[turns]
    return kept


LOOPS: Mapping[str, Callable[[int, int], Cells]] = {
    "snake-and-back": snake_and_back,
    "snake-and-jump": snake_and_jump,
    "closed-tour": closed_tour,
    "columns-and-rows": columns_and_rows,
}
