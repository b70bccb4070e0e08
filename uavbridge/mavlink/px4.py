"""PX4: main and sub mode in the upper bytes of ``custom_mode``; follows setpoints in offboard."""

from __future__ import annotations

from typing import Final

from sim_vehicles.codec import mav
from uavbridge.mavlink.commands import Order
from uavbridge.mavlink.parameters import Kind
from uavbridge.mavlink.plan import Lead, Plan, SetParameter, Setting, arming, set_mode
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

_LEAD: Final = Lead(0.3)
_RETURN, _HOLD_ON_LOSS, _DLL_RETURN = 3, 5, 2  # of GF_ACTION, COM_OBL_RC_ACT, NAV_DLL_ACT
_LONGEST_OF_LOSS_S, _LONGEST_DL_LOSS_S = 60.0, 300.0
_AUTO: Final = 4
_OFFBOARD: Final = 6
_MAIN: Final = {
    1: (Mode.MANUAL, "MANUAL"),
    2: (Mode.MANUAL, "ALTCTL"),
    3: (Mode.MANUAL, "POSCTL"),
    5: (Mode.MANUAL, "ACRO"),
    6: (Mode.OFFBOARD, "OFFBOARD"),
    7: (Mode.MANUAL, "STABILIZED"),
    8: (Mode.MANUAL, "RATTITUDE"),
    10: (Mode.MANUAL, "TERMINATION"),
    11: (Mode.MANUAL, "ALTITUDE_CRUISE"),
}
_SUB: Final = {
    1: (Mode.HOLD, "AUTO.READY"),
    2: (Mode.TAKEOFF, "AUTO.TAKEOFF"),
    3: (Mode.HOLD, "AUTO.LOITER"),
    4: (Mode.MISSION, "AUTO.MISSION"),
    5: (Mode.RETURN, "AUTO.RTL"),
    6: (Mode.LAND, "AUTO.LAND"),
    8: (Mode.UNKNOWN, "AUTO.FOLLOW_TARGET"),
    9: (Mode.LAND, "AUTO.PRECLAND"),
    10: (Mode.UNKNOWN, "AUTO.VTOL_TAKEOFF"),
}


class Px4:
    """One kind of vehicle with PX4."""

    name: Final = "PX4"
    bytewise_parameters: Final = True
    streams: Final[tuple[Wish, ...]] = ()
    repositions: Final = False
    lands_by_mission: Final = False
    stand_by: Final = (set_mode(_AUTO, 3),)  # in OFFBOARD, which it lands in, it wants setpoints

    def __init__(self, kind: VehicleKind = "multirotor") -> None:
        self.kind: Final = kind

    def mode(self, custom_mode: int) -> tuple[Mode, str]:
        main, sub = custom_mode >> 16 & 255, custom_mode >> 24 & 255
        known = _SUB.get(sub) if main == _AUTO else _MAIN.get(main)
        return known or (Mode.UNKNOWN, f"mode {main}.{sub}")

    def plan(self, command: Command) -> Plan:
        match command:
            case Arm() | Disarm():
                armed = isinstance(command, Arm)
                return Plan((arming(armed),), armed=armed)
            case TakeOff(height_m):
                take_off = Order(mav.MAV_CMD_NAV_TAKEOFF)
                return Plan((SetParameter("MIS_TAKEOFF_ALT", height_m), take_off), Mode.TAKEOFF)
            case Follow():
                return Plan((_LEAD, set_mode(_OFFBOARD, persistent=True)), Mode.OFFBOARD)
            case HoldPosition():
                return Plan((set_mode(_AUTO, 3),), Mode.HOLD)
            case LandHere():
                return Plan((set_mode(_AUTO, 6),), Mode.LAND)
            case ReturnHome():
                return Plan((set_mode(_AUTO, 5),), Mode.RETURN)
        raise ValueError(f"{command} is no command")

    def net(self, net: Net) -> tuple[Setting, ...]:
        whole = Kind.INT32
        return (
            Setting.of("GF_MAX_HOR_DIST", net.fence_radius_m),
            Setting.of("GF_MAX_VER_DIST", net.fence_height_m),
            Setting.of("GF_ACTION", _RETURN, whole),
            Setting.of("RTL_RETURN_ALT", net.return_height_m),
            Setting.of("MIS_TAKEOFF_ALT", net.take_off_m),
            Setting.of("COM_OF_LOSS_T", min(net.setpoint_loss_s, _LONGEST_OF_LOSS_S)),
            Setting.of("COM_OBL_RC_ACT", _HOLD_ON_LOSS, whole),
            Setting.of("COM_DL_LOSS_T", min(round(net.link_loss_s), _LONGEST_DL_LOSS_S), whole),
            Setting.of("NAV_DLL_ACT", _DLL_RETURN, whole),
        )
