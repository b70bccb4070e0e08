"""Intervals of means: Student's t, 95 %."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from planners.types import F64

_Z = NormalDist().inv_cdf(0.975)


def t_quantile(freedom: int) -> float:
    """97.5 % quantile of Student's t, to half a hundredth from 3 degrees of freedom on.

    Cornish and Fisher's expansion in 1/freedom about the normal quantile; exact for 1 and 2.
    """
    if freedom < 3:
        return {1: 12.7062, 2: 4.30265}[freedom]
    z, n = _Z, float(freedom)
    first = (z**3 + z) / 4.0
    second = (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    third = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
    fourth = (79.0 * z**9 + 776.0 * z**7 + 1482.0 * z**5 - 1920.0 * z**3 - 945.0 * z) / 92160.0
    return z + first / n + second / n**2 + third / n**3 + fourth / n**4


def half_width(deviation: F64 | float, n: int) -> F64:
    """Half the 95 % interval (...) of means over ``n`` runs of standard deviations (...)."""
    if n < 2:
        return np.zeros_like(np.asarray(deviation, dtype=np.float64))
    return np.asarray(np.asarray(deviation) / np.sqrt(n) * t_quantile(n - 1))
