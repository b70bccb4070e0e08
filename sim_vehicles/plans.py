"""A mission as an autopilot flies it: steps in the fleet's frame."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from math import nan
from typing import TypeAlias

Vector: TypeAlias = tuple[float, float, float]
NOWHERE: Vector = (nan, nan, nan)


class Do(Enum):
    """What a step asks for."""

    TAKE_OFF = auto()
    GO = auto()  # through a place, after a pause there
    STAY = auto()  # at a place, until told otherwise
    CIRCLE = auto()  # round a place, so many times
    TURN = auto()  # to a heading, on the spot
    LAND = auto()
    RETURN = auto()
    SPEED = auto()  # from here on
    JUMP = auto()
    PAUSE = auto()  # where it is
    NOTHING = auto()  # accepted and passed over
    LANDING = auto()  # what follows is a landing; passed over, too
    HOME = auto()  # the first of some autopilots' missions: no step at all


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a plan; what it does not use is left as it is here."""

    do: Do
    position: Vector = NOWHERE  # ENU m; NaN: where the vehicle is
    yaw_rad: float = nan  # NaN: towards the place
    radius_m: float = nan  # accepted distance; NaN: the parameter's
    circle_m: float = nan  # of a loiter, positive counter-clockwise; NaN: the parameter's
    pause_s: float = 0.0
    rounds: float = 0.0  # of a circle
    relative: bool = False  # the yaw is by how much to turn
    speed_m_s: float = nan
    jump_to: int = 0
    repeats: int = 0  # of a jump; below 0: without end


@dataclass(slots=True)
class Plan:
    """A vehicle's mission and how far it got."""

    steps: tuple[Step, ...] = ()
    current: int = 0
    finished: bool = False
