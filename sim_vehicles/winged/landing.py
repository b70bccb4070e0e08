"""How aircraft come down, and give it up."""

from __future__ import annotations

from math import atan2, cos, hypot, inf, isfinite, nan, pi, sin
from typing import Final

from sim_vehicles.pilot import Pilot, Routine
from sim_vehicles.plans import Do, Vector
from sim_vehicles.winged.legs import WingedLegs, glide_run

_LOOK_S: Final = 0.1  # how often an aircraft that circles looks whether it points to the runway
_STRAIGHT_S: Final = 5.0  # of level flight before the glide
_ALIGNED_RAD: Final = 0.3
_ENTRY_M: Final = 30.0  # least height above the runway from which an approach begins


def legs_of(pilot: Pilot) -> WingedLegs:
    """The legs of a pilot of aircraft."""
    legs = pilot.legs
    assert isinstance(legs, WingedLegs)
    return legs


def land_at(pilot: Pilot, i: int, x: float, y: float, floor: float, yaw: float) -> Routine:
    """Circle down to the entry of the glide, turn in, glide, flare, roll out.

    Args:
        pilot: whose routine it is.
        i: the vehicle.
        x: of the place to come down at, ENU m.
        y: the same.
        floor: height of the ground there.
        yaw: course of the glide.
    """
    if pilot.status.landed[i]:
        circle_at(pilot, i, (nan, nan, nan))
        yield
        return
    legs = legs_of(pilot)
    parameters = pilot.parameters
    entry = max(parameters.get(i, "MIS_LND_ABRT_ALT"), _ENTRY_M)
    speed = parameters.get(i, "FW_AIRSPD_TRIM")
    run = glide_run(entry, parameters.get(i, "FW_LND_ANG")) + _STRAIGHT_S * speed
    ex, ey = x - run * cos(yaw), y - run * sin(yaw)
    size = max(abs(legs.circle(i)), 150.0)
    legs.set_circle(i, size)  # round a point to the left of the entry, which it passes on course
    legs.go(
        i, (ex - size * sin(yaw), ey + size * cos(yaw), floor + entry), nan, radius_m=1.3 * size
    )
    yield
    while not _lined_up(pilot, i, ex, ey, size, yaw):
        legs.pause(i, pilot.now_us + round(_LOOK_S * 1e6))
        yield
    legs.approach(i, x, y, floor, yaw)
    while not pilot.status.landed[i]:
        yield


def _lined_up(pilot: Pilot, i: int, ex: float, ey: float, size: float, yaw: float) -> bool:
    x, y, _ = pilot.place(i)
    off = (course(pilot, i) - yaw + pi) % (2 * pi) - pi
    return abs(off) < _ALIGNED_RAD and hypot(x - ex, y - ey) < 0.5 * size


def planned_landing(pilot: Pilot, i: int) -> int | None:
    """Number of the step of its mission at which the nearest landing begins; None: it has none."""
    x, y, _ = pilot.place(i)
    steps, nearest = pilot.plans[i].steps, (inf, -1)
    for number, step in enumerate(steps):
        placed = (s.position for s in steps[number + 1 :] if isfinite(s.position[0]))
        if step.do is Do.LANDING and (there := next(placed, None)) is not None:
            nearest = min(nearest, (hypot(there[0] - x, there[1] - y), number))
    return None if nearest[1] < 0 else nearest[1]


def go_around(pilot: Pilot, i: int) -> Routine:
    """Climb straight ahead from a landing, and loiter over where it was to end."""
    legs = legs_of(pilot)
    x, y, floor = legs.runway(i)
    top = max(pilot.place(i)[2], floor + pilot.parameters.get(i, "MIS_LND_ABRT_ALT"))
    legs.climb_out(i, top)
    yield
    legs.set_circle(i, nan)
    legs.go(i, (x, y, top), nan)
    yield


def circle_at(pilot: Pilot, i: int, position: Vector) -> None:
    """Loiter round a place; NaN parts of it are where it is."""
    here = pilot.place(i)
    x, y, z = (there if isfinite(there) else now for there, now in zip(position, here, strict=True))
    legs_of(pilot).go(i, (x, y, z), nan)


def course(pilot: Pilot, i: int) -> float:
    """Over ground, or where it looks."""
    vx, vy, _ = pilot.states.velocity[i].tolist()
    return atan2(vy, vx) if hypot(vx, vy) > 1.0 else pilot.yaw(i)
