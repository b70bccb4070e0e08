"""What one kind of vehicle is under one make of autopilot, as data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from sim_vehicles.dynamics.model import MakeModel, States
from sim_vehicles.flavour import Flavour
from sim_vehicles.legs import Legs
from sim_vehicles.modes import Mode, ModeSpec
from sim_vehicles.params import Derive, Parameter, Parameters
from sim_vehicles.pilot import Pilot, Routine
from sim_vehicles.px4_parameters import HIDDEN
from sim_vehicles.status import Status

MakeLegs: TypeAlias = Callable[[Status, States, Parameters], Legs]


@dataclass(frozen=True, slots=True, eq=False)
class Craft:
    """A kind of vehicle with its autopilot.

    Attributes:
        kind: what it is: "multirotor", "rover" or "plane".
        autopilot: the make: "px4" or "ardupilot".
        mav_type: MAV_TYPE of its heartbeat.
        flavour: how it says things.
        models: its dynamics by name; the first is the usual one.
        modes: those it has.
        routines: what it does in them by itself; in the others it follows setpoints.
        legs: how it flies, or drives, from place to place.
        parameters: the ones that clients see.
        derive: what they mean in the names that autopilots go by.
        hidden: those names.
        start_mode: the mode it is in when switched on.
        ready_s: when its position estimate is good, after that; between two times.
    """

    kind: str
    autopilot: str
    mav_type: int
    flavour: Flavour
    models: Mapping[str, MakeModel]
    modes: Mapping[Mode, ModeSpec]
    routines: Mapping[Mode, Callable[[Pilot, int], Routine]]
    parameters: Sequence[Parameter]
    derive: Derive | None = None
    hidden: Sequence[Parameter] = HIDDEN
    legs: MakeLegs = Legs
    start_mode: Mode = Mode.HOLD
    ready_s: tuple[float, float] = (2.0, 4.5)
