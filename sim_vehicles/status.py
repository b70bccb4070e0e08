"""What autopilots know of their vehicles, one a row, and what they tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from sim_vehicles.dynamics.model import F64, Bools
from sim_vehicles.modes import Mode

I64: TypeAlias = npt.NDArray[np.int64]
I8: TypeAlias = npt.NDArray[np.int8]

NEVER: Final = -(1 << 60)  # a time before any other
ALWAYS_LATER: Final = 1 << 60


@dataclass(frozen=True, slots=True)
class Said:
    """A text for people; severity 0 (emergency) .. 7 (debug)."""

    vehicle: int
    severity: int
    text: str


@dataclass(frozen=True, slots=True)
class Reached:
    """A mission step is done."""

    vehicle: int
    step: int


@dataclass(frozen=True, slots=True)
class Shown:
    """A message to be sent unasked, once."""

    vehicle: int
    message: str


Told: TypeAlias = Said | Reached | Shown


@dataclass(slots=True, eq=False)
class Status:
    """State of n autopilots; times are microseconds since the start."""

    mode: I8  # (n,) Mode
    before: I8  # (n,) Mode to show again after disarming from a passing one
    armed: Bools  # (n,)
    landed: Bools  # (n,) the land detector's word
    flown: Bools  # (n,) was in the air since arming
    started: Bools  # (n,) was told to begin its mission since arming
    failsafe: I8  # (n,) Action in force, 0: none
    battery_level: I8  # (n,) 0 good, 1 low, 2 critical, 3 emergency
    ready_us: I64  # (n,) position estimate good from here on
    armed_us: I64  # (n,) since when armed
    landed_us: I64  # (n,) since when landed
    setpoint_us: I64  # (n,) newest setpoint
    gcs_us: I64  # (n,) newest heartbeat of a ground station
    gcs_lost: Bools  # (n,)
    gps_lost: Bools  # (n,) the receiver has failed
    origin: F64  # (n, 3) ENU m, zero of the vehicle's local frame
    home: F64  # (n, 3) ENU m
    home_yaw: F64  # (n,) rad
    told: list[Told] = field(default_factory=list)

    @staticmethod
    def on_ground(starts: F64, yaw: F64, ready_us: Sequence[int], mode: Mode = Mode.HOLD) -> Status:
        """Disarmed in ``mode`` at ``starts`` (n, 3), ``yaw`` (n,)."""
        n = len(starts)
        never = np.full(n, NEVER, dtype=np.int64)
        off = np.zeros(n, dtype=np.bool_)
        modes = np.full(n, mode, dtype=np.int8)
        return Status(
            mode=modes,
            before=modes.copy(),
            armed=off,
            landed=np.ones(n, dtype=np.bool_),
            flown=off.copy(),
            started=off.copy(),
            failsafe=np.zeros(n, dtype=np.int8),
            battery_level=np.zeros(n, dtype=np.int8),
            ready_us=np.array(ready_us, dtype=np.int64),
            armed_us=never,
            landed_us=never.copy(),
            setpoint_us=never.copy(),
            gcs_us=never.copy(),
            gcs_lost=off.copy(),
            gps_lost=off.copy(),
            origin=np.array(starts, dtype=np.float64),
            home=np.array(starts, dtype=np.float64),
            home_yaw=np.array(yaw, dtype=np.float64),
        )
