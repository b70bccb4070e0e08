"""Cases of an experiment, and the samples that runs of one give."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from planners.types import F64

Value: TypeAlias = str | int | float | bool
Case: TypeAlias = Mapping[str, Value]  # its key "reading", if any, names another reading
Samples: TypeAlias = Mapping[str, F64]  # metric: (runs,) or (runs, len(axis.values))

READING = "reading"


@dataclass(frozen=True, slots=True)
class Axis:
    """What the second axis of a metric's array is, such as the cycle: a curve, not a number."""

    name: str
    values: tuple[int | float, ...]
