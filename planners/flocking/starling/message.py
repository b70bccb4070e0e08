"""What one starling tells its neighbours, as bytes: the planner's payload of a frame.

Little-endian: version (u1), leg (u4), age of the last disturbance and of the last intruder (f4
each, inf for none), when the way was planned (i8 microseconds, -1: no way) and by whom (i4),
number of its points (u1) and x, y, z of each (f4). At most ``POINTS`` points are told.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field

import numpy as np

from planners.types import F64

VERSION = 1
POINTS = 18
_HEAD = struct.Struct("<BIffqiB")


def _nowhere() -> F64:
    return np.zeros((0, 3))


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """One aircraft's message."""

    leg: int = 0  # how often the flock has turned to another aim
    danger_s: float = math.inf
    alarm_s: float = math.inf
    planned_us: int = -1
    planner: int = -1
    way: F64 = field(default_factory=_nowhere)  # (k, 3) m; for the leg told

    @property
    def rank(self) -> tuple[int, int, int]:
        """The greatest wins: the latest leg, then the newest way."""
        return self.leg, self.planned_us, self.planner


def encode(told: Told) -> bytes:
    """Bytes of a message, at most 242."""
    way = told.way[:POINTS].astype("<f4")
    ages = told.danger_s, told.alarm_s
    head = _HEAD.pack(VERSION, told.leg, *ages, told.planned_us, told.planner, len(way))
    return head + way.tobytes()


def decode(data: bytes) -> Told:
    """The message of a payload; an empty one when the bytes are none, or say nonsense."""
    if len(data) < _HEAD.size or data[0] != VERSION:
        return Told()
    _, leg, danger, alarm, planned, planner, count = _HEAD.unpack_from(data)
    if len(data) != _HEAD.size + 12 * count or count > POINTS or (planned >= 0) != (count >= 2):
        return Told()
    way = np.frombuffer(data, "<f4", offset=_HEAD.size).astype(np.float64).reshape(-1, 3)
    if not (danger >= 0.0 and alarm >= 0.0 and np.isfinite(way).all()):
        return Told()
    return Told(leg, danger, alarm, planned, planner, way)
