"""Figures that say how much a belief map knows. Maps are (..., columns, rows).

``uncertainty`` is the "environmental uncertainty" of Liu et al. 2022, pinned
down from the paper's Table 2: the one-sided sum -sum P log2 P, 50 for 100
untouched cells at 0.5. It rises at first visits (its greatest value a cell is
0.5307 at P = 1/e), so ``entropy``, the two-sided one in bits, belongs beside it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from planners.types import F64, Bools


def coverage(seen: npt.ArrayLike) -> F64:
    """Share (...) of the cells seen, of maps (..., columns, rows) of booleans."""
    return np.asarray(np.mean(np.asarray(seen, dtype=np.bool_), axis=(-2, -1)))


def uncertainty(probability: npt.ArrayLike) -> F64:
    """One-sided uncertainty (...) of maps (..., columns, rows), as in Liu 2022."""
    return np.asarray(_plogp(np.asarray(probability, dtype=np.float64)).sum(axis=(-2, -1)))


def entropy(probability: npt.ArrayLike) -> F64:
    """Shannon entropy (...) in bits of maps (..., columns, rows) of independent cells."""
    value = np.asarray(probability, dtype=np.float64)
    return np.asarray((_plogp(value) + _plogp(1.0 - value)).sum(axis=(-2, -1)))


def declared(probability: npt.ArrayLike, threshold: float) -> Bools:
    """Cells (..., columns, rows) held to hold a target: P >= threshold (Khan 2014, P_c >= B)."""
    return np.asarray(np.asarray(probability, dtype=np.float64) >= threshold)


def _plogp(value: F64) -> F64:
    """-P log2 P, 0 at P = 0."""
    positive = np.where(value > 0.0, value, 1.0)
    return np.asarray(-value * np.log2(positive))
