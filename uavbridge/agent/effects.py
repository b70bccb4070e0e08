"""What goes into an agent's step, and what it wants done: plain values.

Only a runner carries effects out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

from msgspec import Struct

from planners.types import F64, Goal, Reading, Signal
from planners.types import Answer as Told
from uavbridge.agent.orders import Ack, Order
from uavbridge.bus.messages import Obstacle
from uavbridge.bus.wire import Beacon, Frame
from uavbridge.vehicle.api import Command, VehicleEvent, VehicleState


class Inputs(Struct, frozen=True, eq=False):
    """All that reached an agent since its last step."""

    t_us: int
    state: VehicleState
    events: tuple[VehicleEvent, ...] = ()
    frames: tuple[Frame, ...] = ()  # heard over the radio, by (sender, tick)
    beacons: tuple[Beacon, ...] = ()  # heard on the separation beacon, by sender
    readings: tuple[Reading, ...] = ()
    signals: tuple[Signal, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()  # in sight of the own detector
    answers: tuple[Told, ...] = ()  # to what the planner asked
    orders: tuple[Order, ...] = ()
    late_s: float = 0.0  # how much later than ``t_us`` this step is really made


class Do(Struct, frozen=True, eq=False):
    """Give the vehicle a command or a setpoint."""

    command: Command


class Publish(Struct, frozen=True, eq=False):
    """Send a frame over the emulated radio."""

    frame: Frame


class Shine(Struct, frozen=True, eq=False):
    """Send the separation beacon."""

    beacon: Beacon


@dataclass(frozen=True, slots=True)
class Tell:
    """Something people should know."""

    text: str
    failure: bool = False


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of an order."""

    ack: Ack


@dataclass(frozen=True, slots=True, eq=False)
class Decided:
    """The planner decided: what it had of the own state, what it wants, what it remembers.

    With the frames, readings, signals and obstacles that reached the agent before, enough to
    decide again.
    """

    tick: int
    position: F64  # (3,) ENU m
    velocity: F64  # (3,) m/s
    heading_rad: float
    goal: Goal
    memory: Any


Effect: TypeAlias = Do | Publish | Shine | Tell | Answer | Decided
