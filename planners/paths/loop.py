"""Following closed polylines, any number of vehicles at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

_F64 = npt.NDArray[np.float64]
_I64 = npt.NDArray[np.int64]


def stack(loops: Sequence[_F64]) -> tuple[_F64, _I64]:
    """Loops (m_i, 2) as one array (n, max m, 2), padded, and their lengths (n,)."""
    count = np.array([len(loop) for loop in loops], dtype=np.int64)
    points = np.zeros((len(loops), int(count.max()), 2))
    for row, loop in zip(points, loops, strict=True):
        row[: len(loop)] = loop
    return points, count


def target(points: _F64, leg: _I64) -> _F64:
    """The points (..., 2) numbered ``leg`` (...) of loops (..., m, 2)."""
    lead = np.broadcast_shapes(points.shape[:-2], leg.shape)
    loops = np.broadcast_to(points, (*lead, *points.shape[-2:]))
    index = np.broadcast_to(leg, lead)[..., None, None]
    return np.take_along_axis(loops, index, axis=-2)[..., 0, :]


def advance(position: _F64, points: _F64, count: _I64, leg: _I64, reach_m: float) -> _I64:
    """Number (...) of the point to fly to: the next one where ``leg`` (...) is reached.

    Args:
        position: (..., 2) m.
        points: (..., m, 2) m.
        count: (...) points of each loop.
        leg: (...) numbers of the points flown to so far.
        reach_m: closer than or at this a point is reached.
    """
    offset = target(points, leg) - position
    reached = np.hypot(offset[..., 0], offset[..., 1]) <= reach_m
    return np.asarray(np.where(reached, (leg + 1) % count, leg))


def towards(position: _F64, goal: _F64, speed_m_s: float, step_s: float) -> _F64:
    """Velocities (..., 2) to points (..., 2) that do not overshoot within ``step_s``."""
    offset = goal - position
    distance = np.hypot(offset[..., 0], offset[..., 1])[..., None]
    pace = np.minimum(speed_m_s, distance / step_s)
    return np.asarray(offset / np.where(distance > 0.0, distance, 1.0) * pace)
