"""The numbers that the safety filter holds a vehicle to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, pi, sqrt

from planners.terrain import Terrain


@dataclass(frozen=True, slots=True)
class Braking:
    """How a vehicle can stop: it goes on for ``latency_s``, then slows by ``brake_m_s2``.

    The latency is the whole of a position's age, the way of a setpoint, and the lag of the
    autopilot's velocity loop; the braking is half of what a small multirotor can do.
    """

    brake_m_s2: float = 1.5
    latency_s: float = 1.5

    def approach_speed(self, room_m: float, closing_m_s: float) -> float:
        """Largest speed (m/s) to ask for towards a wall.

        Args:
            room_m: distance to it.
            closing_m_s: the speed towards it now; what it flies during the latency is
                no room any more.

        Returns:
            A speed from which it stops in time; below 0 (away from the wall) where that
            has become impossible, or beyond the wall.
        """
        return self._speed(room_m, closing_m_s, 2 * self.brake_m_s2)

    def share_speed(self, room_m: float, closing_m_s: float) -> float:
        """Each one's share of the closing speed when two vehicles brake; as ``approach_speed``.

        Together they slow by twice the braking, so that w^2 / (4 brake) = room bounds the
        closing speed w; each may have half of it.
        """
        return self._speed(room_m, closing_m_s, self.brake_m_s2)

    def _speed(self, room_m: float, closing_m_s: float, factor_m_s2: float) -> float:
        left_m = room_m - max(closing_m_s, 0.0) * self.latency_s
        if left_m <= 0:
            return max(0.5 * left_m, -2.0)
        return sqrt(factor_m_s2 * left_m)

    def stopping(self, speed_m_s: float) -> float:
        """Way (m) to a stop from a speed."""
        return speed_m_s * self.latency_s + speed_m_s * speed_m_s / (2 * self.brake_m_s2)

    def reach(self, speed_m_s: float) -> float:
        """Room (m) beyond which two vehicles at ``speed_m_s`` leave each other alone."""
        return 2 * speed_m_s * self.latency_s + speed_m_s * speed_m_s / self.brake_m_s2


# What gusts, and neighbours in a corner, push a vehicle past where the filter stops it. Less than
# how near a vehicle must come to a home that lies on the fence.
DRIFT_M = 1.0
ROUND_HOME_M = 20.0  # between a home outside the area and the fence that is made to hold it


@dataclass(frozen=True, slots=True)
class Envelope:
    """Where a vehicle may be and how fast it may go. Mission frame, ENU.

    Altitudes are those above the terrain, where there is one.
    """

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
    terrain: Terrain | None = None
    slowest_m_s: float = 0.0  # it flies no slower, and so can not stop; 0: it can
    drives: bool = False  # it stays on the ground: no altitudes, no vertical speed
    steepest_rad: float = pi / 2  # steepest ground that a vehicle drives on
    columns: tuple[tuple[float, float, float], ...] = ()  # x, y, radius: nobody may fly there

    def holding(self, place: tuple[float, float, float]) -> Envelope:
        """The same, with a fence as much wider as a home outside it needs."""
        x, y, _ = place
        if self.west_m <= x <= self.east_m and self.south_m <= y <= self.north_m:
            return self
        return replace(
            self,
            west_m=min(self.west_m, x - ROUND_HOME_M),
            south_m=min(self.south_m, y - ROUND_HOME_M),
            east_m=max(self.east_m, x + ROUND_HOME_M),
            north_m=max(self.north_m, y + ROUND_HOME_M),
        )

    @property
    def care_m(self) -> float:
        """Distance (m) from which on another vehicle matters; inf is never returned."""
        if self.separation_m <= 0:
            return -inf
        climb_m_s = 0.0 if self.drives else self.climb_m_s
        return self.separation_m + self.braking.reach(self.speed_m_s + climb_m_s)
