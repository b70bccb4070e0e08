"""What ArduPilot's modes do where PX4's do it otherwise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from math import atan2, cos, hypot, inf, nan, pi, radians, sin
from typing import Final, TypeAlias

from sim_vehicles.modes import Mode
from sim_vehicles.pilot import Pilot, Routine
from sim_vehicles.plans import Do, Step
from sim_vehicles.routines import (
    STEPS,
    Make,
    StepRoutine,
    go,
    hold,
    land,
    mission,
    refuge,
    stay,
    stopping_place,
)

Get: TypeAlias = Callable[[str], float]
"""A vehicle's parameters."""

_INFO: Final = 6
_LOWEST_CLIMB_M: Final = 2.5
_LOOK_S: Final = 0.2  # at whether a mission may start, or a turn is done
_TURN_US: Final = 30_000_000  # at most for a turn
_ALIGNED: Final = cos(radians(2.0))
_CORNERS: Final = 24  # of a circle


def return_home(pilot: Pilot, i: int) -> Routine:
    """Climb to RTL_ALT (or the cone's height), go home, wait, land or stay at RTL_ALT_FINAL."""
    get = pilot.parameters.get
    if pilot.status.landed[i]:
        stay(pilot, i)
        yield
        return
    hx, hy, hz = refuge(pilot, i, get(i, "RALLY_LIMIT_KM") * 1e3)
    x, y, z = stopping_place(pilot, i)
    top, slope = get(i, "RTL_ALT") / 100.0, get(i, "RTL_CONE_SLOPE")
    if slope >= 0.5:
        top = min(top, max(hypot(x - hx, y - hy) * slope, _LOWEST_CLIMB_M))
    top = max(top + hz, z + get(i, "RTL_CLIMB_MIN") / 100.0)
    speed = get(i, "RTL_SPEED") / 100.0
    pilot.legs.set_speed(i, speed if speed > 0 else nan)
    if top > z + 0.1:
        pilot.legs.go(i, (x, y, top), pilot.yaw(i), radius_m=inf)
        yield
    go(pilot, i, (hx, hy, top), nan, radius_m=get(i, "NAV_ACC_RAD"))
    yield
    go(pilot, i, (hx, hy, top), float(pilot.status.home_yaw[i]), radius_m=None)
    pilot.legs.pause(i, pilot.now_us + round(max(get(i, "RTL_LOIT_TIME"), 0.0) * 1e3))
    yield
    final = get(i, "RTL_ALT_FINAL") / 100.0
    yaw = float(pilot.status.home_yaw[i])
    if final > 0:
        pilot.legs.go(i, (hx, hy, hz + final), yaw)
    else:
        pilot.legs.descend(i, hx, hy, yaw)
    yield


def drive_home(pilot: Pilot, i: int) -> Routine:
    """Straight home, and stop."""
    hx, hy, hz = refuge(pilot, i, pilot.parameters.get(i, "RALLY_LIMIT_KM") * 1e3)
    speed = pilot.parameters.get(i, "RTL_SPEED")
    pilot.legs.set_speed(i, speed if speed > 0 else nan)
    go(pilot, i, (hx, hy, hz), nan, radius_m=pilot.parameters.get(i, "NAV_ACC_RAD"))
    yield
    pilot.say(i, _INFO, "Reached destination")
    yield


def _take_off(pilot: Pilot, i: int, step: Step) -> Routine:
    """Straight up, once somebody has said so."""
    while pilot.status.landed[i] and not pilot.may_start(i):
        pilot.legs.pause(i, pilot.now_us + round(_LOOK_S * 1e6))
        yield
    x, y, z = pilot.place(i)
    top = max(z, step.position[2]) if step.position[2] == step.position[2] else z
    pilot.legs.go(i, (x, y, top), pilot.yaw(i), radius_m=inf, climb=bool(pilot.status.landed[i]))
    yield


def _go(pilot: Pilot, i: int, step: Step) -> Routine:
    radius = step.radius_m if step.radius_m > 0 else pilot.parameters.get(i, "NAV_ACC_RAD")
    go(pilot, i, step.position, step.yaw_rad, radius_m=radius)
    yield
    yield from STEPS[Do.PAUSE](pilot, i, step)


def _stay(pilot: Pilot, i: int, step: Step) -> Routine:
    go(pilot, i, step.position, step.yaw_rad, radius_m=None)
    yield


def _circling(radius: Callable[[Get], float], speed: Callable[[Get, float], float]) -> StepRoutine:
    """Makes LOITER_TURNS: to the edge of a circle, then round it.

    Args:
        radius: metres, where the item does not say.
        speed: m/s on a circle of that many metres; NaN: as always.
    """

    def circle(pilot: Pilot, i: int, step: Step) -> Routine:
        here, get = pilot.place(i), partial(pilot.parameters.get, i)
        x, y, z = (to if to == to else now for to, now in zip(step.position, here, strict=True))
        size = max(abs(step.circle_m) if step.circle_m == step.circle_m else radius(get), 1.0)
        begin = atan2(here[1] - y, here[0] - x)
        corner_rad = 2.0 * pi / _CORNERS if step.circle_m > 0.0 else -2.0 * pi / _CORNERS
        last = round(step.rounds * _CORNERS)
        for corner in range(last + 1):
            angle = begin + corner * corner_rad
            if corner == 1:
                pilot.legs.set_speed(i, speed(get, size))
            there = x + size * cos(angle), y + size * sin(angle), z
            near = get("NAV_ACC_RAD") if corner in (0, last) else abs(corner_rad) * size
            yaw = nan if pilot.legs.grounded else (angle + pi) % (2.0 * pi)  # to the centre
            go(pilot, i, there, yaw, radius_m=near)
            yield
        pilot.legs.set_speed(i, nan)

    return circle


def _turn(pilot: Pilot, i: int, step: Step) -> Routine:
    """Stay, and look where it is told to, for as long as that takes."""
    x, y, z = pilot.place(i)
    yaw = pilot.yaw(i) + step.yaw_rad if step.relative else step.yaw_rad
    if yaw != yaw:
        return
    if not pilot.legs.has_place(i):
        pilot.legs.go(i, (x, y, z), yaw)
    pilot.legs.turn(i, yaw)
    until_us = pilot.now_us + _TURN_US
    while pilot.now_us < until_us and cos(pilot.yaw(i) - yaw) < _ALIGNED:
        pilot.legs.pause(i, pilot.now_us + round(_LOOK_S * 1e6))
        yield


def _within(make: Make) -> StepRoutine:
    """A mode's routine as a step, until it has landed or has nothing more to do."""

    def step_routine(pilot: Pilot, i: int, step: Step) -> Routine:
        yield from make(pilot, i)
        while not pilot.status.landed[i]:
            yield

    return step_routine


def _told(name: str, fly: StepRoutine) -> StepRoutine:
    """A step with the texts that go with it."""

    def routine(pilot: Pilot, i: int, step: Step) -> Routine:
        number = pilot.plans[i].current
        pilot.say(i, _INFO, f"Mission: {number} {name}")
        yield from fly(pilot, i, step)
        if name == "WP":
            pilot.say(i, _INFO, f"Reached command #{number}")

    return routine


_NAMES: Final[Mapping[Do, str]] = {
    Do.TAKE_OFF: "Takeoff",
    Do.GO: "WP",
    Do.STAY: "LoitUnlim",
    Do.CIRCLE: "LoitTurns",
    Do.TURN: "CondYaw",
    Do.LAND: "Land",
    Do.RETURN: "RTL",
    Do.SPEED: "ChangeSpeed",
    Do.PAUSE: "Delay",
}


def all_told(steps: Mapping[Do, StepRoutine]) -> Mapping[Do, StepRoutine]:
    """Steps with the texts that go with them."""
    return {do: _told(_NAMES[do], fly) if do in _NAMES else fly for do, fly in steps.items()}


_COPTER_STEPS: Final[Mapping[Do, StepRoutine]] = {
    **STEPS,
    Do.TAKE_OFF: _take_off,
    Do.GO: _go,
    Do.STAY: _stay,
    Do.CIRCLE: _circling(
        lambda get: get("CIRCLE_RADIUS") / 100.0,
        lambda get, size: radians(max(abs(get("CIRCLE_RATE")), 1.0)) * size,
    ),
    Do.TURN: _turn,
    Do.RETURN: _within(return_home),
}
_ROVER_STEPS: Final[Mapping[Do, StepRoutine]] = {
    **STEPS,
    Do.TAKE_OFF: STEPS[Do.NOTHING],
    Do.GO: _go,
    Do.STAY: _stay,
    Do.CIRCLE: _circling(
        lambda get: get("CIRC_RADIUS"), lambda get, _size: get("CIRC_SPEED") or nan
    ),
    Do.LAND: _go,
    Do.RETURN: lambda pilot, i, step: drive_home(pilot, i),
}
_HELD: Final[Mapping[Mode, Make]] = {
    mode: hold for mode in (Mode.MANUAL, Mode.ALTITUDE, Mode.POSITION, Mode.HOLD, Mode.BRAKE)
}

COPTER: Final[Mapping[Mode, Make]] = {
    **_HELD,
    Mode.MISSION: mission(all_told(_COPTER_STEPS), ending=""),
    Mode.RETURN: return_home,
    Mode.LAND: land,
}
"""What ArduCopter does by itself; in Guided it does what it is told."""

ROVER: Final[Mapping[Mode, Make]] = {
    **_HELD,
    Mode.MISSION: mission(all_told(_ROVER_STEPS), ending="Mission Complete"),
    Mode.RETURN: drive_home,
}
"""What ArduRover does by itself."""
