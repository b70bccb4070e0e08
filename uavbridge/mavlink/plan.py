"""Steps by which a command of the vehicle seam is carried out, whatever the autopilot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, TypeAlias

from sim_vehicles.codec import mav
from uavbridge.mavlink.commands import Order
from uavbridge.mavlink.parameters import Kind
from uavbridge.vehicle.api import Mode

_CUSTOM: Final = float(mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)


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


@dataclass(frozen=True, slots=True)
class ProvideLanding:
    """See to it that the autopilot's mission has a landing."""


Step: TypeAlias = Order | SetParameter | Lead | ProvideLanding


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


@dataclass(frozen=True, slots=True)
class Setting:
    """One parameter of the safety net.

    Attributes:
        names: (name, value in its unit) as autopilots have it, the usual one first.
        kind: how it is kept.
    """

    names: tuple[tuple[str, float], ...]
    kind: Kind = Kind.REAL32

    @classmethod
    def of(cls, name: str, value: float, kind: Kind = Kind.REAL32) -> Setting:
        """A parameter that has one name everywhere."""
        return cls(((name, value),), kind)


def set_mode(main: int, sub: int = 0, *, persistent: bool = False) -> Order:
    """The command that changes the flight mode; ``persistent``: asked again when refused."""
    params = (_CUSTOM, float(main), float(sub), 0.0, 0.0, 0.0, 0.0)
    return Order(mav.MAV_CMD_DO_SET_MODE, params, persistent=persistent)


def arming(arm: bool) -> Order:
    """The command that starts or stops the motors."""
    params = (float(arm), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Order(mav.MAV_CMD_COMPONENT_ARM_DISARM, params)
