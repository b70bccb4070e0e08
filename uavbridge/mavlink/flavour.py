"""What differs between autopilots: mode numbers, and how to ask for a flight phase.

A flavour is chosen by the heartbeat. ``plan`` turns one command of the vehicle
seam into the steps that the autopilot needs, and the state that shows success.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol, TypeAlias

from sim_vehicles.codec import mav
from uavbridge.mavlink.commands import Order
from uavbridge.mavlink.parameters import Kind
from uavbridge.vehicle.api import (
    Arm,
    Command,
    Disarm,
    Follow,
    HoldPosition,
    LandHere,
    Mode,
    ReturnHome,
    TakeOff,
)


@dataclass(frozen=True, slots=True)
class SetParameter:
    """Set a parameter of the autopilot."""

    name: str
    value: float
    kind: Kind = Kind.REAL32


@dataclass(frozen=True, slots=True)
class Lead:
    """Stream setpoints for a moment before the next step."""

    duration_s: float


Step: TypeAlias = Order | SetParameter | Lead


@dataclass(frozen=True, slots=True)
class Plan:
    """How to carry out one command.

    Attributes:
        steps: one after the other, each accepted before the next.
        mode: the heartbeat's mode that shows success; None: the mode says nothing.
        armed: the heartbeat's armed flag that shows success; None: it says nothing.
    """

    steps: tuple[Step, ...]
    mode: Mode | None = None
    armed: bool | None = None


class Flavour(Protocol):
    """One make of autopilot."""

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    @property
    def bytewise_parameters(self) -> bool:
        """Whole parameters travel as raw bits."""
        ...

    def mode(self, custom_mode: int) -> tuple[Mode, str]:
        """The mode of a heartbeat, and the autopilot's own name of it."""
        ...

    def plan(self, command: Command) -> Plan:
        """How to carry out a command. Raises ValueError for a setpoint: those are streamed."""
        ...


_CUSTOM: Final = float(mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)
_LEAD: Final = Lead(0.3)


def _set_mode(main: int, sub: int = 0, *, persistent: bool = False) -> Order:
    params = (_CUSTOM, float(main), float(sub), 0.0, 0.0, 0.0, 0.0)
    return Order(mav.MAV_CMD_DO_SET_MODE, params, persistent=persistent)


def _arm(arm: bool) -> Plan:
    params = (float(arm), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Plan((Order(mav.MAV_CMD_COMPONENT_ARM_DISARM, params),), armed=arm)


_PX4_AUTO: Final = 4
_PX4_OFFBOARD: Final = 6
_PX4_MAIN: Final = {
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
_PX4_SUB: Final = {
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
    """PX4: main and sub mode in the upper bytes of ``custom_mode``."""

    name: Final = "PX4"
    bytewise_parameters: Final = True

    def mode(self, custom_mode: int) -> tuple[Mode, str]:
        main, sub = custom_mode >> 16 & 255, custom_mode >> 24 & 255
        known = _PX4_SUB.get(sub) if main == _PX4_AUTO else _PX4_MAIN.get(main)
        return known or (Mode.UNKNOWN, f"mode {main}.{sub}")

    def plan(self, command: Command) -> Plan:
        match command:
            case Arm() | Disarm():
                return _arm(isinstance(command, Arm))
            case TakeOff(height_m):
                take_off = Order(mav.MAV_CMD_NAV_TAKEOFF)
                return Plan((SetParameter("MIS_TAKEOFF_ALT", height_m), take_off), Mode.TAKEOFF)
            case Follow():
                return Plan((_LEAD, _set_mode(_PX4_OFFBOARD, persistent=True)), Mode.OFFBOARD)
            case HoldPosition():
                return Plan((_set_mode(_PX4_AUTO, 3),), Mode.HOLD)
            case LandHere():
                return Plan((_set_mode(_PX4_AUTO, 6),), Mode.LAND)
            case ReturnHome():
                return Plan((_set_mode(_PX4_AUTO, 5),), Mode.RETURN)
        raise ValueError(f"{command} is no command")


_GUIDED: Final = 4
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


class ArduCopter:
    """ArduPilot's copter: follows setpoints and takes off in GUIDED."""

    name: Final = "ArduCopter"
    bytewise_parameters: Final = False

    def mode(self, custom_mode: int) -> tuple[Mode, str]:
        return _COPTER.get(custom_mode, (Mode.UNKNOWN, f"mode {custom_mode}"))

    def plan(self, command: Command) -> Plan:
        match command:
            case Arm() | Disarm():
                return _arm(isinstance(command, Arm))
            case TakeOff(height_m):
                climb = Order(mav.MAV_CMD_NAV_TAKEOFF, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, height_m))
                return Plan((_set_mode(_GUIDED), climb), Mode.OFFBOARD)
            case Follow():
                return Plan((_set_mode(_GUIDED, persistent=True),), Mode.OFFBOARD)
            case HoldPosition():
                return Plan((_set_mode(_BRAKE),), Mode.HOLD)
            case LandHere():
                return Plan((_set_mode(9),), Mode.LAND)
            case ReturnHome():
                return Plan((_set_mode(6),), Mode.RETURN)
        raise ValueError(f"{command} is no command")


_COPTER_TYPES: Final = frozenset(
    int(getattr(mav, f"MAV_TYPE_{name}"))
    for name in (
        "QUADROTOR",
        "COAXIAL",
        "HELICOPTER",
        "HEXAROTOR",
        "OCTOROTOR",
        "TRICOPTER",
        "DODECAROTOR",
        "DECAROTOR",
    )
)
PX4: Final[Flavour] = Px4()
ARDUCOPTER: Final[Flavour] = ArduCopter()


def flavour_of(autopilot: int, vehicle_type: int) -> Flavour | str:
    """The flavour that a heartbeat announces, or why there is none."""
    if autopilot == mav.MAV_AUTOPILOT_PX4:
        return PX4
    if autopilot == mav.MAV_AUTOPILOT_ARDUPILOTMEGA:
        if vehicle_type in _COPTER_TYPES:
            return ARDUCOPTER
        return f"ArduPilot vehicle of type {_enum('MAV_TYPE', vehicle_type)} is not supported"
    return f"autopilot {_enum('MAV_AUTOPILOT', autopilot)} is not supported: PX4 and ArduPilot are"


def _enum(name: str, value: int) -> str:
    entry = mav.enums[name].get(value)
    return f"{value} ({entry.name.removeprefix(name + '_').lower()})" if entry else str(value)
