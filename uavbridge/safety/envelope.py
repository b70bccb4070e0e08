"""The numbers that the safety filter holds a vehicle to."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt


@dataclass(frozen=True, slots=True)
class Braking:
    """How a vehicle can stop: it goes on for ``latency_s``, then slows by ``brake_m_s2``."""

    brake_m_s2: float = 1.5
    latency_s: float = 1.0  # beacon's age, half a control step, lag of the velocity loop

    def approach_speed(self, room_m: float) -> float:
        """Largest speed (m/s) towards a wall from which it stops in time.

        Solves v latency + v^2 / (2 brake) = room. Beyond the wall (room < 0) it
        is negative: back out, at half the depth per second.
        """
        if room_m <= 0:
            return max(0.5 * room_m, -2.0)
        b, tau = self.brake_m_s2, self.latency_s
        return b * (sqrt(tau * tau + 2 * room_m / b) - tau)

    def share_speed(self, room_m: float) -> float:
        """Each one's share of the closing speed when both brake; see ``approach_speed``.

        Solves w latency + w^2 / (4 brake) = room for the closing speed w = 2 v.
        """
        if room_m <= 0:
            return max(0.5 * room_m, -2.0)
        b, tau = self.brake_m_s2, self.latency_s
        return b * (sqrt(tau * tau + room_m / b) - tau)

    def reach(self, speed_m_s: float) -> float:
        """Room (m) beyond which two vehicles at ``speed_m_s`` leave each other alone."""
        return 2 * speed_m_s * self.latency_s + speed_m_s * speed_m_s / self.brake_m_s2


@dataclass(frozen=True, slots=True)
class Envelope:
    """Where a vehicle may be and how fast it may go. Mission frame, ENU."""

    west_m: float
    south_m: float
    east_m: float
    north_m: float
    altitude_min_m: float
    altitude_max_m: float
    speed_m_s: float = 10.0  # horizontal
    climb_m_s: float = 3.0
    sink_m_s: float = 1.5
    separation_m: float = 10.0  # distance that the filter keeps; 0: filter off
    braking: Braking = Braking()

    @property
    def care_m(self) -> float:
        """Distance (m) from which on another vehicle matters; inf is never returned."""
        if self.separation_m <= 0:
            return -inf
        return self.separation_m + self.braking.reach(self.speed_m_s + self.climb_m_s)
