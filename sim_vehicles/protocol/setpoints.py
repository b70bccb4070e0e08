"""Position and velocity setpoints from outside, in any of the common frames."""

from __future__ import annotations

from math import cos, isfinite, nan, pi, sin
from typing import Any, Final

from sim_vehicles.codec import Packet, mav
from sim_vehicles.geodesy import to_enu
from sim_vehicles.legs import Tilt
from sim_vehicles.plans import NOWHERE, Do, Vector
from sim_vehicles.protocol.endpoint import Endpoint
from sim_vehicles.protocol.orders import FARTHEST_M
from sim_vehicles.winged.pilot import Px4Plane

_PLACE: Final = 7  # the bits of a position, and of a velocity
_HEIGHT: Final = 4
_SPEED: Final = 56
_FORCE: Final = 512
_NO_YAW: Final = 1024
_NO_YAW_RATE: Final = 2048
_TYPE: Final = 0x7000  # of PX4's setpoints for aircraft
_IDLE: Final = 0x4000
_MANOEUVRES: Final = {0x1000: Do.TAKE_OFF, 0x2000: Do.LAND}
_GLIDE: Final = 292
_TURNS: Final = 1e3  # rad, rad/s: more is nonsense

_NED: Final[int] = mav.MAV_FRAME_LOCAL_NED
_BODY: Final[frozenset[int]] = frozenset(
    (mav.MAV_FRAME_BODY_NED, mav.MAV_FRAME_BODY_OFFSET_NED, mav.MAV_FRAME_BODY_FRD)
)
_OFFSET: Final[frozenset[int]] = _BODY | {mav.MAV_FRAME_LOCAL_OFFSET_NED}
_ABSOLUTE: Final[frozenset[int]] = frozenset((mav.MAV_FRAME_GLOBAL, mav.MAV_FRAME_GLOBAL_INT))
_GLOBAL: Final[frozenset[int]] = _ABSOLUTE | {
    mav.MAV_FRAME_GLOBAL_RELATIVE_ALT,
    mav.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
}


def on_local(endpoint: Endpoint, packet: Packet) -> None:
    """SET_POSITION_TARGET_LOCAL_NED.

    Body frames: position from the vehicle, in its heading; velocity in its heading. Yaw is
    from north in all frames, as PX4 takes it.
    """
    if not endpoint.services.flavour.answers.local_setpoints:
        return
    message = packet.message
    frame = message.coordinate_frame
    if frame != _NED and frame not in _OFFSET:
        return
    mask = _mask(endpoint, message.type_mask)
    position = velocity = NOWHERE
    if mask & _SPEED != _SPEED:
        north, east, down = _wanted(mask >> 3, message.vx, message.vy, message.vz)
        velocity = east, north, -down
        if frame in _BODY:
            velocity = _turned(velocity, endpoint.pilot.yaw(endpoint.index))
    if mask & _PLACE != _PLACE:
        pilot, i = endpoint.pilot, endpoint.index
        north, east, down = _wanted(mask, message.x, message.y, message.z)
        position = east, north, -down
        if frame in _BODY:
            position = _turned(position, pilot.yaw(i))
        x, y, z = pilot.status.origin[i].tolist() if frame == _NED else pilot.place(i)
        position = position[0] + x, position[1] + y, position[2] + z
    _follow(endpoint, message, position, velocity)


def on_global(endpoint: Endpoint, packet: Packet) -> None:
    """SET_POSITION_TARGET_GLOBAL_INT; heights over terrain are not known here."""
    message = packet.message
    if message.coordinate_frame not in _GLOBAL:
        return
    origin = endpoint.services.origin
    mask = _mask(endpoint, message.type_mask)
    x = y = z = nan
    if not mask & 3:
        if abs(message.lat_int) > 900_000_000 or abs(message.lon_int) > 1_800_000_000:
            return
        level = origin.altitude_m
        x, y, _ = to_enu(message.lat_int * 1e-7, message.lon_int * 1e-7, level, origin).tolist()
    if not mask & 4:
        home_z = float(endpoint.pilot.status.home[endpoint.index, 2])
        absolute = message.coordinate_frame in _ABSOLUTE
        z = message.alt + (-origin.altitude_m if absolute else home_z)
    north, east, down = _wanted(mask >> 3, message.vx, message.vy, message.vz)
    _follow(endpoint, message, (x, y, z), (east, north, -down))


def _mask(endpoint: Endpoint, mask: int) -> int:
    """ArduPilot ignores a position, or a velocity, of which one part is to be ignored.

    Its planes take a height alone.
    """
    craft = endpoint.services.craft
    if craft.flavour.answers.whole_vectors and not (craft.kind == "plane" and not mask & _HEIGHT):
        for bits in (_PLACE, _SPEED):
            mask |= bits if mask & bits else 0
    return mask


def _wanted(mask: int, a: float, b: float, c: float) -> Vector:
    """Three fields, NaN where the mask says to ignore them or they are not finite."""
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


def _as_told(endpoint: Endpoint, mask: int, position: Vector) -> bool:
    """The types of setpoint that PX4 documents for aircraft; whether it was one of them.

    A loiter (12288) is what a place alone asks for, and flown as that.
    """
    pilot, i = endpoint.pilot, endpoint.index
    assert isinstance(pilot, Px4Plane)
    near = all(abs(part) <= FARTHEST_M for part in position if isfinite(part))
    kind = _MANOEUVRES.get(mask & _TYPE)
    if mask & _TYPE == _IDLE:
        pilot.tilt(i, Tilt(0.0, 0.0, 0.0))
    elif mask == _GLIDE and near and isfinite(position[0]):
        pilot.glide(i, (position[0], position[1], nan))
    elif kind is not None and near and all(map(isfinite, position)):
        pilot.manoeuvre(i, kind, position)
    else:
        return False
    return True


def _follow(endpoint: Endpoint, message: Any, position: Vector, velocity: Vector) -> None:
    """Hand a setpoint on, unless it asks for nothing or for what can not be."""
    mask = message.type_mask
    if isinstance(endpoint.pilot, Px4Plane) and _as_told(endpoint, mask, position):
        return
    asked = (*position, *velocity)
    if mask & _FORCE or not any(map(isfinite, asked)) or any(abs(x) > FARTHEST_M for x in asked):
        return
    yaw = yaw_rate = nan
    if not mask & _NO_YAW and abs(message.yaw) < _TURNS:
        yaw = (1.5 * pi - message.yaw) % (2 * pi) - pi
    if not mask & _NO_YAW_RATE and abs(message.yaw_rate) < _TURNS:
        yaw_rate = -message.yaw_rate
    endpoint.pilot.follow(endpoint.index, (*asked, yaw, yaw_rate))
