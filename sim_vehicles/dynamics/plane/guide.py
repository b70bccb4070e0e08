"""Path following: from setpoints to bank, flight path angle and airspeed.

Beard and McLain 2012, chapters 6 and 10, with gains that grow with speed so that errors fade
alike at any speed. What an aircraft makes of a setpoint:

| position | velocity | flown |
| --- | --- | --- |
| - | given | course, climb and speed of it |
| given | given | the line through the position along the velocity (10.8), at its speed |
| given | - | to the place, and round it: an orbit (10.13) |
| - | - | on in a circle: it cannot stop |

A position's height is held; a height alone is held along with any of them. ``yaw_rate`` is how fast
the course turns where the path is curved. Velocities are over ground; what the air must give for
them is asked for as airspeed, within the envelope. ``max_speed`` is an airspeed: where it is
given, it counts and not the size of the velocity.

An attitude (roll, pitch, throttle, each alone too) takes the place of what it names. With a
throttle and no pitch the pitch holds the airspeed, as gliders do. The envelope counts before it:
too slow, the nose goes down whatever is asked for; too fast, it comes up, the throttle is closed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim_vehicles.dynamics.airframe import GRAVITY
from sim_vehicles.dynamics.model import F64, Setpoints
from sim_vehicles.dynamics.plane.airframe import PlaneLimits

COURSE_GAIN = 1.0  # 1/s
TRACK_GAIN = 0.35  # 1/s: how fast an aircraft comes back to its line
HEIGHT_GAIN = 0.5  # 1/s
LEVELLING_M_S2 = 2.5  # vertical braking that a change of height is planned with
_FAR = 0.5 * np.pi  # course across the line, from far away
_STILL_M_S = 0.5  # a velocity that no course can be read of
_STALL_MARGIN = 1.05
_GLIDE_GAIN = 0.06  # rad per m/s: climb for the airspeed, when the throttle is set
_SAFE_GAIN = 0.2  # rad per m/s: the largest climb, above
_SAFE_MARGIN = 1.1  # times the least airspeed
_FAST_M_S = 2.0  # within so much of the fastest the throttle is closed


@dataclass(slots=True, eq=False)
class Wanted:
    """What the inner loops are asked for, within the envelope; all (n,)."""

    roll: F64  # rad
    climb: F64  # flight path angle against the air, rad
    airspeed: F64  # m/s
    turn: F64  # rad/s of the course, counter-clockwise
    pitch: F64  # rad, NaN: by the climb; where it is asked for, ``climb`` is the most
    throttle: F64  # 0..1, NaN: by the airspeed


class Guide:
    """Path following of n aircraft. It keeps no state."""

    def __init__(self, limits: PlaneLimits) -> None:
        self._limits = limits

    def wanted(
        self, setpoints: Setpoints, position: F64, velocity: F64, air: F64, wind: F64
    ) -> Wanted:
        """What to fly now.

        Args:
            setpoints: of n vehicles.
            position: (3, n) ENU m.
            velocity: (3, n) over ground.
            air: (n,) airspeed.
            wind: (3, n) ENU m/s.
        """
        limits = self._limits
        place, asked = setpoints.position.T, setpoints.velocity.T
        level = np.hypot(asked[0], asked[1])
        aimed = np.isfinite(level) & (level > _STILL_M_S) & (level < 1e6)
        placed = np.isfinite(place[0]) & np.isfinite(place[1])
        pace = np.maximum(np.hypot(velocity[0], velocity[1]), 0.5 * limits.slowest_m_s)
        here = np.arctan2(velocity[1], velocity[0])

        east = np.where(placed, place[0], position[0]) - position[0]
        north = np.where(placed, place[1], position[1]) - position[1]
        along = np.where(aimed, np.arctan2(asked[1], asked[0]), here)
        rate = np.where(aimed & np.isfinite(setpoints.yaw_rate), setpoints.yaw_rate, 0.0)
        line = along + _towards(north * np.cos(along) - east * np.sin(along), pace)
        orbit, round_ = self._orbit(east, north, setpoints.radius, air, pace)
        idle = ~aimed & ~placed
        radius = self._radius(setpoints.radius, air)
        course = np.where(aimed, np.where(placed, line, along), np.where(placed, orbit, here))
        feed = np.where(aimed, rate, np.where(placed, round_, 0.0))
        feed = np.where(idle, pace / radius, feed)

        climb = self._climb(setpoints, place[2] - position[2], asked[2], air)
        speed = self._airspeed(setpoints, asked, aimed, wind)
        turn = COURSE_GAIN * wrapped(course - here) + feed
        roll = self._bank(-np.arctan(turn * pace / GRAVITY), air)
        free = np.full(len(air), np.nan)
        wanted = Wanted(roll, climb, speed, turn, free, free)
        if np.isfinite(setpoints.attitude).any():
            self._by_attitude(wanted, setpoints.attitude.T, air)
        return wanted

    def _by_attitude(self, wanted: Wanted, asked: F64, air: F64) -> None:
        """Bank, pitch and throttle (3, n) as asked for, within the envelope."""
        limits = self._limits
        rolled, pitched, driven = np.isfinite(asked)
        near = np.clip((limits.fastest_m_s - air) / _FAST_M_S, 0.0, 1.0)
        lowest = -limits.sink_rad * near + 0.1 * (1.0 - near)
        glide = np.clip(_GLIDE_GAIN * (air - limits.trim_m_s), -limits.sink_rad, limits.climb_rad)
        least = _SAFE_MARGIN * limits.slowest_m_s
        steepest = np.clip(_SAFE_GAIN * (air - least), -0.5 * limits.sink_rad, limits.climb_rad)
        climb = np.where(pitched, limits.climb_rad, np.where(driven, glide, wanted.climb))
        wanted.climb = np.minimum(climb, steepest)
        wanted.roll = np.where(rolled, self._bank(asked[0], air), wanted.roll)
        wanted.pitch = np.where(pitched, np.maximum(asked[1], lowest), np.nan)
        wanted.throttle = np.where(driven, np.clip(asked[2], 0.0, 1.0) * near, np.nan)

    def _radius(self, asked: F64, air: F64) -> F64:
        """Radius (n,) m of an orbit, positive counter-clockwise, no tighter than it can fly."""
        limits = self._limits
        least = air**2 / (GRAVITY * np.tan(0.8 * limits.bank_rad))
        wanted = np.where(np.isfinite(asked) & (asked != 0.0), asked, -limits.radius_m)
        return np.asarray(np.copysign(np.maximum(np.abs(wanted), least), wanted))

    def _orbit(self, east: F64, north: F64, asked: F64, air: F64, pace: F64) -> tuple[F64, F64]:
        """Course and turn (n,) onto and along a circle whose middle lies ``east``, ``north``."""
        radius = self._radius(asked, air)
        side, size = np.sign(radius), np.abs(radius)
        away = np.hypot(east, north)
        outwards = np.arctan2(-north, -east)
        bend = np.arctan(TRACK_GAIN * (away - size) / pace)
        near = np.exp(-(np.maximum(away - size, 0.0) / size))  # no bank on the way there
        return outwards + side * (0.5 * np.pi + bend), side * near * pace / size

    def _climb(self, setpoints: Setpoints, rise: F64, asked: F64, air: F64) -> F64:
        limits = self._limits
        off = np.where(np.isfinite(rise), np.clip(rise, -1e5, 1e5), 0.0)
        ease = 1.0 + np.sqrt(1.0 + 2.0 * HEIGHT_GAIN**2 * np.abs(off) / LEVELLING_M_S2)
        rate = 2.0 * HEIGHT_GAIN * off / ease
        rate = np.clip(rate, -np.abs(setpoints.max_down), np.abs(setpoints.max_up))
        rate = rate + np.where(np.isfinite(asked), np.clip(asked, -1e3, 1e3), 0.0)
        angle = np.arcsin(np.clip(rate / np.maximum(air, 1.0), -0.9, 0.9))
        slow = air - _STALL_MARGIN * limits.slowest_m_s  # slow: speed comes before height
        most = np.clip(limits.climb_rad + 0.3 * slow, -0.5 * limits.sink_rad, limits.climb_rad)
        return np.asarray(np.minimum(np.maximum(angle, -limits.sink_rad), most))

    def _airspeed(self, setpoints: Setpoints, asked: F64, aimed: F64, wind: F64) -> F64:
        limits = self._limits
        moving = np.where(aimed, asked, 0.0)
        up = np.where(np.isfinite(moving[2]), np.clip(moving[2], -1e3, 1e3), 0.0)
        flown = np.sqrt((moving[0] - wind[0]) ** 2 + (moving[1] - wind[1]) ** 2 + up**2)
        most = setpoints.max_speed
        cruise = np.where(np.isfinite(most) & (most > 0.0), most, limits.trim_m_s)
        speed = np.where(aimed & ~np.isfinite(most), flown, cruise)
        return np.asarray(np.clip(speed, limits.slowest_m_s, limits.fastest_m_s))

    def _bank(self, roll: F64, air: F64) -> F64:
        """Within the limit, and such that the wing still carries: n < (V / V_least)^2."""
        limits = self._limits
        load = np.maximum(air / limits.slowest_m_s, 1.0) ** 2
        most = np.minimum(np.arccos(1.0 / np.maximum(load, 1.05)), limits.bank_rad)
        return np.asarray(np.clip(roll, -most, most))


def _towards(left: F64, pace: F64) -> F64:
    """Change of course (n,) rad towards a line that lies ``left`` (n,) m to the left."""
    return np.asarray(_FAR * (2.0 / np.pi) * np.arctan(TRACK_GAIN * left / pace))


def wrapped(angle: F64) -> F64:
    """Angles (n,) rad within -pi and pi."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
