"""Fingerprints by which two agents find out where their maps differ.

A cell's mark is a hash of all that its records say and merging looks at
(``MergeRule.compared``); marks of cells add up to those of areas, modulo 2^64.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from planners.belief.maps import BeliefMap
from planners.belief.rule import MergeRule, Records

Marks = npt.NDArray[np.uint64]

_STEP, _FIRST, _SECOND = (
    np.uint64(number) for number in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB)
)


def mixed(value: npt.ArrayLike) -> Marks:
    """A hash of whole numbers (...): SplitMix64's finaliser (Steele, Lea and Flood 2014)."""
    x = np.asarray(value).astype(np.uint64) + _STEP
    x = (x ^ (x >> np.uint64(30))) * _FIRST
    x = (x ^ (x >> np.uint64(27))) * _SECOND
    return np.asarray(x ^ (x >> np.uint64(31)))


def record_marks(rule: MergeRule, records: Records) -> Marks:
    """A hash (k,) of each record's fields that the rule compares."""
    total = np.zeros(len(records), np.uint64)
    for name in rule.compared:
        field = np.ascontiguousarray(records[name])
        bits = field.view(f"u{field.itemsize}")  # a probability by its bits
        total = mixed(total ^ bits.astype(np.uint64))
    return total


def cell_marks(rule: MergeRule, belief: BeliefMap, cells: npt.ArrayLike) -> Marks:
    """Marks (m,) of ascending flat cells (m,); 0 where nothing is known or the rule compares none.

    Equal marks: neither of the two maps can learn of this cell from the other.
    """
    flat = np.asarray(cells, np.int64)
    marks = np.zeros(len(flat), np.uint64)
    records = rule.records(belief, flat)
    np.add.at(marks, np.searchsorted(flat, records["cell"]), record_marks(rule, records))
    return marks
