"""Who sees whom, and the seven nearest (Chen 2023, section 2.1).

Arrays have the aircraft on the axis before the last: position (..., n, 3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.terrain import Terrain
from planners.types import F64, I64, Bools


@dataclass(frozen=True, slots=True, eq=False)
class Near:
    """The nearest visible neighbours of every aircraft."""

    index: I64  # (..., n, k) which aircraft
    there: Bools  # (..., n, k) whether the place is taken
    offset: F64  # (..., n, k, 3) m, from the aircraft to the neighbour
    distance: F64  # (..., n, k) m
    velocity: F64  # (..., n, k, 3) m/s, the neighbour's
    visible: Bools  # (..., n, n) within perception and in sight

    @property
    def some(self) -> Bools:
        """(..., n) whether it has any."""
        return np.asarray(self.there.any(axis=-1))

    def mean(self, values: F64) -> F64:
        """Means (..., n, 3) over the neighbours of (..., n, k, 3); zero where there are none."""
        count = np.maximum(self.there.sum(axis=-1), 1)[..., None]
        total = np.where(self.there[..., None], values, 0.0).sum(axis=-2)
        return np.asarray(total / count)


def seen(position: F64, perception_m: float, terrain: Terrain | None = None) -> Bools:
    """Which aircraft (..., n, n) see each other: within perception, no ground between."""
    offset = position[..., None, :, :] - position[..., :, None, :]
    distance = np.sqrt((offset * offset).sum(axis=-1))
    count = position.shape[-2]
    visible = (distance <= perception_m) & ~np.eye(count, dtype=np.bool_)
    if terrain is None:
        return np.asarray(visible)
    upper = visible & np.triu(np.ones((count, count), np.bool_))
    pairs = np.nonzero(upper)
    if not len(pairs[0]):
        return np.asarray(visible)
    lead, first, second = pairs[:-2], pairs[-2], pairs[-1]
    clear = terrain.sees(position[(*lead, first)], position[(*lead, second)])
    upper[pairs] = clear
    return np.asarray(upper | np.swapaxes(upper, -1, -2))


def nearest(position: F64, velocity: F64, visible: Bools, count: int) -> Near:
    """The ``count`` nearest of those visible; of equals the one with the lower number."""
    offset = position[..., None, :, :] - position[..., :, None, :]
    distance = np.sqrt((offset * offset).sum(axis=-1))
    ranked = np.where(visible, distance, np.inf)
    size = min(count, position.shape[-2])
    index = np.argsort(ranked, axis=-1, kind="stable")[..., :size]
    chosen = np.take_along_axis(ranked, index, axis=-1)
    there = np.isfinite(chosen)
    towards = np.take_along_axis(offset, index[..., None], axis=-2)
    theirs = np.take_along_axis(
        np.broadcast_to(velocity[..., None, :, :], offset.shape), index[..., None], axis=-2
    )
    return Near(index, there, towards, np.where(there, chosen, np.inf), theirs, visible)


def unit(vector: F64) -> F64:
    """Vectors (..., 3) of length one; zero stays zero."""
    length = np.sqrt((vector * vector).sum(axis=-1, keepdims=True))
    return np.asarray(vector / np.where(length > 1e-9, length, np.inf))
