"""Mission items as they travel, and the steps of a plan they stand for."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan, pi
from typing import Any, Final, NamedTuple

from sim_vehicles.codec import mav
from sim_vehicles.geodesy import Geodetic, to_enu
from sim_vehicles.plans import NOWHERE, Do, Step, Vector

UNSET: Final = 2**31 - 1  # of latitude and longitude: as NaN would be
_ABSOLUTE: Final = (mav.MAV_FRAME_GLOBAL, mav.MAV_FRAME_GLOBAL_INT)
_RELATIVE: Final = (mav.MAV_FRAME_GLOBAL_RELATIVE_ALT, mav.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
_PLACES: Final[dict[int, Do]] = {
    mav.MAV_CMD_NAV_WAYPOINT: Do.GO,
    mav.MAV_CMD_NAV_LOITER_UNLIM: Do.STAY,
    mav.MAV_CMD_NAV_LOITER_TIME: Do.GO,
    mav.MAV_CMD_NAV_LOITER_TO_ALT: Do.GO,
    mav.MAV_CMD_NAV_LOITER_TURNS: Do.CIRCLE,
    mav.MAV_CMD_NAV_SPLINE_WAYPOINT: Do.GO,
    mav.MAV_CMD_NAV_LAND: Do.LAND,
    mav.MAV_CMD_NAV_TAKEOFF: Do.TAKE_OFF,
}
_TO_ALT: Final[int] = mav.MAV_CMD_NAV_LOITER_TO_ALT
_LOITERS: Final = (
    *(_TO_ALT, mav.MAV_CMD_NAV_LOITER_UNLIM, mav.MAV_CMD_NAV_LOITER_TIME),
    mav.MAV_CMD_NAV_LOITER_TURNS,
)
_ORDERS: Final[dict[int, Do]] = {
    mav.MAV_CMD_NAV_RETURN_TO_LAUNCH: Do.RETURN,
    mav.MAV_CMD_NAV_DELAY: Do.PAUSE,
    mav.MAV_CMD_CONDITION_DELAY: Do.NOTHING,
    mav.MAV_CMD_CONDITION_DISTANCE: Do.NOTHING,
    mav.MAV_CMD_CONDITION_YAW: Do.TURN,
    mav.MAV_CMD_DO_JUMP: Do.JUMP,
    mav.MAV_CMD_DO_CHANGE_SPEED: Do.SPEED,
    mav.MAV_CMD_DO_SET_HOME: Do.NOTHING,
    mav.MAV_CMD_DO_SET_SERVO: Do.NOTHING,
    mav.MAV_CMD_DO_SET_ACTUATOR: Do.NOTHING,
    mav.MAV_CMD_DO_SET_ROI_LOCATION: Do.NOTHING,
    mav.MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET: Do.NOTHING,
    mav.MAV_CMD_DO_GRIPPER: Do.NOTHING,
    mav.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW: Do.NOTHING,
    mav.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE: Do.NOTHING,
    mav.MAV_CMD_DO_TRIGGER_CONTROL: Do.NOTHING,
    mav.MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL: Do.NOTHING,
    mav.MAV_CMD_SET_CAMERA_MODE: Do.NOTHING,
    mav.MAV_CMD_SET_CAMERA_ZOOM: Do.NOTHING,
    mav.MAV_CMD_SET_CAMERA_FOCUS: Do.NOTHING,
    mav.MAV_CMD_DO_LAND_START: Do.LANDING,
    mav.MAV_CMD_DO_SET_ROI: Do.NOTHING,
    mav.MAV_CMD_DO_SET_ROI_NONE: Do.NOTHING,
    mav.MAV_CMD_DO_DIGICAM_CONTROL: Do.NOTHING,
    mav.MAV_CMD_DO_MOUNT_CONFIGURE: Do.NOTHING,
    mav.MAV_CMD_DO_MOUNT_CONTROL: Do.NOTHING,
    mav.MAV_CMD_DO_SET_CAM_TRIGG_DIST: Do.NOTHING,
    mav.MAV_CMD_IMAGE_START_CAPTURE: Do.NOTHING,
    mav.MAV_CMD_IMAGE_STOP_CAPTURE: Do.NOTHING,
    mav.MAV_CMD_VIDEO_START_CAPTURE: Do.NOTHING,
    mav.MAV_CMD_VIDEO_STOP_CAPTURE: Do.NOTHING,
}
"""As PX4: places come in global frames, orders in the frame MISSION."""

_NOT_PX4: Final[frozenset[int]] = frozenset(
    (
        mav.MAV_CMD_NAV_LOITER_TURNS,
        mav.MAV_CMD_NAV_SPLINE_WAYPOINT,
        mav.MAV_CMD_CONDITION_YAW,
        mav.MAV_CMD_DO_SET_SERVO,
        mav.MAV_CMD_SET_CAMERA_ZOOM,
    )
)
_NOT_ARDUPILOT: Final[frozenset[int]] = frozenset(
    (
        mav.MAV_CMD_DO_SET_ACTUATOR,
        mav.MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET,
        mav.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE,
        mav.MAV_CMD_DO_TRIGGER_CONTROL,
        mav.MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL,
        mav.MAV_CMD_DO_MOUNT_CONFIGURE,
        mav.MAV_CMD_SET_CAMERA_MODE,
    )
)
"""What only the other one takes."""
_ACCEPTED: Final[int] = mav.MAV_MISSION_ACCEPTED
_UNSUPPORTED: Final[int] = mav.MAV_MISSION_UNSUPPORTED

FENCE_ITEMS: Final[frozenset[int]] = frozenset(
    (
        mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
        mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
        mav.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
        mav.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
    )
)
_RALLY_ITEMS: Final[frozenset[int]] = frozenset((mav.MAV_CMD_NAV_RALLY_POINT,))


class Item(NamedTuple):
    """A mission item, in the wire's units."""

    frame: int
    command: int
    current: int
    autocontinue: int
    param1: float
    param2: float
    param3: float
    param4: float
    x: int  # latitude, 1e-7 degrees
    y: int  # longitude
    z: float

    @staticmethod
    def read(message: Any) -> Item:
        """Of MISSION_ITEM_INT, or of MISSION_ITEM with its degrees as floats."""
        x, y = message.x, message.y
        if message.msgname == "MISSION_ITEM":
            x, y = _scaled(x), _scaled(y)
        return Item(
            message.frame,
            message.command,
            message.current,
            message.autocontinue,
            message.param1,
            message.param2,
            message.param3,
            message.param4,
            x,
            y,
            message.z,
        )


def _scaled(degrees: float) -> int:
    return round(degrees * 1e7) if abs(degrees) < 214.0 else UNSET  # NaN too


def why_not(item: Item, mission_type: int, *, any_frame: bool = False) -> int:
    """MAV_MISSION_ACCEPTED, or why an item can not be taken.

    With ``any_frame``, as by ArduPilot, orders may come in any frame, and places not in MISSION.
    """
    if mission_type != mav.MAV_MISSION_TYPE_MISSION:
        known = FENCE_ITEMS if mission_type == mav.MAV_MISSION_TYPE_FENCE else _RALLY_ITEMS
        return _bad_place(item) if item.command in known else _UNSUPPORTED
    if item.command in (_NOT_ARDUPILOT if any_frame else _NOT_PX4):
        return _UNSUPPORTED
    if any_frame:
        if item.command in _ORDERS:
            return _ACCEPTED
        return _not_finite(item) or _bad_place(item) if item.command in _PLACES else _UNSUPPORTED
    if item.frame == mav.MAV_FRAME_MISSION:
        return _ACCEPTED if item.command in _ORDERS else _UNSUPPORTED
    return _bad_place(item) if item.command in _PLACES else _UNSUPPORTED


def _bad_place(item: Item) -> int:
    if item.frame not in _ABSOLUTE + _RELATIVE:
        return int(mav.MAV_MISSION_UNSUPPORTED_FRAME)
    if item.x != UNSET and abs(item.x) > 900_000_000:
        return int(mav.MAV_MISSION_INVALID_PARAM5_X)
    if item.y != UNSET and abs(item.y) > 1_800_000_000:
        return int(mav.MAV_MISSION_INVALID_PARAM6_Y)
    if isfinite(item.z) and abs(item.z) > 1e5:
        return int(mav.MAV_MISSION_INVALID_PARAM7)
    return _ACCEPTED


def _not_finite(item: Item) -> int:
    """ArduPilot takes NaN for a yaw only."""
    for number, value in enumerate((item.param1, item.param2, item.param3)):
        if not isfinite(value):
            return int(mav.MAV_MISSION_INVALID_PARAM1) + number
    return _ACCEPTED


def plan(
    items: Sequence[Item], origin: Geodetic, home_z: float, *, home_first: bool = False
) -> tuple[Step, ...] | None:
    """The steps that items (each taken by ``why_not``) stand for; None: a jump leads nowhere.

    With ``home_first`` the first item is home, and no step.
    """
    steps = tuple(_step(item, origin, home_z) for item in items)
    if home_first:
        steps = (Step(Do.HOME), *steps[1:]) if steps else ()
    if any(step.do is Do.JUMP and not 0 <= step.jump_to < len(steps) for step in steps):
        return None
    return steps


def _step(item: Item, origin: Geodetic, home_z: float) -> Step:
    do = _PLACES.get(item.command)
    if do is None or item.frame == mav.MAV_FRAME_MISSION:
        return _order(item)
    position = place(item, origin, home_z)
    yaw = pi / 2 - item.param4 * pi / 180 if abs(item.param4) < 1e4 else nan
    pauses = (mav.MAV_CMD_NAV_WAYPOINT, mav.MAV_CMD_NAV_LOITER_TIME)
    pause = _number(item.param1, 0.0) if item.command in pauses else 0.0
    radius = _number(item.param2, nan) if item.command == mav.MAV_CMD_NAV_WAYPOINT else nan
    turns = _number(item.param2 if item.command == _TO_ALT else item.param3, 0.0)
    circle = -turns if item.command in _LOITERS and turns else nan  # positive is clockwise
    if do in (Do.TAKE_OFF, Do.LAND) and item.x == 0 and item.y == 0:
        position = (nan, nan, position[2])
    wait = max(pause, 0.0)
    rounds = max(_number(item.param1, 0.0), 0.0) if do is Do.CIRCLE else 0.0
    return Step(
        do, position, yaw_rad=yaw, radius_m=radius, circle_m=circle, pause_s=wait, rounds=rounds
    )


def _order(item: Item) -> Step:
    do = _ORDERS.get(item.command, Do.NOTHING)
    if do is Do.JUMP:
        return Step(do, jump_to=int(_number(item.param1, -1)), repeats=int(_number(item.param2, 0)))
    if do is Do.SPEED:
        speed = _number(item.param2, -1.0)
        return Step(do, speed_m_s=min(speed, 1e3) if speed > 0 else nan)
    if do is Do.TURN:
        relative = _number(item.param4, 0.0) != 0.0
        angle = item.param1 * pi / 180.0 if abs(item.param1) < 1e4 else nan
        way = -1.0 if _number(item.param3, 1.0) < 0.0 else 1.0
        return Step(do, yaw_rad=-way * angle if relative else pi / 2 - angle, relative=relative)
    return Step(do, pause_s=max(_number(item.param1, 0.0), 0.0) if do is Do.PAUSE else 0.0)


def _number(value: float, otherwise: float) -> float:
    return value if isfinite(value) and abs(value) < 1e9 else otherwise


def place(item: Item, origin: Geodetic, home_z: float) -> Vector:
    """Where an item is, ENU m; NaN where it does not say."""
    unset = item.x == UNSET or item.y == UNSET
    z = item.z if isfinite(item.z) else nan
    if unset:
        x, y, up = NOWHERE[0], NOWHERE[1], z - origin.altitude_m
    else:
        height = 0.0 if z != z else z
        amsl = height if item.frame in _ABSOLUTE else height + home_z + origin.altitude_m
        x, y, up = to_enu(item.x * 1e-7, item.y * 1e-7, amsl, origin).tolist()
    if z != z:
        up = nan
    elif item.frame in _RELATIVE:
        up = z + home_z
    return x, y, up
