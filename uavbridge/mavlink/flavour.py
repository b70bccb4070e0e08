"""What differs between autopilots: mode numbers, and how to ask for a flight phase.

A flavour is chosen by the heartbeat. ``plan`` turns one command of the vehicle
seam into the steps that the autopilot needs, and the state that shows success.
"""

from __future__ import annotations

from typing import Final, Protocol

from sim_vehicles.codec import mav
from uavbridge.mavlink.ardupilot import ARDUCOPTER, ARDUPLANE, ARDUROVER
from uavbridge.mavlink.commands import Order
from uavbridge.mavlink.plan import Plan, Setting
from uavbridge.mavlink.px4 import Px4
from uavbridge.mavlink.wishes import Wish
from uavbridge.vehicle.api import Command, Mode, Net, VehicleKind


class Flavour(Protocol):
    """One make of autopilot on one kind of vehicle."""

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    @property
    def kind(self) -> VehicleKind:
        """Of the vehicle."""
        ...

    @property
    def bytewise_parameters(self) -> bool:
        """Whole parameters travel as raw bits."""
        ...

    @property
    def streams(self) -> tuple[Wish, ...]:
        """Messages wanted of it beside those wanted of all."""
        ...

    @property
    def repositions(self) -> bool:
        """It flies to points given one at a time, and takes no setpoints."""
        ...

    @property
    def lands_by_mission(self) -> bool:
        """It lands by items of its mission alone."""
        ...

    @property
    def stand_by(self) -> tuple[Order, ...]:
        """Put it in a mode in which it can be armed, unlike that of an earlier flight's end."""
        ...

    def mode(self, custom_mode: int) -> tuple[Mode, str]:
        """The mode of a heartbeat, and the autopilot's own name of it."""
        ...

    def plan(self, command: Command) -> Plan:
        """How to carry out a command. Raises ValueError for a setpoint: those are streamed."""
        ...

    def net(self, net: Net) -> tuple[Setting, ...]:
        """The parameters of its own safety net, in the order in which they are set."""
        ...


_COPTER_TYPES: Final = tuple(
    f"MAV_TYPE_{name}"
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
_KINDS: Final[dict[int, VehicleKind]] = {
    **{int(getattr(mav, name)): "multirotor" for name in _COPTER_TYPES},
    int(mav.MAV_TYPE_GROUND_ROVER): "rover",
    int(mav.MAV_TYPE_SURFACE_BOAT): "rover",
    int(mav.MAV_TYPE_FIXED_WING): "plane",
}
PX4: Final[Flavour] = Px4()
_PX4: Final[dict[VehicleKind, Flavour]] = {
    "multirotor": PX4, "rover": Px4("rover"), "plane": Px4("plane"),
}  # fmt: skip
_ARDUPILOT: Final[dict[VehicleKind, Flavour]] = {
    "multirotor": ARDUCOPTER, "rover": ARDUROVER, "plane": ARDUPLANE,
}  # fmt: skip
_MAKES: Final = {
    int(mav.MAV_AUTOPILOT_PX4): ("PX4", _PX4),
    int(mav.MAV_AUTOPILOT_ARDUPILOTMEGA): ("ArduPilot", _ARDUPILOT),
}


def flavour_of(autopilot: int, vehicle_type: int) -> Flavour | str:
    """The flavour that a heartbeat announces, or why there is none."""
    make = _MAKES.get(autopilot)
    if make is None:
        number = _enum("MAV_AUTOPILOT", autopilot)
        return f"autopilot {number} is not supported: PX4 and ArduPilot are"
    name, flavours = make
    kind = _KINDS.get(vehicle_type)
    if kind is None:
        return f"{name} vehicle of type {_enum('MAV_TYPE', vehicle_type)} is not supported"
    return flavours[kind]


def _enum(name: str, value: int) -> str:
    entry = mav.enums[name].get(value)
    return f"{value} ({entry.name.removeprefix(name + '_').lower()})" if entry else str(value)
