"""A rule of the safety filter: a half-space of velocities."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

Vector: TypeAlias = tuple[float, float, float]


class HalfSpace(NamedTuple):
    """The rule ``x vx + y vy + z vz <= limit`` with a unit normal."""

    x: float
    y: float
    z: float
    limit: float

    def along(self, v: Vector) -> float:
        """Speed of ``v`` into the rule's direction."""
        return self.x * v[0] + self.y * v[1] + self.z * v[2]
