"""The three rules of Reynolds' boids as batched kernels.

Reynolds 1987, "Flocks, herds and schools"; as used for comparison by Liu et al.
2022, sections 5.1.4 and 5.1.5, which give the safe distance (120 m) and no weights.

| rule | function |
| --- | --- |
| collision avoidance | ``separation`` |
| velocity matching | ``alignment`` |
| flock centering | ``cohesion`` |

Each takes ``position`` or ``velocity`` (..., 2), the neighbours' (..., k, 2) and
``near`` (..., k), the neighbours that count, and returns (..., 2) without unit,
at most about 1 long, zero when nobody counts.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from planners.types import F64, Bools


def within(position: F64, others: F64, present: Bools, radius_m: float) -> Bools:
    """Which neighbours (..., k) are present and no farther than ``radius_m``."""
    offset = others - position[..., None, :]
    distance = np.hypot(offset[..., 0], offset[..., 1])
    return np.asarray(present & (distance <= radius_m))


def separation(position: F64, others: F64, near: Bools, safe_m: float) -> F64:
    """Away from neighbours closer than ``safe_m``, the more the closer."""
    away = position[..., None, :] - others
    distance = np.hypot(away[..., 0], away[..., 1])
    close = near & (distance < safe_m) & (distance > 0.0)
    weight = np.where(close, (1.0 - distance / safe_m) / np.where(close, distance, 1.0), 0.0)
    return np.asarray((np.where(close[..., None], away, 0.0) * weight[..., None]).sum(axis=-2))


def alignment(velocity: F64, theirs: F64, near: Bools, speed_m_s: float) -> F64:
    """Towards the neighbours' mean velocity, in units of ``speed_m_s``."""
    mean, some = _mean(theirs, near)
    return np.asarray(np.where(some, (mean - velocity) / speed_m_s, 0.0))


def cohesion(position: F64, others: F64, near: Bools, radius_m: float) -> F64:
    """Towards the neighbours' centre, in units of ``radius_m``."""
    mean, some = _mean(others, near)
    return np.asarray(np.where(some, (mean - position) / radius_m, 0.0))


def _mean(values: F64, near: Bools) -> tuple[F64, npt.NDArray[np.bool_]]:
    """Mean (..., 2) over the rows that count, and (..., 1) whether there are any."""
    count = near.sum(axis=-1)[..., None]
    total = np.where(near[..., None], values, 0.0).sum(axis=-2)
    return np.asarray(total / np.maximum(count, 1)), np.asarray(count > 0)
