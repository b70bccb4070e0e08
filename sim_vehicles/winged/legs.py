"""Legs of aircraft: circles, lines, and the approach to a runway."""

from __future__ import annotations

from math import cos, hypot, inf, nan, radians, sin, tan
from typing import Final

import numpy as np

from sim_vehicles.dynamics.model import F64, Bools, States
from sim_vehicles.legs import DESCEND, FLIGHT, FOLLOW, GO, Asked, Legs, Tilt
from sim_vehicles.params import Parameters
from sim_vehicles.plans import Vector
from sim_vehicles.status import I64, Status

_LEAD_S: Final = 1.0  # a turn begins this long before the end of a line
_LOOK_S: Final = 0.5  # less than that apart are two ticks
_SLOWEST_TURN: Final = 1e-6
_FLOAT_S: Final = 5.0
_FLARE_1_S: Final = 0.25  # sink asked for per metre of height, near the ground


class WingedLegs(Legs):
    """Legs of vehicles that cannot stop: to stay at a place is to fly round it.

    A line goes on beyond its end until the next leg begins. On the ground the motors stand still
    until a leg leads up.
    """

    def __init__(self, status: Status, states: States, parameters: Parameters) -> None:
        super().__init__(status, states, parameters)
        n = len(status.mode)
        self._lined: Bools = np.zeros(n, dtype=np.bool_)
        self._way: F64 = np.zeros((n, 2))  # unit vectors of lines
        self._floor: F64 = np.zeros(n)  # ENU m, of the runway
        self._circle: F64 = np.full(n, nan)  # asked for in place of the parameter's
        self._tilts: dict[int, Tilt] = {}
        self._tilted_us = 0
        column = parameters.column
        self._loiter, self._slowest = column("NAV_LOITER_RAD"), column("FW_AIRSPD_MIN")
        self._landing, self._glide = column("FW_LND_AIRSPD"), column("FW_LND_ANG")
        self._flare, self._sink = column("FW_LND_FLALT"), column("FW_LND_FL_SINK")

    def go(
        self,
        i: int,
        position: Vector,
        yaw_rad: float,
        *,
        radius_m: float | None = None,
        climb: bool = False,
    ) -> None:
        """Fly to a place and round it; arguments as of ``Legs.go``."""
        super().go(i, position, yaw_rad, radius_m=radius_m, climb=climb)
        self._lined[i] = False
        circle = self._circle[i]
        # NAV_LOITER_RAD is positive clockwise
        self._wanted.radius[i] = -self._loiter[i] if np.isnan(circle) else circle

    def line(
        self,
        i: int,
        start: Vector,
        end: Vector,
        *,
        radius_m: float,
        climb: bool = False,
    ) -> None:
        """Fly along a line to its end, and straight on; it has arrived a little before."""
        self.go(i, end, nan, radius_m=radius_m, climb=climb)
        east, north = end[0] - start[0], end[1] - start[1]
        length = hypot(east, north)
        if length > _SLOWEST_TURN:
            self._way[i] = east / length, north / length
            self._lined[i] = True
            self._aim(np.array([i]))

    def climb_out(self, i: int, top: float) -> None:
        """Take off straight ahead, up to ``top`` (ENU m)."""
        x, y, _ = self._states.position[i].tolist()
        yaw = float(self._states.yaw[i])
        self.line(i, (x, y, top), (x + cos(yaw), y + sin(yaw), top), radius_m=inf, climb=True)

    def approach(self, i: int, x: float, y: float, floor: float, yaw_rad: float) -> None:
        """Glide along ``yaw_rad`` to the runway at ``x``, ``y``, ``floor`` (ENU m)."""
        ahead = x + cos(yaw_rad), y + sin(yaw_rad), nan
        self.line(i, (x, y, nan), ahead, radius_m=inf)
        self._wanted.position[i] = x, y, nan
        self._floor[i] = floor
        self._watched[i] = False
        self.kind[i] = DESCEND

    def middle(self, i: int) -> Vector:
        """The place that it flies to, or round."""
        x, y, z = self._wanted.position[i].tolist()
        return x, y, z

    def runway(self, i: int) -> Vector:
        """Where the approach leads, ENU m."""
        x, y, _ = self._wanted.position[i].tolist()
        return x, y, float(self._floor[i])

    def descend(self, i: int, x: float, y: float, yaw_rad: float) -> None:
        self.approach(i, x, y, float(self._states.ground[i]), yaw_rad)

    def set_circle(self, i: int, radius_m: float) -> None:
        """Radius of the loiters from here on, positive counter-clockwise; NaN: the parameter's."""
        self._circle[i] = radius_m

    def circle(self, i: int) -> float:
        """The radius that it loiters at, positive counter-clockwise."""
        asked = float(self._circle[i])
        return -float(self._loiter[i]) if asked != asked else asked

    def tilt(self, i: int, asked: Tilt, position: Vector | None = None) -> None:
        if i not in self._tilts:
            self._begin(i, FOLLOW)
            self.followers.add(i)
            states, wanted = self._states, self._wanted
            wanted.motors[i] = True
            wanted.attitude[i] = states.roll[i], states.pitch[i], nan
        if position is not None:
            self._wanted.position[i] = position
            self._wanted.velocity[i] = nan
        self._newest.pop(i, None)
        self._tilts[i] = asked

    def _begin(self, i: int, kind: int) -> None:
        super()._begin(i, kind)
        self._level(i)

    def follow(self, i: int, asked: Asked) -> None:
        super().follow(i, asked)
        self._level(i)

    def _level(self, i: int) -> None:
        """No attitude is asked for any more."""
        self._tilts.pop(i, None)
        self._wanted.attitude[i] = nan

    def _lean(self, t_us: int) -> None:
        """Attitudes asked for; rates of turn change them."""
        since_s = (t_us - self._tilted_us) * 1e-6
        dt_s = since_s if since_s < _LOOK_S else 0.0
        self._tilted_us = t_us
        get, attitude = self._parameters.get, self._wanted.attitude
        for i, asked in self._tilts.items():
            roll, pitch, _ = attitude[i].tolist()
            rolls, pitches = asked.roll_rate, asked.pitch_rate
            roll = roll + dt_s * rolls if rolls == rolls else asked.roll
            pitch = pitch + dt_s * pitches if pitches == pitches else asked.pitch
            most = radians(get(i, "FW_R_LIM"))
            low, high = radians(get(i, "FW_P_LIM_MIN")), radians(get(i, "FW_P_LIM_MAX"))
            attitude[i] = _within(roll, -most, most), _within(pitch, low, high), asked.throttle

    def in_flight(self, i: int) -> None:
        super().in_flight(i)
        self._wanted.radius[i] = -self._loiter[i]

    def heed(self) -> None:
        """Setpoints, at no less than the least airspeed (over ground, the wind apart)."""
        rows = np.fromiter(self._newest, np.int64, len(self._newest))
        super().heed()
        if not len(rows):
            return
        self._lined[rows] = False
        circles = [self.circle(i) for i in rows.tolist()]
        for setpoints in (self._wanted, self.setpoints):
            velocity = setpoints.velocity[rows]
            speed = np.hypot(velocity[:, 0], velocity[:, 1])
            slow = (speed > 0.5) & (speed < self._slowest[rows])
            scale = np.where(slow, self._slowest[rows] / np.where(slow, speed, 1.0), 1.0)
            velocity[:, :2] *= scale[:, np.newaxis]
            setpoints.velocity[rows] = velocity
            setpoints.radius[rows] = circles

    def fly(self, t_us: int) -> list[int]:
        waiting = self._lined & self._watched & (self.kind == GO)
        if waiting.any():
            self._end_lines(waiting, t_us)
        if self._tilts:
            self._lean(t_us)
        return super().fly(t_us)

    def _end_lines(self, waiting: Bools, t_us: int) -> None:
        """Whose line is flown: it wakes, or climbs round the end to its height first."""
        states, wanted = self._states, self._wanted
        left = wanted.position - states.position
        ahead = left[:, 0] * self._way[:, 0] + left[:, 1] * self._way[:, 1]
        speed = np.hypot(states.velocity[:, 0], states.velocity[:, 1])
        passed = waiting & (ahead <= np.maximum(_LEAD_S * speed, self._radius))
        passed &= np.isfinite(self._radius)
        high = np.abs(left[:, 2]) <= self._height
        self.due_us[passed & (high | np.isnan(left[:, 2]))] = t_us
        for i in (passed & ~high).nonzero()[0].tolist():
            wanted.velocity[i] = nan
            self._lined[i] = False
            self._radius[i] = inf

    def _limit(self) -> None:
        super()._limit()
        wanted = self._wanted
        landing = np.where(self._landing > 0, self._landing, 1.2 * self._slowest)
        np.copyto(wanted.max_speed, landing, where=self.kind == DESCEND)
        self._aim(self._lined.nonzero()[0])

    def _aim(self, rows: I64) -> None:
        """Velocities along the lines of ``rows``."""
        speed = self._wanted.max_speed[rows]
        speed = np.where(np.isfinite(speed), speed, self._cruise[rows])
        self._wanted.velocity[rows, :2] = self._way[rows] * speed[:, np.newaxis]

    def _slow_down(self) -> None:
        """The glide to the runway, and the flare."""
        rows = (self.kind == DESCEND).nonzero()[0]
        states, wanted = self._states, self._wanted
        left = wanted.position[rows, :2] - states.position[rows, :2]
        ahead = (left * self._way[rows]).sum(axis=1)
        steep = np.tan(np.radians(self._glide[rows]))
        ground = np.maximum(self._floor[rows], states.ground[rows])
        height = states.position[rows, 2] - ground
        speed = np.hypot(states.velocity[rows, 0], states.velocity[rows, 1])
        flare = (height < self._flare[rows]) | (ahead < 0.0)
        sink = np.where(flare, np.maximum(self._sink[rows], _FLARE_1_S * height), speed * steep)
        # The flare goes on level for long: the glide ends that much before the runway's point.
        path = self._floor[rows] + np.maximum(ahead - _FLOAT_S * speed, 0.0) * steep
        wanted.position[rows, 2] = np.where(flare, nan, path)
        wanted.velocity[rows, 2] = -sink

    def _apply(self, t_us: int) -> None:
        wanted = self._wanted
        self.setpoints.radius[:] = wanted.radius
        self.setpoints.attitude[:] = wanted.attitude
        follows = self.kind == FOLLOW  # at the speed of their setpoints, where these have one
        if follows.any():
            moving = np.isfinite(wanted.velocity[:, 0])
            cruise = np.where(np.isnan(self._speed), self._cruise, self._speed)
            np.copyto(wanted.max_speed, np.where(moving, inf, cruise), where=follows)
        super()._apply(t_us)

    def _leads_up(self) -> Bools:
        lifts = (self._wanted.attitude[:, 1] > 0.0) & (self._wanted.attitude[:, 2] > 0.0)
        return super()._leads_up() | lifts

    def _hold_down(self, t_us: int) -> None:
        """On the ground the propeller stands still until a leg leads up."""
        spool_s = self._parameters.column("COM_SPOOLUP_TIME")
        spun = t_us - self._status.armed_us >= spool_s * 1e6
        waits = self.gate != FLIGHT
        self.gate[waits & self._status.armed & spun & self._leads_up()] = FLIGHT
        self.setpoints.motors &= self.gate == FLIGHT


def _within(value: float, least: float, most: float) -> float:
    return min(max(value, least), most) if value == value else nan


def glide_run(height_m: float, angle_deg: float) -> float:
    """How far (m) a glide of ``angle_deg`` reaches from a height."""
    return height_m / tan(radians(angle_deg))
