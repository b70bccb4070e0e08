"""Liu's pair function: keep a given distance to the closest neighbours.

Liu et al. 2022, "Emergent search of UAV swarm guided by the target probability
map", Appl. Sci. 12, 5086: Eqs. (7)-(9), and the neighbours' part of Eq. (6).

    g(d) = t (1 - exp(-(d - c)^2 / delta'^2))           (7)
    a(d) = k (d - c) exp(-(d - c)^2 / delta^2)          (8)
    beta(d) = a(d) g(d)                                 (9)

| symbol | name |
| --- | --- |
| d_i | ``distance`` |
| k_i, t_i, c_i | ``PairLaw.k``, ``PairLaw.t``, ``PairLaw.c_m`` |
| delta_i, delta'_i | ``PairLaw.delta_m``, ``PairLaw.delta_g_m`` |
| beta_i | ``beta`` |
| F_i / norm(F_i) | ``away`` |

DEVIATION: the paper says "direction to the neighbour", with which k = -80 would
attract below 120 m and repel above. F_i is read as pointing away from the
neighbour: repulsion below c, attraction above, as the text wants. Both die out:
beyond about 220 m, and below about 30 m, so that the rule alone does not
prevent collisions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from planners.types import F64


@dataclass(frozen=True, slots=True)
class PairLaw:
    """Constants of Eqs. (7) and (8); defaults from Liu 2022, Table 1."""

    k: float = -80.0
    t: float = 5.0
    c_m: float = 120.0
    delta_m: float = 40.0
    delta_g_m: float = 10.0


def beta(distance: npt.ArrayLike, law: PairLaw) -> F64:
    """Strength (...) along the direction away from a neighbour at ``distance`` (...) m."""
    off = np.asarray(distance, dtype=np.float64) - law.c_m
    square = off * off
    g = law.t * (1.0 - np.exp(-square / law.delta_g_m**2))  # Eq. (7)
    a = law.k * off * np.exp(-square / law.delta_m**2)  # Eq. (8)
    return np.asarray(a * g)  # Eq. (9)


def nearest(distance: F64, count: int) -> npt.NDArray[np.bool_]:
    """Which (..., k) are the ``count`` nearest; infinite distances never are.

    Of equals the earlier in the row is nearer.
    """
    if distance.shape[-1] <= count:
        return np.isfinite(distance)
    chosen = np.zeros(distance.shape, np.bool_)
    order = np.argsort(distance, axis=-1, kind="stable")[..., :count]
    np.put_along_axis(chosen, order, True, axis=-1)
    return chosen & np.isfinite(distance)


def pull(
    position: F64, others: F64, present: npt.NDArray[np.bool_], law: PairLaw, count: int
) -> F64:
    """Sum of unit(F_i) beta_i over the closest neighbours: their part of Eq. (6).

    Args:
        position: (..., 2) m.
        others: (..., k, 2) m.
        present: (..., k) which rows of ``others`` count.
        law: the pair function.
        count: how many of the closest count; three in the paper.

    Returns:
        (..., 2) in the unit of beta. Neighbours at the very same point give no direction.
    """
    away = position[..., None, :] - others
    distance = np.hypot(away[..., 0], away[..., 1])
    counted = nearest(np.where(present & (distance > 0.0), distance, np.inf), count)
    safe = np.where(counted, distance, 1.0)
    strength = np.where(counted, beta(safe, law) / safe, 0.0)
    return np.asarray((np.where(counted[..., None], away, 0.0) * strength[..., None]).sum(axis=-2))
