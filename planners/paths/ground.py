"""How high straight lines pass over the ground: exact, so that nothing is too thin to be seen.

Along a straight line within one cell of a bilinear lattice the ground's height is a quadratic, so
that three heights tell the least gap between two lattice lines. Chen 2023, section 3.3, samples
paths instead, and warns that sparse samples miss barriers.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from planners.terrain import Terrain

_F64 = npt.NDArray[np.float64]
_BLOCK = 1 << 16  # pieces of lines looked at at once
_SOME = np.linspace(0.0, 1.0, 17)[:, None]


def gaps(terrain: Terrain, start: npt.ArrayLike, end: npt.ArrayLike) -> _F64:
    """Least heights (...) in m above ground of the lines between points (..., 3)."""
    here, there = np.broadcast_arrays(
        np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    )
    lead = here.shape[:-1]
    first, last = here.reshape(-1, 3), there.reshape(-1, 3)
    reach = np.abs(last[:, :2] - first[:, :2]).max(initial=0.0) / terrain.cell_m
    rows = max(int(_BLOCK / (2.0 * reach + 4.0)), 1)
    parts = [
        _gaps(terrain, first[at : at + rows], last[at : at + rows])
        for at in range(0, max(len(first), 1), rows)
    ]
    return np.concatenate(parts).reshape(lead)


def clear(
    terrain: Terrain, start: npt.ArrayLike, end: npt.ArrayLike, clearance_m: float
) -> npt.NDArray[np.bool_]:
    """Which lines (...) between points (..., 3) stay ``clearance_m`` above the ground."""
    here, there = np.broadcast_arrays(
        np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    )
    first, last = here.reshape(-1, 3), there.reshape(-1, 3)
    # A few samples tell most of the lines that are blocked; the others are looked at exactly.
    some = first[:, None] + _SOME * (last - first)[:, None]
    free = (some[..., 2] - terrain.height_at(some) >= clearance_m - 1e-9).all(axis=1)
    free[free] = gaps(terrain, first[free], last[free]) >= clearance_m - 1e-9
    return np.asarray(free.reshape(here.shape[:-1]))


def path_gap(terrain: Terrain, points: _F64) -> float:
    """Least height in m above ground of the polyline (n, 3)."""
    if len(points) < 2:
        return float((points[:, 2] - terrain.height_at(points)).min())
    return float(gaps(terrain, points[:-1], points[1:]).min())


def _gaps(terrain: Terrain, first: _F64, last: _F64) -> _F64:
    origin = np.array((terrain.west_m, terrain.south_m))
    lattice = (first[:, :2] - origin) / terrain.cell_m, (last[:, :2] - origin) / terrain.cell_m
    share = np.sort(np.concatenate([_crossings(*lattice, axis) for axis in (0, 1)], axis=1))
    ends = np.zeros((len(first), 1))
    share = np.concatenate((ends, share, ends + 1.0), axis=1)
    way = last - first
    at_lines = _above(terrain, first, way, share)
    between = _above(terrain, first, way, (share[:, 1:] + share[:, :-1]) / 2.0)
    before, after = at_lines[:, :-1], at_lines[:, 1:]
    # With s from -1 to 1 over a piece the gap is between + slope s + bend s^2.
    slope, bend = (after - before) / 2.0, (after + before) / 2.0 - between
    inner = (bend > 0.0) & (np.abs(slope) < 2.0 * bend)
    lowest = between - np.where(inner, slope * slope / (4.0 * np.where(inner, bend, 1.0)), 0.0)
    least = np.where(inner, lowest, np.minimum(before, after))
    return np.asarray(least.min(axis=1))


def _crossings(here: _F64, there: _F64, axis: int) -> _F64:
    """Shares (n, k) of the way at which lattice lines are crossed; 0 or 1 where there is none."""
    begin, end = here[:, axis], there[:, axis]
    low = np.floor(np.minimum(begin, end))
    count = int((np.ceil(np.maximum(begin, end)) - low).max(initial=0.0))
    lines = low[:, None] + np.arange(1, count + 1)
    length = end - begin
    moving = np.abs(length) > 0.0
    share = (lines - begin[:, None]) / np.where(moving, length, 1.0)[:, None]
    return np.clip(np.where(moving[:, None], share, 0.0), 0.0, 1.0)


def _above(terrain: Terrain, first: _F64, way: _F64, share: _F64) -> _F64:
    points = first[:, None] + share[..., None] * way[:, None]
    return np.asarray(points[..., 2] - terrain.height_at(points))
