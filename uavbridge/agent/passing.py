"""Aircraft over a point: flown across once, which a turn that is too wide for it must not prevent.

Steered straight at a point inside its turning circle an aircraft circles that point for good. It
flies on first, until the point is outside.
"""

from __future__ import annotations

from math import cos, hypot, sin, tan
from typing import Final

from uavbridge.safety.filter import Vector

NEAR_M: Final = 40.0  # so near it was there
_SAME: Final = 0.25  # radii: a point so near to the one before is the same
_BANK_RAD: Final = 0.7
_TURN, _GIVE_UP = 1.3, 0.9  # radii of the circles outside which it turns, inside which no more
_AHEAD_RAD: Final = 0.1  # a point in so narrow an angle ahead is reached whatever the radius
_MOVED_M: Final = 0.5
_GRAVITY: Final = 9.80665


class Passing:
    """Remembers of one aircraft which point it flies to, and whether it was there.

    Args:
        speed_m_s: the fastest it flies, which makes its turns the widest.
    """

    def __init__(self, speed_m_s: float) -> None:
        self._radius_m = speed_m_s**2 / (_GRAVITY * tan(_BANK_RAD))
        self._turns = False
        self._point: tuple[float, float] | None = None
        self._was_there = False
        self._last: tuple[float, float] | None = None
        self._course = (0.0, 0.0)

    def see(self, position: Vector) -> None:
        """Take its position, as often as there is one."""
        x, y, _ = position
        if self._last is None:
            self._last = x, y
            return
        dx, dy = x - self._last[0], y - self._last[1]
        moved = hypot(dx, dy)
        if moved >= _MOVED_M:
            self._course, self._last = (dx / moved, dy / moved), (x, y)

    def was_there(self, point: Vector, position: Vector) -> bool:
        """It has flown over the point, which may be new."""
        x, y, _ = point
        before = self._point
        if before is None or hypot(x - before[0], y - before[1]) > _SAME * self._radius_m:
            self._was_there = self._turns = False
            self._point = x, y
        if hypot(x - position[0], y - position[1]) < NEAR_M:
            self._was_there = True
        return self._was_there

    def way(self, point: Vector, position: Vector) -> tuple[float, float]:
        """The direction to fly in, of length 1 (or 0: none)."""
        east, north = point[0] - position[0], point[1] - position[1]
        off = hypot(east, north)
        ahead_x, ahead_y = self._course
        ahead = east * ahead_x + north * ahead_y
        aside = abs(north * ahead_x - east * ahead_y)
        straight = ahead > cos(_AHEAD_RAD) * off and aside <= sin(_AHEAD_RAD) * off
        radius_m = (_GIVE_UP if self._turns else _TURN) * self._radius_m
        self._turns = straight or hypot(ahead, aside - radius_m) >= radius_m
        return (east / off, north / off) if self._turns and off else self._course
