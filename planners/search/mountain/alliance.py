"""Suballiances: signals, whom a robot answers to, and who may join.

Zhou 2023, section 2 (Eq. 1) and section 3.2 (Eqs. 5, 6, Table 1).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from planners.types import F64, I64, Bools


def signal(distance: F64, noise: F64, attenuation: float, power: float, range_m: float) -> F64:
    """Target signals I (...) at distances (...), Eq. (1); 0 beyond ``range_m``.

    Args:
        distance: m.
        noise: standard normal draws, eta.
        attenuation: m.
        power: Q.
        range_m: d_tar.
    """
    strength = attenuation * power / np.maximum(distance, 1e-3) ** 2 + noise
    return np.asarray(np.where(distance <= range_m, strength, 0.0))


def respond(strength: F64, heard: Bools, draw: F64) -> I64:
    """The target (...) that each robot answers to, -1 for none: roulette, Eqs. (5) and (6).

    Args:
        strength: (..., targets) I.
        heard: (..., targets) which of them are in range and still sought.
        draw: (...) r_a in [0, 1).
    """
    if not strength.shape[-1]:
        return np.full(draw.shape, -1, dtype=np.int64)
    weight = np.where(heard, np.maximum(strength**2, 1e-12), 0.0)
    upto = np.cumsum(weight, axis=-1)
    chosen = (upto <= (draw * upto[..., -1])[..., None]).sum(axis=-1)
    chosen = np.minimum(chosen, strength.shape[-1] - 1)
    return np.asarray(np.where(heard.any(axis=-1), chosen, -1))


def rank_members(
    first_class: npt.ArrayLike,
    strength: npt.ArrayLike,
    distance: npt.ArrayLike,
    link_strength: npt.ArrayLike,
    present: npt.ArrayLike | None = None,
) -> I64:
    """Candidates of one suballiance in order of priority (Zhou 2023, section 3.2, Table 1).

    Class I before class II; class I by strength, the strongest first; class II by distance
    to the nearest class I robot, then by that robot's strength. What is still equal stays in
    the order given. The first N_m of the order are the suballiance.

    All arguments broadcast against each other: leading axes are suballiances, the last one
    is their k candidates, of which there may be none.

    Args:
        first_class: (..., k) which candidates hear the target themselves.
        strength: (..., k) I of class I candidates; of others it does not count.
        distance: (..., k) m to the nearest class I robot; of class I it does not count.
        link_strength: (..., k) I of that robot; of class I it does not count.
        present: (..., k) which rows are candidates at all; all when not given.

    Returns:
        (..., k) row numbers, first in priority first; rows that are no candidates come last.

    Raises:
        ValueError: the shapes do not broadcast.

    Two robots hear the target, the last one louder; of the others row 3 is the nearer one:

    >>> rank_members(
    ...     first_class=[True, False, True, False],
    ...     strength=[2.0, 0.0, 6.1, 0.0],
    ...     distance=[0.0, 171.4, 0.0, 33.5],
    ...     link_strength=[0.0, 6.1, 0.0, 2.0],
    ... )
    array([2, 0, 3, 1])
    """
    first, strong, far, link, here = np.broadcast_arrays(
        np.asarray(first_class, dtype=np.bool_),
        np.asarray(strength, dtype=np.float64),
        np.asarray(distance, dtype=np.float64),
        np.asarray(link_strength, dtype=np.float64),
        np.asarray(True if present is None else present, dtype=np.bool_),
    )
    key = np.where(first, -strong, far)
    tie = np.where(first, 0.0, -link)
    number = np.broadcast_to(np.arange(first.shape[-1]), first.shape)
    return np.asarray(np.lexsort((number, tie, key, ~first, ~here), axis=-1))
