"""What ground vehicles do otherwise than multirotors: legs on the surface, no take-off.

As a PX4 rover: a take-off ends at once in Hold, a landing stops and disarms, and a return
that has reached home counts as a landing.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, nan
from typing import Final

import numpy as np

from sim_vehicles.dynamics.model import States
from sim_vehicles.legs import FLIGHT, Legs
from sim_vehicles.modes import Mode
from sim_vehicles.params import Parameters
from sim_vehicles.pilot import Pilot, Routine
from sim_vehicles.plans import Do, Step
from sim_vehicles.routines import ROUTINES, STEPS, Make, StepRoutine, go, mission, stay
from sim_vehicles.status import Status

_INFO: Final = 6


class DrivenLegs(Legs):
    """Legs of vehicles that are always on the ground, and always may move when armed."""

    grounded = True

    def __init__(self, status: Status, states: States, parameters: Parameters) -> None:
        super().__init__(status, states, parameters)
        self._height = np.full(len(status.mode), inf)  # arrival is a matter of x and y
        self.gate[:] = FLIGHT

    def rest(self, i: int) -> None:
        super().rest(i)
        self.gate[i] = FLIGHT

    def touching(self, t_us: int) -> tuple[list[int], list[int]]:
        """A rover has "landed" unless it is armed, in Land, or at home again in Return."""
        status, column = self._status, self._parameters.column
        landed = ~status.armed | (status.mode == Mode.LAND)
        returning = status.mode == Mode.RETURN
        if returning.any():
            away = self._states.position - status.home
            near = np.hypot(away[:, 0], away[:, 1]) < column("NAV_ACC_RAD")
            landed |= returning & near & (column("RTL_LAND_DELAY") >= 0.0)
        off, down = status.landed & ~landed, ~status.landed & landed
        return off.nonzero()[0].tolist(), down.nonzero()[0].tolist()


def take_off(pilot: Pilot, i: int) -> Routine:
    """There is nothing to climb: hold."""
    pilot.take_asked_height(i)
    yield from ()
    pilot.hold_at(i, (nan, nan, nan), pilot.yaw(i))


def land(pilot: Pilot, i: int) -> Routine:
    """Stop; the land detector does the rest."""
    stay(pilot, i)
    yield


def return_home(pilot: Pilot, i: int) -> Routine:
    """Drive home in a straight line, and stop there."""
    pilot.say(i, _INFO, "RTL: start return")
    x, y, z = pilot.status.home[i].tolist()
    go(pilot, i, (x, y, z), nan, radius_m=None)
    yield


def _step_go(pilot: Pilot, i: int, step: Step) -> Routine:
    go(pilot, i, step.position, step.yaw_rad, radius_m=_radius(pilot, i, step))
    yield
    yield from STEPS[Do.PAUSE](pilot, i, step)


def _step_stay(pilot: Pilot, i: int, step: Step) -> Routine:
    go(pilot, i, step.position, step.yaw_rad, radius_m=None)
    yield


def _radius(pilot: Pilot, i: int, step: Step) -> float:
    given = step.radius_m > 0  # NaN: it is not
    return step.radius_m if given else pilot.parameters.get(i, "NAV_ACC_RAD")


_DRIVEN: Final[Mapping[Do, StepRoutine]] = {
    **STEPS,
    Do.TAKE_OFF: STEPS[Do.NOTHING],
    Do.GO: _step_go,
    Do.STAY: _step_stay,
    Do.LAND: _step_go,
}

DRIVING: Final[Mapping[Mode, Make]] = {
    **ROUTINES,
    Mode.TAKEOFF: take_off,
    Mode.MISSION: mission(_DRIVEN),
    Mode.RETURN: return_home,
    Mode.LAND: land,
}
"""What a rover does in each mode that moves by itself."""
