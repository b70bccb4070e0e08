"""What arming checks, failsafes and routines see of the autopilots they belong to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol, TypeAlias

from sim_vehicles.dynamics.model import States
from sim_vehicles.legs import Legs
from sim_vehicles.modes import Mode, ModeSpec
from sim_vehicles.params import Parameters
from sim_vehicles.plans import Plan, Vector
from sim_vehicles.status import Status

Routine: TypeAlias = Iterator[None]
"""Starts a leg, yields until it is done, goes on."""


class Pilot(Protocol):
    """Autopilots of n vehicles; ``i`` is the row of one of them."""

    now_us: int
    states: States
    parameters: Parameters
    status: Status
    legs: Legs

    @property
    def modes(self) -> Mapping[Mode, ModeSpec]:
        """The modes they have."""
        ...

    @property
    def plans(self) -> Sequence[Plan]:
        """(n,) missions."""
        ...

    @property
    def rallies(self) -> Mapping[int, Sequence[Vector]]:
        """Rally points, ENU m, of those vehicles that have some."""
        ...

    def switch(self, i: int, mode: Mode) -> None:
        """Go to a mode without asking."""
        ...

    def stop_motors(self, i: int, text: str) -> None:
        """Disarm, wherever the vehicle is."""
        ...

    def say(self, i: int, severity: int, text: str) -> None:
        """Tell people something."""
        ...

    def place(self, i: int) -> Vector:
        """Position, ENU m."""
        ...

    def yaw(self, i: int) -> float:
        """Yaw, rad."""
        ...

    def altitude(self, z: float) -> float:
        """Height above sea level of ENU ``z``, about."""
        ...

    def charge(self, i: int) -> float:
        """Battery charge, 0..1."""
        ...

    def may_start(self, i: int) -> bool:
        """Whether a mission may leave the ground."""
        ...

    def has_setpoints(self, i: int) -> bool:
        """Whether setpoints come."""
        ...

    def hold_at(self, i: int, position: Vector, yaw_rad: float) -> None:
        """Switch to Hold, at a place (NaN: where it is)."""
        ...

    def take_goal(self, i: int) -> tuple[Vector, float] | None:
        """Where a reposition command wants it, once."""
        ...

    def take_asked_height(self, i: int) -> float:
        """The height (ENU m) that a take-off command named, once; else NaN."""
        ...
