"""How vehicles of one kind move while they follow our setpoints: the seam of ``Flight``."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from planners.types import Setpoint
from uavbridge.agent.handling import Handling
from uavbridge.agent.phases import Phase
from uavbridge.safety.filter import Traffic, Vector

STILL: Vector = (0.0, 0.0, 0.0)


class Leg(NamedTuple):
    """The velocity wanted now (ENU m/s), and the phase that follows where this one is done."""

    velocity: Vector
    after: Phase | None = None


class Course(Protocol):
    """Steers one vehicle."""

    drives: bool
    """It stays on the ground."""

    home: Vector
    """Where it started, ENU m."""

    handling: Handling
    """How closely its kind can be brought to a place."""

    trouble: str
    """Why it cannot come home; empty: it can."""

    def stay(self, at: Vector) -> None:
        """Where to stand still on order; NaN as height: the present one."""
        ...

    def steer(
        self,
        phase: Phase,
        position: Vector,
        t_us: int,
        setpoint: Setpoint | None,
        traffic: list[Traffic],
    ) -> Leg:
        """One control tick in one of the phases FOLLOWING.

        Args:
            phase: the present one.
            position: own, ENU m.
            t_us: mission time.
            setpoint: the planner's newest, None before its first.
            traffic: the others by their separation beacons.
        """
        ...
