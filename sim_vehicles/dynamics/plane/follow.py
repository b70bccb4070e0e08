"""Following a Dubins airplane path: from where an aircraft is to the line it is to fly.

Beard and McLain 2012, chapter 11, with a nearest point that only moves on instead of half planes:
it serves lines, arcs and helices alike. The guide turns place, velocity and turn into bank.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from planners.paths.dubins import AirplanePath
from sim_vehicles.dynamics.model import F64

_STEP_M: Final = 2.0  # between the points of the path that are looked at
_SEARCH_M: Final = 200.0  # how far on the nearest point may lie


class Target(NamedTuple):
    """A point of the path, to be flown through."""

    position: F64  # (3,) ENU m
    velocity: F64  # (3,) m/s along the path
    turn: float  # rad/s of the course there
    done: bool  # the end is behind


class Follower:
    """Where one aircraft is on its path.

    Args:
        path: of ``planners.paths.dubins.airplane``.
        speed_m_s: along it.
    """

    def __init__(self, path: AirplanePath, speed_m_s: float) -> None:
        self._points = path.points(_STEP_M)
        self._speed = speed_m_s
        self._level = speed_m_s * np.cos(path.gamma)
        self._rise = speed_m_s * np.sin(path.gamma)
        self._at = 0

    def target(self, position: F64) -> Target:
        """What to fly at ``position`` (3,) ENU m."""
        points = self._points
        reach = self._at + round(_SEARCH_M / _STEP_M)
        away = np.linalg.norm(points[self._at : reach, :3] - position, axis=1)
        self._at += int(np.argmin(away))
        x, y, z, psi = points[self._at].tolist()
        following = min(self._at + 1, len(points) - 1)
        before = max(following - 1, 0)
        step = np.linalg.norm(points[following, :3] - points[before, :3])
        bend = float(points[following, 3] - points[before, 3])
        turn = bend * self._speed / float(step) if step > 0.0 else 0.0
        velocity = np.array((self._level * np.cos(psi), self._level * np.sin(psi), self._rise))
        return Target(np.array((x, y, z)), velocity, turn, self._at >= len(points) - 1)
