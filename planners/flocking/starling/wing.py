"""How an aircraft can move: speed, course and climb angle with limits, as point masses.

The paper has none of these limits. Bank of 45 degrees at 50 m/s is a radius of 255 m; the climb
angles are those of the paper's Fig. 21 (pitch from -0.5 to 0.3, positive down).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from planners.types import F64

GRAVITY = 9.80665


@dataclass(frozen=True, slots=True)
class Wing:
    """What the aircraft can do."""

    bank_rad: float = math.radians(45.0)
    climb_rad: float = 0.5
    sink_rad: float = 0.3
    slowest_m_s: float = 25.0
    fastest_m_s: float = 100.0
    faster_m_s2: float = 5.0
    slower_m_s2: float = 8.0
    pull_m_s2: float = 8.0  # across the flight path, upwards and downwards

    @property
    def across_m_s2(self) -> float:
        """Largest level acceleration across the flight path."""
        return GRAVITY * math.tan(self.bank_rad)

    def radius(self, speed_m_s: float) -> float:
        """R_min of Eq. (12), m."""
        return speed_m_s**2 / self.across_m_s2


def parts(velocity: F64) -> tuple[F64, F64, F64]:
    """Speed (...), course (...) rad and climb angle (...) rad of velocities (..., 3)."""
    level = np.hypot(velocity[..., 0], velocity[..., 1])
    course = np.arctan2(velocity[..., 1], velocity[..., 0])
    return np.hypot(level, velocity[..., 2]), course, np.arctan2(velocity[..., 2], level)


def whole(speed: F64, course: F64, climb: F64) -> F64:
    """Velocities (..., 3) from their parts."""
    level = speed * np.cos(climb)
    return np.stack(
        (level * np.cos(course), level * np.sin(course), speed * np.sin(climb)), axis=-1
    )


def split(acceleration: F64, course: F64, climb: F64) -> tuple[F64, F64, F64]:
    """Accelerations (..., 3) as along the path, to the left, and upwards across it."""
    ahead = acceleration[..., 0] * np.cos(course) + acceleration[..., 1] * np.sin(course)
    left = acceleration[..., 1] * np.cos(course) - acceleration[..., 0] * np.sin(course)
    along = ahead * np.cos(climb) + acceleration[..., 2] * np.sin(climb)
    up = acceleration[..., 2] * np.cos(climb) - ahead * np.sin(climb)
    return along, left, up


def flown(velocity: F64, acceleration: F64, wing: Wing, step_s: float) -> F64:
    """Velocities (..., 3) after ``step_s`` of an acceleration (..., 3), within the limits."""
    speed, course, climb = parts(velocity)
    along, left, up = split(acceleration, course, climb)
    slow = np.maximum(speed, wing.slowest_m_s / 2.0)
    turn = np.clip(left, -wing.across_m_s2, wing.across_m_s2) / (slow * np.cos(climb))
    rise = np.clip(up, -wing.pull_m_s2, wing.pull_m_s2) / slow
    faster = np.clip(along, -wing.slower_m_s2, wing.faster_m_s2)
    return whole(
        np.clip(speed + faster * step_s, wing.slowest_m_s, wing.fastest_m_s),
        course + turn * step_s,
        np.clip(climb + rise * step_s, -wing.sink_rad, wing.climb_rad),
    )
