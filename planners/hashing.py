"""A hash of whole numbers, the same on every machine: SplitMix64's finaliser.

Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators".
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

U64: TypeAlias = npt.NDArray[np.uint64]

_STEP, _FIRST, _SECOND = (
    np.uint64(number) for number in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB)
)
_27, _30, _31 = np.uint64(27), np.uint64(30), np.uint64(31)

_ALL = (1 << 64) - 1


def mixed_one(value: int) -> int:
    """``mixed`` of one whole number."""
    x = (value + 0x9E3779B97F4A7C15) & _ALL
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & _ALL
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & _ALL
    return x ^ (x >> 31)


def mixed(value: npt.ArrayLike) -> U64:
    """A hash (n, ...) of whole numbers (n, ...); at least one axis."""
    x: U64 = np.array(value, np.uint64, ndmin=1)  # a copy, changed in place
    x += _STEP
    x ^= x >> _30
    x *= _FIRST
    x ^= x >> _27
    x *= _SECOND
    x ^= x >> _31
    return x
