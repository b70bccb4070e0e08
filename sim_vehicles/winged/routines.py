"""What aircraft do in each mode: routines as in ``sim_vehicles.routines``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import atan2, hypot, inf, isfinite, nan, pi
from typing import Final

from sim_vehicles.modes import Mode
from sim_vehicles.pilot import Pilot, Routine
from sim_vehicles.plans import Do, Step, Vector
from sim_vehicles.routines import (
    ROUTINES,
    STEPS,
    Make,
    StepRoutine,
    mission,
    take_off_height,
)
from sim_vehicles.winged.landing import circle_at, course, land_at, legs_of, planned_landing

_INFO: Final = 6
_LOOK_S: Final = 0.1  # how often an aircraft that circles looks how far it has come round


def take_off(pilot: Pilot, i: int) -> Routine:
    """Climb straight ahead to the height asked for, then loiter."""
    top = take_off_height(pilot, i)
    legs_of(pilot).climb_out(i, top)
    yield
    x, y, _ = pilot.place(i)
    pilot.hold_at(i, (x, y, top), nan)


def hold(pilot: Pilot, i: int) -> Routine:
    """Loiter where it is, or where a reposition command says."""
    goal = pilot.take_goal(i)
    if goal is None:
        legs_of(pilot).set_circle(i, nan)
    circle_at(pilot, i, (nan, nan, nan) if goal is None else goal[0])
    yield


def land(pilot: Pilot, i: int) -> Routine:
    """Come down to where it is now, on the course it has now."""
    x, y, _ = pilot.place(i)
    yield from land_at(pilot, i, x, y, float(pilot.states.ground[i]), course(pilot, i))


def return_home(pilot: Pilot, i: int) -> Routine:
    """Climb to the return height on the way home, go down, loiter there or land.

    RTL_TYPE other than 0 leads to the landing of the mission, where it has one.
    """
    parameters = pilot.parameters
    hx, hy, hz = pilot.status.home[i].tolist()
    if pilot.status.landed[i]:
        circle_at(pilot, i, (nan, nan, nan))
        yield
        return
    x, y, z = pilot.place(i)
    high = parameters.get(i, "RTL_RETURN_ALT")
    low = hz + min(parameters.get(i, "RTL_DESCEND_ALT"), high)
    near = hypot(x - hx, y - hy) <= parameters.get(i, "RTL_MIN_DIST")
    top = max(low if near else hz + high, z)
    altitude = pilot.altitude(top)
    pilot.say(
        i, _INFO, f"RTL: start return at {altitude:.0f} m ({top - hz:.0f} m above destination)"
    )
    legs = legs_of(pilot)
    legs.set_circle(i, -parameters.get(i, "RTL_LOITER_RAD"))
    landing = planned_landing(pilot, i) if parameters.get(i, "RTL_TYPE") > 0 else None
    if landing is not None:
        yield from _fly_landing(pilot, i, landing, top)
        return
    size = 1.5 * max(parameters.get(i, "RTL_LOITER_RAD"), 100.0)
    legs.go(i, (hx, hy, top), nan, radius_m=size)
    yield
    delay = parameters.get(i, "RTL_LAND_DELAY")
    pilot.say(i, _INFO, "RTL: loiter at destination" if delay < 0 else "RTL: land at destination")
    legs.go(i, (hx, hy, low), nan, radius_m=inf)
    yield
    if delay < 0.0:
        legs.go(i, (hx, hy, low), nan)
        yield
        return
    if delay > 0.0:
        legs.pause(i, pilot.now_us + round(delay * 1e6))
        yield
    yield from land_at(pilot, i, hx, hy, hz, float(pilot.status.home_yaw[i]))


def _fly_landing(pilot: Pilot, i: int, landing: int, top: float) -> Routine:
    """Go to the landing of the mission at a height, and fly its steps."""
    steps = pilot.plans[i].steps[landing + 1 :]
    x, y, z = next(step.position for step in steps if isfinite(step.position[0]))
    pilot.say(i, _INFO, "RTL: land at the landing of the mission")
    high = max(z, top) if isfinite(z) else top
    size = 1.5 * max(pilot.parameters.get(i, "RTL_LOITER_RAD"), 100.0)
    legs_of(pilot).go(i, (x, y, high), nan, radius_m=size)
    yield
    for number, step in enumerate(steps, landing + 1):
        pilot.plans[i].current = number
        if step.do is not Do.JUMP:
            yield from FLOWN[step.do](pilot, i, step)


def _step_take_off(pilot: Pilot, i: int, step: Step) -> Routine:
    z = pilot.place(i)[2]
    top = max(z, step.position[2]) if isfinite(step.position[2]) else z
    legs_of(pilot).climb_out(i, top)
    yield
    if isfinite(step.position[0]):
        yield from _step_go(pilot, i, step)
    elif _is_last(pilot, i):
        circle_at(pilot, i, (nan, nan, top))


def _step_go(pilot: Pilot, i: int, step: Step) -> Routine:
    yield from _off_the_ground(pilot, i)
    legs, here = legs_of(pilot), pilot.place(i)
    x, y, z = (
        there if isfinite(there) else now for there, now in zip(step.position, here, strict=True)
    )
    given = step.radius_m > 0  # NaN: it is not
    radius = step.radius_m if given else pilot.parameters.get(i, "NAV_ACC_RAD")
    legs.set_circle(i, step.circle_m)
    if step.pause_s > 0.0:  # to loiter there: on the circle it has arrived
        radius = max(radius, 1.3 * abs(legs.circle(i)))
    legs.line(i, _behind(pilot, i, here), (x, y, z), radius_m=radius)
    yield
    if step.pause_s > 0.0 or _is_last(pilot, i):
        legs.go(i, (x, y, z), nan)
    if step.pause_s > 0.0:
        yield from STEPS[Do.PAUSE](pilot, i, step)


def _step_circle(pilot: Pilot, i: int, step: Step) -> Routine:
    """Loiter until it has gone round so many times."""
    yield from _step_go(pilot, i, replace(step, pause_s=_LOOK_S))
    here, left = pilot.place(i), 2.0 * pi * step.rounds
    x, y = (to if isfinite(to) else now for to, now in zip(step.position[:2], here, strict=False))
    before = atan2(here[1] - y, here[0] - x)
    while left > 0.0:
        legs_of(pilot).pause(i, pilot.now_us + round(_LOOK_S * 1e6))
        yield
        now_x, now_y, _ = pilot.place(i)
        bearing = atan2(now_y - y, now_x - x)
        left -= abs((bearing - before + pi) % (2.0 * pi) - pi)
        before = bearing


def _behind(pilot: Pilot, i: int, here: Vector) -> Vector:
    """Where the line to the step begins: at the place before it in the plan, or here."""
    plan = pilot.plans[i]
    if plan.current == 0:
        return here
    before = plan.steps[plan.current - 1]
    placed = before.do in (Do.GO, Do.TAKE_OFF, Do.STAY) and isfinite(before.position[0])
    return before.position if placed else here


def _step_stay(pilot: Pilot, i: int, step: Step) -> Routine:
    yield from _off_the_ground(pilot, i)
    legs_of(pilot).set_circle(i, step.circle_m)
    circle_at(pilot, i, step.position)
    yield


def _step_land(pilot: Pilot, i: int, step: Step) -> Routine:
    if pilot.status.landed[i]:
        return
    x, y, _ = pilot.place(i)
    tx, ty, tz = step.position
    tx, ty = (tx, ty) if isfinite(tx) else (x, y)
    home = float(pilot.status.home[i, 2])
    floor = tz if isfinite(tz) else home
    far = hypot(tx - x, ty - y) > 1.0
    yaw = atan2(ty - y, tx - x) if far else course(pilot, i)
    yield from land_at(pilot, i, tx, ty, floor, yaw)


def _off_the_ground(pilot: Pilot, i: int) -> Routine:
    """A mission without a take-off item gets one."""
    if pilot.status.landed[i]:
        top = pilot.place(i)[2] + pilot.parameters.get(i, "MIS_TAKEOFF_ALT")
        legs_of(pilot).climb_out(i, top)
        yield


def _is_last(pilot: Pilot, i: int) -> bool:
    plan = pilot.plans[i]
    return plan.current == len(plan.steps) - 1


FLOWN: Final[Mapping[Do, StepRoutine]] = {
    **STEPS,
    Do.TAKE_OFF: _step_take_off,
    Do.GO: _step_go,
    Do.STAY: _step_stay,
    Do.CIRCLE: _step_circle,
    Do.LAND: _step_land,
}
"""How an aircraft flies each step of a mission."""

WINGED: Final[Mapping[Mode, Make]] = {
    **ROUTINES,
    Mode.TAKEOFF: take_off,
    Mode.HOLD: hold,
    Mode.MISSION: mission(FLOWN),
    Mode.RETURN: return_home,
    Mode.LAND: land,
}
"""What an aircraft does in each mode that flies by itself."""
