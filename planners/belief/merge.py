"""The merge rules that mission files name, and what callers need beside them.

The seam is ``planners.belief.rule.MergeRule``. Rules that weigh values against
each other are in ``fusing``, those that keep the newest in ``newest``, those
that share readings in ``sensed_data`` and ``counts``.
"""

from __future__ import annotations

from collections.abc import Mapping

from planners.belief.counts import Counts
from planners.belief.fusing import Average, ModifiedOgmm, Ogmm
from planners.belief.maps import FLOOR, BeliefMap, SensorModel
from planners.belief.newest import BeliefUpdate, Uncoordinated
from planners.belief.rule import MergeRule, Records, unpack
from planners.belief.sensed_data import SensedData

__all__ = [
    "FLOOR",
    "MERGE_RULES",
    "Average",
    "BeliefMap",
    "BeliefUpdate",
    "Counts",
    "MergeRule",
    "ModifiedOgmm",
    "Ogmm",
    "Records",
    "SensedData",
    "SensorModel",
    "Uncoordinated",
    "unpack",
]

_RULES: tuple[MergeRule, ...] = (
    BeliefUpdate(),
    Uncoordinated(),
    Average(),
    Ogmm(),
    ModifiedOgmm(),
    SensedData(),
    Counts(),
)
MERGE_RULES: Mapping[str, MergeRule] = {rule.name: rule for rule in _RULES}
