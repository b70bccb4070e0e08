"""COMMAND_LONG and COMMAND_INT in one form."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, nan
from typing import Final

from sim_vehicles.codec import Packet, mav
from sim_vehicles.geodesy import Geodetic, to_enu
from sim_vehicles.plans import Vector
from sim_vehicles.protocol.items import UNSET

_ABSOLUTE: Final = (mav.MAV_FRAME_GLOBAL, mav.MAV_FRAME_GLOBAL_INT)
_RELATIVE: Final = (mav.MAV_FRAME_GLOBAL_RELATIVE_ALT, mav.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
FARTHEST_M: Final = 1e6  # nothing goes farther than this from home


@dataclass(frozen=True, slots=True)
class Order:
    """A command for a vehicle; a param that is not finite means "default"."""

    command: int
    params: tuple[float, ...]  # 1..7, degrees and metres where they are a place
    frame: int
    peer: tuple[int, int]  # who asks: system and component

    @staticmethod
    def read(packet: Packet, long_frame: int) -> Order:
        """Of a COMMAND_INT, or of a COMMAND_LONG, whose place is in ``long_frame``."""
        message = packet.message
        first = (message.param1, message.param2, message.param3, message.param4)
        peer = packet.system, packet.component
        if message.msgname == "COMMAND_LONG":
            rest = (message.param5, message.param6, message.param7)
            return Order(message.command, first + rest, long_frame, peer)
        scale = (
            1e-4 if message.frame in (mav.MAV_FRAME_LOCAL_NED, mav.MAV_FRAME_LOCAL_ENU) else 1e-7
        )
        x = nan if message.x == UNSET else message.x * scale
        y = nan if message.y == UNSET else message.y * scale
        return Order(message.command, (*first, x, y, message.z), message.frame, peer)

    def number(self, param: int, otherwise: float = 0.0) -> float:
        """Param 1..7, or ``otherwise`` where it is not given."""
        value = self.params[param - 1]
        return value if isfinite(value) else otherwise

    def whole(self, param: int, otherwise: int = 0) -> int:
        """Param 1..7 rounded to a whole number within 32 bits."""
        value = self.number(param, otherwise)
        return round(min(max(value, -(2.0**31)), 2.0**31 - 1))

    @property
    def is_global(self) -> bool:
        """Whether the frame is one of latitude and longitude that is understood."""
        return self.frame in _ABSOLUTE + _RELATIVE

    def place(
        self, origin: Geodetic, home_z: float, *, zero_is_here: bool = False
    ) -> Vector | None:
        """Params 5, 6 and 7 as ENU m, NaN where not given; None: no place on Earth near here."""
        latitude, longitude, z = (self.number(param, nan) for param in (5, 6, 7))
        if zero_is_here and latitude == 0.0 and longitude == 0.0:
            latitude = longitude = nan
        if isfinite(z) and abs(z) > FARTHEST_M:
            return None
        up = z + home_z if self.frame in _RELATIVE else z - origin.altitude_m
        if not (isfinite(latitude) and isfinite(longitude)):
            return nan, nan, up
        if abs(latitude) > 90.0 or abs(longitude) > 180.0:
            return None
        amsl = up + origin.altitude_m if isfinite(up) else origin.altitude_m
        x, y, curved = to_enu(latitude, longitude, amsl, origin).tolist()
        if abs(x) > FARTHEST_M or abs(y) > FARTHEST_M:
            return None
        if isfinite(up) and self.frame in _ABSOLUTE:
            up = curved
        return x, y, up
