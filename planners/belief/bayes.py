"""Probability of a target in a cell after one reading of an imperfect sensor.

Khan, Yanmaz and Rinner 2014, "Information merging in multi-UAV cooperative
search", Eqs. (1) and (12); Liu et al. 2022, "Emergent search of UAV swarm
guided by the target probability map", Eqs. (3)-(5).

| symbol | name |
| --- | --- |
| P(t-1), P(t) | ``prior``, the returned value |
| O | ``detected`` |
| p, P_d | ``p``: P(reading positive, target there) |
| q, P_f | ``q``: P(reading positive, no target there) |
| B, theta | ``threshold`` |
| m | the value of ``readings_needed`` |

A cell that was not looked at keeps its value, Liu's Eq. (3): do not call these
for it. All functions broadcast over leading axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from planners.types import F64

Update: TypeAlias = Callable[[npt.ArrayLike, npt.ArrayLike, float, float], F64]


def bayes(prior: npt.ArrayLike, detected: npt.ArrayLike, p: float, q: float) -> F64:
    """Posterior by Bayes' rule, Khan 2014, Eq. (1).

    Args:
        prior: (...) probabilities, strictly between 0 and 1.
        detected: (...) booleans, broadcast against ``prior``.
        p: detection probability, strictly between 0 and 1.
        q: false alarm probability, strictly between 0 and 1.

    Returns:
        (...) probabilities.
    """
    before = np.asarray(prior, dtype=np.float64)
    seen = np.asarray(detected, dtype=np.bool_)
    there = np.where(seen, p, 1.0 - p) * before
    not_there = np.where(seen, q, 1.0 - q) * (1.0 - before)
    return np.asarray(there / (there + not_there))  # Eq. (1)


def liu(prior: npt.ArrayLike, detected: npt.ArrayLike, p: float, q: float) -> F64:
    """Update as Liu 2022 prints it, Eqs. (4) and (5).

    Eq. (4) is Bayes' rule. Eq. (5) is not: it lacks the term (P_d - P_f) P in
    the denominator and so falls faster. It is kept as printed, for the paper's
    numbers follow from it. It stays within [0, 1] while p >= q.

    Args:
        prior: (...) probabilities.
        detected: (...) booleans, broadcast against ``prior``.
        p: detection probability P_d.
        q: false alarm probability P_f.

    Returns:
        (...) probabilities.
    """
    before = np.asarray(prior, dtype=np.float64)
    hit = p * before / ((p - q) * before + q)  # Eq. (4)
    miss = (1.0 - p) * before / (1.0 - q)  # Eq. (5)
    return np.asarray(np.where(detected, hit, miss))


UPDATES: Mapping[str, Update] = {"bayes": bayes, "liu": liu}


def readings_needed(prior: float, p: float, q: float, threshold: float) -> int:
    """Fewest readings, all positive, that lift ``prior`` to ``threshold``: Khan 2014, Eq. (12)."""
    ratio = prior * (1.0 - threshold) / (threshold * (1.0 - prior))
    return max(0, math.ceil(math.log(ratio) / math.log(q / p)))  # Eq. (12)
