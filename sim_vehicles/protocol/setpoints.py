"""Position and velocity setpoints from outside, in any of the common frames."""

from __future__ import annotations

from math import cos, hypot, isfinite, nan, pi, sin
from typing import Any, Final

from sim_vehicles.codec import Packet, mav
from sim_vehicles.geodesy import to_enu
from sim_vehicles.plans import NOWHERE, Vector
from sim_vehicles.protocol.endpoint import Endpoint
from sim_vehicles.protocol.orders import FARTHEST_M

_FORCE: Final = 512
_NO_YAW: Final = 1024
_NO_YAW_RATE: Final = 2048

_BODY: Final = frozenset(
    (mav.MAV_FRAME_BODY_NED, mav.MAV_FRAME_BODY_OFFSET_NED, mav.MAV_FRAME_BODY_FRD)
)
_LOCAL: Final = _BODY | {mav.MAV_FRAME_LOCAL_NED, mav.MAV_FRAME_LOCAL_OFFSET_NED}
_ABSOLUTE: Final = frozenset((mav.MAV_FRAME_GLOBAL, mav.MAV_FRAME_GLOBAL_INT))
_GLOBAL: Final = _ABSOLUTE | {
    mav.MAV_FRAME_GLOBAL_RELATIVE_ALT,
    mav.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
}


def on_local(endpoint: Endpoint, packet: Packet) -> None:
    """SET_POSITION_TARGET_LOCAL_NED.

    Body frames: position from the vehicle, in its heading; velocity in its heading. Yaw is
    from north in all frames, as PX4 takes it.
    """
    message = packet.message
    frame = message.coordinate_frame
    if frame not in _LOCAL:
        return
    north, east, down = _wanted(message, 0, message.x, message.y, message.z)
    vn, ve, vd = _wanted(message, 3, message.vx, message.vy, message.vz)
    pilot, i = endpoint.pilot, endpoint.index
    position: Vector = (east, north, -down)
    velocity: Vector = (ve, vn, -vd)
    if frame in _BODY:
        yaw = pilot.yaw(i)
        position, velocity = _turned(position, yaw), _turned(velocity, yaw)
    if frame == mav.MAV_FRAME_LOCAL_NED:
        ox, oy, oz = pilot.status.origin[i].tolist()
    else:
        ox, oy, oz = pilot.place(i)
    _follow(endpoint, message, (position[0] + ox, position[1] + oy, position[2] + oz), velocity)


def on_global(endpoint: Endpoint, packet: Packet) -> None:
    """SET_POSITION_TARGET_GLOBAL_INT; heights over terrain are not known here."""
    message = packet.message
    if message.coordinate_frame not in _GLOBAL:
        return
    origin = endpoint.services.origin
    home_z = float(endpoint.pilot.status.home[endpoint.index, 2])
    position = NOWHERE
    if not message.type_mask & 3:
        if abs(message.lat_int) > 900_000_000 or abs(message.lon_int) > 1_800_000_000:
            return
        x, y, _ = to_enu(message.lat_int * 1e-7, message.lon_int * 1e-7, origin.altitude_m, origin)
        position = float(x), float(y), nan
    if not message.type_mask & 4:
        absolute = message.coordinate_frame in _ABSOLUTE
        offset = -origin.altitude_m if absolute else home_z
        position = position[0], position[1], message.alt + offset
    vn, ve, vd = _wanted(message, 3, message.vx, message.vy, message.vz)
    _follow(endpoint, message, position, (ve, vn, -vd))


def _wanted(message: Any, first_bit: int, a: float, b: float, c: float) -> Vector:
    """Three fields, NaN where the mask says to ignore them or they are not finite."""
    mask = message.type_mask >> first_bit
    return (
        a if not mask & 1 and isfinite(a) else nan,
        b if not mask & 2 and isfinite(b) else nan,
        c if not mask & 4 and isfinite(c) else nan,
    )


def _turned(vector: Vector, yaw: float) -> Vector:
    """From (right, ahead, up) to east, north, up; a missing horizontal part is zero then."""
    right, ahead, up = vector
    if right != right and ahead != ahead:
        return vector
    right, ahead = (0.0 if right != right else right), (0.0 if ahead != ahead else ahead)
    c, s = cos(yaw), sin(yaw)
    return ahead * c + right * s, ahead * s - right * c, up


def _follow(endpoint: Endpoint, message: Any, position: Vector, velocity: Vector) -> None:
    if message.type_mask & _FORCE or not _something(position, velocity):
        return
    if any(abs(value) > FARTHEST_M for value in position):
        return
    pilot, i = endpoint.pilot, endpoint.index
    heading, rate = message.yaw, message.yaw_rate
    yaw = nan
    if not message.type_mask & _NO_YAW and abs(heading) < 1e3:
        yaw = (1.5 * pi - heading) % (2 * pi) - pi
    yaw_rate = nan
    if not message.type_mask & _NO_YAW_RATE and abs(rate) < 1e3:
        yaw_rate = -rate
    pilot.follow(i, position, _bounded(endpoint, velocity), yaw, yaw_rate)


def _something(position: Vector, velocity: Vector) -> bool:
    return any(value == value for value in position) or any(value == value for value in velocity)


def _bounded(endpoint: Endpoint, velocity: Vector) -> Vector:
    """No faster than the vehicle's parameters permit, in the same direction."""
    get, i = endpoint.pilot.parameters.get, endpoint.index
    vx, vy, vz = velocity
    fastest = get(i, "MPC_XY_VEL_MAX")
    speed = hypot(0.0 if vx != vx else vx, 0.0 if vy != vy else vy)
    if speed > fastest:
        vx, vy = vx * (fastest / speed), vy * (fastest / speed)
    if vz == vz:
        vz = min(max(vz, -get(i, "MPC_Z_VEL_MAX_DN")), get(i, "MPC_Z_VEL_MAX_UP"))
    return vx, vy, vz
