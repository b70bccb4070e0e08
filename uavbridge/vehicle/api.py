"""The vehicle seam: one vehicle as its agent sees it.

Positions are ENU metres in the mission frame (origin at the mission's home),
whatever the autopilot's own frame. Nothing here blocks: ``do`` asks, ``advance``
lets time pass and tells what happened.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Final, Literal, Protocol, TypeAlias

import numpy as np
from msgspec import Struct, field

from planners.types import F64

HIGHEST_M: Final = 10_000.0
VehicleKind: TypeAlias = Literal["multirotor", "rover", "plane"]


class Mode(Enum):
    """What the autopilot is doing, in words common to all autopilots."""

    UNKNOWN = "unknown"
    MANUAL = "manual"  # a pilot's mode of any kind
    HOLD = "hold"
    TAKEOFF = "takeoff"
    OFFBOARD = "offboard"  # follows our setpoints
    MISSION = "mission"
    RETURN = "return"
    LAND = "land"


class VehicleState(Struct, frozen=True, eq=False):
    """Newest knowledge of one vehicle."""

    t_us: int = 0  # mission time at which the newest position arrived
    position: F64 = field(default_factory=lambda: np.zeros(3))  # (3,) ENU m
    velocity: F64 = field(default_factory=lambda: np.zeros(3))  # (3,) m/s
    heading_rad: float = 0.0  # from east, counter-clockwise
    mode: Mode = Mode.UNKNOWN
    mode_text: str = ""  # the autopilot's own name of the mode
    armed: bool = False
    in_air: bool = False
    battery: float = float("nan")  # 0..1
    has_position: bool = False
    link_ok: bool = False  # heard within the link time-out
    waiting_for: tuple[str, ...] = ()  # why it can not arm yet; empty when ready
    kind: VehicleKind = "multirotor"


@dataclass(frozen=True, slots=True)
class Arm:
    """Start the motors."""


@dataclass(frozen=True, slots=True)
class Disarm:
    """Stop the motors on the ground."""


@dataclass(frozen=True, slots=True)
class TakeOff:
    """Climb to a height above home (m) and hold there; refused outside 0..HIGHEST_M."""

    height_m: float


@dataclass(frozen=True, slots=True)
class Follow:
    """Start to follow setpoints (PX4: offboard; ArduPilot: guided)."""


@dataclass(frozen=True, slots=True)
class HoldPosition:
    """Stay where it is, by the autopilot alone."""


@dataclass(frozen=True, slots=True)
class LandHere:
    """Descend and land, by the autopilot alone."""


@dataclass(frozen=True, slots=True)
class ReturnHome:
    """The autopilot's own return to launch."""


@dataclass(frozen=True, slots=True)
class Net:
    """The autopilot's own second safety net, should the bridge be no more.

    Heights are metres above the vehicle's home, which is the middle of the fence.
    """

    fence_radius_m: float
    fence_height_m: float
    return_height_m: float
    setpoint_loss_s: float = 2.0  # without setpoints for so long it holds
    link_loss_s: float = 10.0  # without our heartbeat for so long it returns
    take_off_m: float = 10.0  # height of its own take-offs, which the mission's need


@dataclass(frozen=True, slots=True)
class SetNet:
    """Have the autopilot take over a safety net; what was before is remembered."""

    net: Net


@dataclass(frozen=True, slots=True)
class RestoreNet:
    """Put the autopilot's own safety net back as it was before ``SetNet``."""


class SetVelocity(Struct, frozen=True, eq=False):
    """Setpoint: velocity (3,) ENU m/s, yaw kept where None."""

    velocity: F64
    yaw_rad: float | None = None


class SetPosition(Struct, frozen=True, eq=False):
    """Setpoint: position (3,) ENU m in the mission frame."""

    position: F64
    yaw_rad: float | None = None


Command: TypeAlias = (
    Arm
    | Disarm
    | TakeOff
    | Follow
    | HoldPosition
    | LandHere
    | ReturnHome
    | SetNet
    | RestoreNet
    | SetVelocity
    | SetPosition
)


@dataclass(frozen=True, slots=True)
class Done:
    """A command (not a setpoint) was accepted."""

    command: Command


@dataclass(frozen=True, slots=True)
class Refused:
    """A command was refused, or never answered."""

    command: Command
    reason: str


@dataclass(frozen=True, slots=True)
class Said:
    """A text of the autopilot (STATUSTEXT)."""

    severity: int  # 0 emergency .. 7 debug
    text: str


VehicleEvent: TypeAlias = Done | Refused | Said


class Vehicle(Protocol):
    """Drives one vehicle."""

    @property
    def state(self) -> VehicleState:
        """Newest knowledge; replaced as a whole by ``advance``."""
        ...

    def do(self, command: Command, t_us: int) -> None:
        """Ask for something at mission time ``t_us``; a later ``advance`` tells the result.

        A setpoint (SetVelocity, SetPosition) has no result. The newest one is repeated as the
        autopilot needs it, but not for longer than half a second of mission time without a new
        one: when the planner stops, so do the setpoints.
        """
        ...

    def advance(self, t_us: int) -> tuple[VehicleEvent, ...]:
        """Read what arrived, run timers up to ``t_us``, send what is due."""
        ...

    def close(self) -> None:
        """Let go of the link."""
        ...
