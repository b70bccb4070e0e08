"""ArduPilot: one mode number a vehicle kind; follows setpoints in GUIDED.

Copters and rovers take velocities for ``GUID_TIMEOUT`` (3 s); planes fly to points and
circle there (``repositions``). Whole parameters travel as plain floats.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil
from typing import Final

from sim_vehicles.codec import mav
from uavbridge.mavlink.commands import Order
from uavbridge.mavlink.identity import SYSTEM
from uavbridge.mavlink.parameters import Kind
from uavbridge.mavlink.plan import (
    Plan,
    ProvideLanding,
    SetParameter,
    Setting,
    Step,
    arming,
    set_mode,
)
from uavbridge.mavlink.wishes import Wish
from uavbridge.vehicle.api import (
    Arm,
    Command,
    Disarm,
    Follow,
    HoldPosition,
    LandHere,
    Mode,
    Net,
    ReturnHome,
    TakeOff,
    VehicleKind,
)

Modes = Mapping[int, tuple[Mode, str]]

_STABILIZE, _FBWA = 2, 5
_BRAKE: Final = 17  # holds without a pilot's throttle, which LOITER does not
_COPTER: Final = {
    0: (Mode.MANUAL, "STABILIZE"),
    1: (Mode.MANUAL, "ACRO"),
    2: (Mode.MANUAL, "ALT_HOLD"),
    3: (Mode.MISSION, "AUTO"),
    4: (Mode.OFFBOARD, "GUIDED"),
    5: (Mode.MANUAL, "LOITER"),
    6: (Mode.RETURN, "RTL"),
    7: (Mode.MANUAL, "CIRCLE"),
    9: (Mode.LAND, "LAND"),
    11: (Mode.MANUAL, "DRIFT"),
    13: (Mode.MANUAL, "SPORT"),
    14: (Mode.MANUAL, "FLIP"),
    15: (Mode.MANUAL, "AUTOTUNE"),
    16: (Mode.MANUAL, "POSHOLD"),
    17: (Mode.HOLD, "BRAKE"),
    18: (Mode.MANUAL, "THROW"),
    20: (Mode.OFFBOARD, "GUIDED_NOGPS"),
    21: (Mode.RETURN, "SMART_RTL"),
    27: (Mode.RETURN, "AUTO_RTL"),
}
_ROVER: Final = {
    0: (Mode.MANUAL, "MANUAL"),
    1: (Mode.MANUAL, "ACRO"),
    3: (Mode.MANUAL, "STEERING"),
    4: (Mode.HOLD, "HOLD"),
    5: (Mode.HOLD, "LOITER"),
    6: (Mode.UNKNOWN, "FOLLOW"),
    7: (Mode.MANUAL, "SIMPLE"),
    8: (Mode.UNKNOWN, "DOCK"),
    9: (Mode.MANUAL, "CIRCLE"),
    10: (Mode.MISSION, "AUTO"),
    11: (Mode.RETURN, "RTL"),
    12: (Mode.RETURN, "SMART_RTL"),
    15: (Mode.OFFBOARD, "GUIDED"),
    16: (Mode.UNKNOWN, "INITIALISING"),
}
_PLANE: Final = {
    0: (Mode.MANUAL, "MANUAL"),
    1: (Mode.MANUAL, "CIRCLE"),
    2: (Mode.MANUAL, "STABILIZE"),
    3: (Mode.MANUAL, "TRAINING"),
    4: (Mode.MANUAL, "ACRO"),
    5: (Mode.MANUAL, "FBWA"),
    6: (Mode.MANUAL, "FBWB"),
    7: (Mode.MANUAL, "CRUISE"),
    8: (Mode.MANUAL, "AUTOTUNE"),
    10: (Mode.MISSION, "AUTO"),
    11: (Mode.RETURN, "RTL"),
    12: (Mode.HOLD, "LOITER"),
    13: (Mode.TAKEOFF, "TAKEOFF"),
    15: (Mode.OFFBOARD, "GUIDED"),
    16: (Mode.UNKNOWN, "INITIALISING"),
    24: (Mode.MANUAL, "THERMAL"),
    26: (Mode.LAND, "AUTOLAND"),
}
_STREAMS: Final = (Wish("EKF_STATUS_REPORT", 1.0),)
_SHORTEST_GCS_LOSS_S, _LONGEST_GCS_LOSS_S = 2.0, 120.0
_ALTITUDE, _CIRCLE, _POLYGON = 1, 2, 4  # bits of FENCE_TYPE
_SMALLEST_FENCE_M: Final = 30.0
_LOWEST_FENCE_M: Final = 10.0
_PLANE_ROOM_M: Final = 600.0  # for its turns, and to come down before it lands


class ArduPilot:
    """What all kinds have in common.

    Args:
        name: of the firmware.
        kind: of the vehicle.
        modes: by number.
        guided: number of the mode that follows us.
        hold: of the one that stays where it is.
        home: of the one that returns.
    """

    bytewise_parameters: Final = False
    streams: Final = _STREAMS

    def __init__(
        self, name: str, kind: VehicleKind, modes: Modes, *, guided: int, hold: int, home: int
    ) -> None:
        self.name: Final = name
        self.kind: Final = kind
        self.repositions: Final = kind == "plane"
        self.lands_by_mission: Final = kind == "plane"
        # LAND arms no copter; planes forget that they were landing when their mode changes.
        modes_of = (_STABILIZE, _FBWA) if kind == "plane" else (guided,)
        self.stand_by: Final = tuple(set_mode(mode) for mode in modes_of)
        self._modes = modes
        self._guided, self._hold, self._home = guided, hold, home

    def mode(self, custom_mode: int) -> tuple[Mode, str]:
        return self._modes.get(custom_mode, (Mode.UNKNOWN, f"mode {custom_mode}"))

    def plan(self, command: Command) -> Plan:
        match command:
            case Arm() | Disarm():
                armed = isinstance(command, Arm)
                return Plan((arming(armed),), armed=armed)
            case TakeOff(height_m):
                return self._take_off(height_m)
            case Follow():
                return Plan((set_mode(self._guided, persistent=True),), Mode.OFFBOARD)
            case HoldPosition():
                return Plan((set_mode(self._hold),), Mode.HOLD)
            case LandHere():
                return self._land()
            case ReturnHome():
                return Plan((set_mode(self._home),), Mode.RETURN)
        raise ValueError(f"{command} is no command")

    def _take_off(self, height_m: float) -> Plan:
        climb = Order(mav.MAV_CMD_NAV_TAKEOFF, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, height_m))
        return Plan((set_mode(self._guided), climb), Mode.OFFBOARD)

    def _land(self) -> Plan:
        return Plan((set_mode(9),), Mode.LAND)

    def net(self, net: Net) -> tuple[Setting, ...]:
        """As every kind has it: who counts as ground station, and the fence's circle."""
        byte = Kind.INT8
        radius_m = max(net.fence_radius_m, _SMALLEST_FENCE_M)
        return (
            Setting((("SYSID_MYGCS", SYSTEM), ("MAV_GCS_SYSID", SYSTEM)), Kind.INT16),
            Setting.of("FENCE_RADIUS", radius_m),
            Setting.of("FENCE_ACTION", 1, byte),
            *self._own_net(net),
            Setting.of("FENCE_ENABLE", 1, byte),
        )

    def _own_net(self, net: Net) -> tuple[Setting, ...]:
        return (
            Setting.of("FENCE_TYPE", _ALTITUDE | _CIRCLE, Kind.INT8),
            Setting.of("FENCE_ALT_MAX", max(net.fence_height_m, _LOWEST_FENCE_M)),
            Setting(
                (
                    ("RTL_ALT", ceil(net.return_height_m * 100)),
                    ("RTL_ALT_M", net.return_height_m),
                ),
                Kind.INT32,
            ),
            Setting.of("GUID_TIMEOUT", max(net.setpoint_loss_s, 0.1)),
            Setting.of("FS_GCS_TIMEOUT", gcs_loss_s(net)),
            Setting.of("FS_GCS_ENABLE", 1, Kind.INT8),
        )


class ArduRover(ArduPilot):
    """Drives; its take-off is nothing but GUIDED, its landing HOLD and disarming."""

    def _take_off(self, height_m: float) -> Plan:
        return Plan((set_mode(self._guided),), Mode.OFFBOARD)

    def _land(self) -> Plan:
        return Plan((set_mode(self._hold), arming(False)), Mode.HOLD, armed=False)

    def _own_net(self, net: Net) -> tuple[Setting, ...]:
        return (
            Setting.of("FENCE_TYPE", _CIRCLE, Kind.INT8),
            Setting.of("FS_GCS_TIMEOUT", gcs_loss_s(net)),
            Setting.of("FS_ACTION", 1, Kind.INT8),
            Setting.of("FS_GCS_ENABLE", 1, Kind.INT8),
        )


class ArduPlane(ArduPilot):
    """Takes off in a mode of its own; lands by a landing sequence in its mission."""

    def _take_off(self, height_m: float) -> Plan:
        setting = SetParameter("TKOFF_ALT", height_m, Kind.INT16)
        steps: tuple[Step, ...] = (setting, set_mode(13))
        return Plan(steps, Mode.TAKEOFF)

    def _land(self) -> Plan:
        start = Order(mav.MAV_CMD_DO_LAND_START, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        return Plan((ProvideLanding(), start), Mode.MISSION)

    def net(self, net: Net) -> tuple[Setting, ...]:
        byte, real = Kind.INT8, Kind.REAL32
        room_m = net.fence_radius_m + _PLANE_ROOM_M
        return (
            Setting((("SYSID_MYGCS", SYSTEM), ("MAV_GCS_SYSID", SYSTEM)), Kind.INT16),
            Setting.of("FENCE_RADIUS", room_m),
            Setting.of("FENCE_ALT_MAX", net.fence_height_m + 30.0),
            Setting.of("FENCE_TYPE", _ALTITUDE | _CIRCLE, byte),
            Setting.of("FENCE_ACTION", 1, byte),
            Setting(
                (
                    ("RTL_ALTITUDE", net.return_height_m),
                    ("ALT_HOLD_RTL", ceil(net.return_height_m * 100)),
                ),
                real,
            ),
            Setting.of("TKOFF_ALT", ceil(net.take_off_m), Kind.INT16),
            Setting.of("FS_LONG_TIMEOUT", gcs_loss_s(net)),
            Setting.of("FS_LONG_ACTN", 1, byte),
            Setting.of("FS_GCS_ENABL", 1, byte),
            Setting.of("FENCE_ENABLE", 1, byte),
        )


def gcs_loss_s(net: Net) -> float:
    """The link-loss time as ArduPilot can have it."""
    return min(max(net.link_loss_s, _SHORTEST_GCS_LOSS_S), _LONGEST_GCS_LOSS_S)


ARDUCOPTER: Final = ArduPilot("ArduCopter", "multirotor", _COPTER, guided=4, hold=_BRAKE, home=6)
ARDUROVER: Final = ArduRover("ArduRover", "rover", _ROVER, guided=15, hold=4, home=11)
ARDUPLANE: Final = ArduPlane("ArduPlane", "plane", _PLANE, guided=15, hold=12, home=11)
