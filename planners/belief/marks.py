"""Fingerprints by which two agents find out where their maps differ.

A cell's mark is a hash of all that its records say and merging looks at
(``MergeRule.compared``); marks of cells add up to those of areas, modulo 2^64.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from planners.belief.maps import BeliefMap
from planners.belief.rule import MergeRule, Records
from planners.hashing import U64, mixed
from planners.types import I64

Marks: TypeAlias = U64


def record_marks(rule: MergeRule, records: Records) -> Marks:
    """A hash (k,) of each record's fields that the rule compares."""
    total = np.zeros(len(records), np.uint64)
    for name in rule.compared:
        field = np.ascontiguousarray(records[name])
        bits = field.view(f"u{field.itemsize}")  # a probability by its bits
        total ^= bits  # of fewer bits, or as many
        total = mixed(total)
    return total


def cell_marks(rule: MergeRule, belief: BeliefMap, cells: I64) -> Marks:
    """Marks (m,) of ascending flat cells (m,); 0 where nothing is known or the rule compares none.

    Equal marks: neither of the two maps can learn of this cell from the other.
    """
    marks = np.zeros(len(cells), np.uint64)
    records = rule.records(belief, cells)
    np.add.at(marks, np.searchsorted(cells, records["cell"]), record_marks(rule, records))
    return marks
