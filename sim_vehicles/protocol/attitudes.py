"""SET_ATTITUDE_TARGET, of aircraft: attitude or body rates, and thrust."""

from __future__ import annotations

from math import asin, atan2, isfinite, nan
from typing import Any, Final

from sim_vehicles.codec import Packet
from sim_vehicles.legs import Tilt
from sim_vehicles.protocol.endpoint import Endpoint

_NO_ROLL_RATE, _NO_PITCH_RATE, _NO_YAW_RATE = 1, 2, 4
_NO_RATES: Final = _NO_ROLL_RATE | _NO_PITCH_RATE
_NO_THROTTLE: Final = 64
_NO_ATTITUDE: Final = 128
_FASTEST: Final = 10.0  # rad/s: more is nonsense


def on_attitude(endpoint: Endpoint, packet: Packet) -> None:
    """An attitude before body rates, as PX4 takes it; ArduPlane takes single angles, no rates."""
    if endpoint.services.craft.kind != "plane":
        return
    message = packet.message
    parts = endpoint.services.flavour.answers.whole_vectors
    asked = _by_parts(message) if parts else _whole(message)
    if asked is not None:
        endpoint.pilot.tilt(endpoint.index, asked)


def _whole(message: Any) -> Tilt | None:
    """PX4's: one of both, with a throttle."""
    mask, throttle = message.type_mask, _throttle(message)
    angles = _angles(message.q)
    if not mask & _NO_ATTITUDE:
        return None if angles is None else Tilt(*angles, throttle)
    rates = message.body_roll_rate, message.body_pitch_rate
    if mask & _NO_RATES or not all(abs(rate) < _FASTEST for rate in rates):
        return None
    return Tilt(nan, nan, throttle, *rates)


def _by_parts(message: Any) -> Tilt | None:
    """ArduPlane's: the bits of the rates say which angle of the quaternion counts."""
    mask, throttle = message.type_mask, _throttle(message)
    angles = _angles(message.q)
    whole = not mask & _NO_ATTITUDE
    if angles is None and (whole or mask & _NO_RATES != _NO_RATES):
        return None
    roll, pitch = angles or (nan, nan)
    roll = roll if whole or not mask & _NO_ROLL_RATE else nan
    pitch = pitch if whole or not mask & _NO_PITCH_RATE else nan
    tilt = Tilt(roll, pitch, throttle)
    return tilt if any(map(isfinite, tilt)) else None


def _throttle(message: Any) -> float:
    thrust = nan if message.type_mask & _NO_THROTTLE else message.thrust
    return min(max(float(thrust), 0.0), 1.0) if isfinite(thrust) else nan


def _angles(quaternion: Any) -> tuple[float, float] | None:
    """Roll and pitch, rad; None: it is no rotation."""
    w, x, y, z = (float(part) for part in quaternion)
    size = w * w + x * x + y * y + z * z
    if not 0.5 < size < 2.0:
        return None
    roll = atan2(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z)
    return roll, asin(min(max(2.0 * (w * y - z * x) / size, -1.0), 1.0))
