"""Velocities for vehicles that fly to points: a point far ahead, given anew now and then.

ArduPlane takes no velocities. In GUIDED it flies to the place of a DO_REPOSITION and circles
there; a place that runs ahead of it makes it fly on.
"""

from __future__ import annotations

from math import hypot, isfinite
from typing import Final

from numpy import array

from sim_vehicles.codec import mav
from sim_vehicles.geodesy import Geodetic, to_geodetic
from uavbridge.clock import to_us
from uavbridge.mavlink.commands import Order
from uavbridge.vehicle.api import SetPosition, SetVelocity

AHEAD_M: Final = 600.0
STILL_M_S: Final = 1.0  # slower than that means: stay there
CLIMB_S: Final = 10.0  # a climb is asked for as the height in so many seconds
_OFTEN_US: Final = to_us(1.0)
_SELDOM_US: Final = to_us(5.0)
_MOVED_M: Final = 50.0  # a place that is nearer to the one before is the same
_HEIGHT_M: Final = 2.0
_NO_CHANGE: Final = -1.0  # of the speed
_NAN: Final = float("nan")


class Repositions:
    """The places that one vehicle was sent to.

    Args:
        mission: where the mission's ENU frame has its origin.
    """

    def __init__(self, mission: Geodetic) -> None:
        self._mission = mission
        self._place: tuple[float, float, float] | None = None
        self._sent_us = 0
        self._stays = False

    def forget(self) -> None:
        """The vehicle does something else now."""
        self._place = None
        self._stays = False

    def order(
        self,
        setpoint: SetVelocity | SetPosition,
        position: tuple[float, float, float],
        t_us: int,
    ) -> Order | None:
        """The command for a setpoint, if one is due.

        Args:
            setpoint: ENU m or m/s, in the mission's frame.
            position: of the vehicle, ENU m.
            t_us: now.

        Raises:
            ValueError: a setpoint that is not finite.
        """
        place = self._wanted(setpoint, position)
        last = self._place
        if last is not None:
            away_m = hypot(place[0] - last[0], place[1] - last[1])
            moved = away_m > _MOVED_M or abs(place[2] - last[2]) > _HEIGHT_M
            if t_us - self._sent_us < (_OFTEN_US if moved else _SELDOM_US):
                return None
        self._place, self._sent_us = place, t_us
        latitude, longitude, altitude = to_geodetic(array(place), self._mission)
        params = (
            _NO_CHANGE,
            0.0,  # only in GUIDED: a pilot's mode is not changed
            0.0,
            _NAN,
            float(round(float(latitude) * 1e7)),
            float(round(float(longitude) * 1e7)),
            float(altitude),
        )
        return Order(mav.MAV_CMD_DO_REPOSITION, params, frame=mav.MAV_FRAME_GLOBAL_INT)

    def _wanted(
        self, setpoint: SetVelocity | SetPosition, position: tuple[float, float, float]
    ) -> tuple[float, float, float]:
        wanted = setpoint.velocity if isinstance(setpoint, SetVelocity) else setpoint.position
        x, y, z = (float(part) for part in wanted)
        if not isfinite(x + y + z):
            raise ValueError(f"a setpoint must be finite, not {(x, y, z)}")
        if isinstance(setpoint, SetPosition):
            self._stays = False
            return x, y, z
        speed, height = hypot(x, y), position[2] + CLIMB_S * z
        if speed >= STILL_M_S:
            self._stays = False
            share = AHEAD_M / speed
            return position[0] + share * x, position[1] + share * y, height
        here = self._place if self._stays and self._place is not None else position
        self._stays = True
        return here[0], here[1], height
