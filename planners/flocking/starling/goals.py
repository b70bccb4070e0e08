"""What a flock should come to (Chen 2023, Eq. 1), and whether it holds together."""

from __future__ import annotations

import numpy as np

from planners.flocking.starling.near import unit
from planners.types import F64, I64


def polarisation(velocity: F64) -> F64:
    """|mean of the unit velocities| (...), 1 when all (..., n, 3) fly one way."""
    mean = unit(velocity).mean(axis=-2)
    return np.asarray(np.sqrt((mean * mean).sum(axis=-1)))


def speed_spread(velocity: F64) -> F64:
    """Mean difference (...) of the velocities (..., n, 3) of two aircraft, m/s."""
    return _pairs(velocity)[0]


def cohesion(position: F64) -> F64:
    """Mean distance (...) of two aircraft, m: the third of Eq. (1), per pair."""
    return _pairs(position)[0]


def separation(position: F64) -> F64:
    """Least distance (...) of two aircraft, m; inf for one."""
    return _pairs(position)[1]


def groups(position: F64, link_m: float) -> I64:
    """Number (...) of groups: aircraft at most ``link_m`` apart belong together."""
    offset = position[..., None, :, :] - position[..., :, None, :]
    linked = (offset * offset).sum(axis=-1) <= link_m**2
    count = position.shape[-2]
    label = np.broadcast_to(np.arange(count), linked.shape[:-1]).copy()
    for _ in range(count):
        label = np.where(linked, label[..., None, :], count).min(axis=-1)
    return np.asarray((label == np.arange(count)).sum(axis=-1), dtype=np.int64)


def _pairs(values: F64) -> tuple[F64, F64]:
    count = values.shape[-2]
    first, second = np.triu_indices(count, 1)
    offset = values[..., first, :] - values[..., second, :]
    distance = np.sqrt((offset * offset).sum(axis=-1))
    mean = distance.mean(axis=-1) if len(first) else np.zeros(values.shape[:-2])
    return np.asarray(mean), np.asarray(distance.min(axis=-1, initial=np.inf))
