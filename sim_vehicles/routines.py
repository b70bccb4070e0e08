"""What each mode does, as routines: a routine starts a leg, yields until it is done, goes on.

A routine runs only when its vehicle's leg or pause ends, so that a fleet in the middle of
its legs costs nothing here. A routine that is not resumed is simply dropped.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import atan2, hypot, inf, isfinite, isnan, nan, radians, tan
from typing import Final, TypeAlias

from sim_vehicles.modes import Mode
from sim_vehicles.pilot import Pilot, Routine
from sim_vehicles.plans import Do, Step, Vector
from sim_vehicles.status import Reached

Make: TypeAlias = Callable[[Pilot, int], Routine]
"""Makes the routine of a mode for one vehicle."""
StepRoutine: TypeAlias = Callable[[Pilot, int, Step], Routine]
"""The same for a step of a mission."""

_NEAR: Final = 1.5  # m: nearer targets are not turned towards
_INFO: Final = 6
_WARNING: Final = 4


def take_off_height(pilot: Pilot, i: int) -> float:
    """The height (ENU m) to climb to, and the words that go with it."""
    default = pilot.parameters.get(i, "MIS_TAKEOFF_ALT")
    asked = pilot.take_asked_height(i)
    lowest = float(pilot.status.home[i, 2]) + default
    if isnan(asked):
        pilot.say(i, _INFO, f"Using default takeoff altitude: {default:.1f} m")
    elif asked < lowest:
        pilot.say(i, _WARNING, f"Using minimum takeoff altitude: {default:.1f} m")
    return max(lowest if isnan(asked) else max(asked, lowest), pilot.place(i)[2])


def take_off(pilot: Pilot, i: int) -> Routine:
    """Climb to the height asked for, then hold."""
    x, y, _ = pilot.place(i)
    top = take_off_height(pilot, i)
    yaw = pilot.yaw(i)
    pilot.legs.go(i, (x, y, top), yaw, radius_m=inf, climb=bool(pilot.status.landed[i]))
    yield
    pilot.hold_at(i, (x, y, top), yaw)


def hold(pilot: Pilot, i: int) -> Routine:
    """Brake and stay; go first where a reposition command says."""
    goal = pilot.take_goal(i)
    if goal is None:
        stay(pilot, i)
    else:
        position, yaw = goal
        go(pilot, i, position, yaw, radius_m=None)
    yield


def land(pilot: Pilot, i: int) -> Routine:
    """Go down where it is; without a position estimate too."""
    x, y, _ = stopping_place(pilot, i)
    pilot.legs.descend(i, x, y, pilot.yaw(i))
    yield


def return_home(pilot: Pilot, i: int) -> Routine:
    """Climb to the return height, fly home, go down, land (PX4's RTL_TYPE 0)."""
    parameters = pilot.parameters
    hx, hy, hz = refuge(pilot, i)
    if pilot.status.landed[i]:
        stay(pilot, i)
        yield
        return
    x, y, z = stopping_place(pilot, i)
    top = max(_return_height(pilot, i, hypot(x - hx, y - hy)) + hz, z)
    altitude = pilot.altitude(top)
    pilot.say(
        i, _INFO, f"RTL: start return at {altitude:.0f} m ({top - hz:.0f} m above destination)"
    )
    if top > z + parameters.get(i, "NAV_MC_ALT_RAD"):
        pilot.legs.go(i, (x, y, top), pilot.yaw(i), radius_m=inf)
        yield
    go(pilot, i, (hx, hy, top), nan, radius_m=parameters.get(i, "NAV_ACC_RAD"))
    yield
    pilot.say(i, _INFO, "RTL: land at destination")
    low = hz + parameters.get(i, "RTL_DESCEND_ALT")
    yaw = float(pilot.status.home_yaw[i])
    delay = parameters.get(i, "RTL_LAND_DELAY")
    if delay != 0.0 and top > low:
        pilot.legs.go(i, (hx, hy, low), yaw, radius_m=inf)
        yield
    if delay < 0.0:
        return
    if delay > 0.0:
        pilot.legs.pause(i, pilot.now_us + round(delay * 1e6))
        yield
    pilot.legs.descend(i, hx, hy, yaw)
    yield


def refuge(pilot: Pilot, i: int, farthest_m: float = inf) -> Vector:
    """Where a return leads to: home, or a rally point that is nearer, within ``farthest_m``."""
    x, y, _ = pilot.place(i)
    hx, hy, hz = pilot.status.home[i].tolist()
    best, least = (hx, hy, hz), hypot(hx - x, hy - y)
    for point in pilot.rallies.get(i, ()):
        away = hypot(point[0] - x, point[1] - y)
        if away < min(least, farthest_m):
            best, least = (point[0], point[1], hz), away
    return best


def _return_height(pilot: Pilot, i: int, distance_m: float) -> float:
    """Metres above home to return at: lower inside a cone about home (RTL_CONE_ANG)."""
    parameters = pilot.parameters
    full = parameters.get(i, "RTL_RETURN_ALT")
    half_angle = parameters.get(i, "RTL_CONE_ANG")
    lowest = min(parameters.get(i, "RTL_DESCEND_ALT"), full)
    if distance_m <= parameters.get(i, "RTL_MIN_DIST"):
        return lowest if half_angle > 0 else full
    if not 0 < half_angle < 90:
        return full if half_angle <= 0 else lowest
    return min(max(distance_m / tan(radians(half_angle)), lowest), full)


def mission(
    steps: Mapping[Do, StepRoutine],
    *,
    ending: str = "Mission finished, {}",
    then: Mode | None = None,
) -> Make:
    """Makes the routine of Mission mode of how each step is flown.

    Args:
        steps: the routine of each.
        ending: what is said in the end; "{}": landed or loitering.
        then: mode to go on in; None: it stays where it is.
    """

    def fly_plan(pilot: Pilot, i: int) -> Routine:
        yield from _fly_plan(pilot, i, steps)
        if ending:
            place = "landed" if pilot.status.landed[i] else "loitering"
            pilot.say(i, _INFO, ending.format(place))
        if then is not None and not pilot.status.landed[i]:
            pilot.switch(i, then)
        elif not pilot.legs.has_place(i):
            stay(pilot, i)
        yield

    return fly_plan


def _fly_plan(pilot: Pilot, i: int, steps: Mapping[Do, StepRoutine]) -> Routine:
    """Fly the mission from its current step on."""
    plan = pilot.plans[i]
    jumped: dict[int, int] = {}
    idle = 0  # steps since the last that took time: a loop of jumps must not hang
    while plan.current < len(plan.steps) and idle <= len(plan.steps):
        step, number = plan.steps[plan.current], plan.current
        idle += 1
        if step.do is Do.HOME:
            plan.current += 1
            continue
        if step.do is Do.JUMP:
            count = jumped.get(number, 0)
            again = step.repeats < 0 or count < step.repeats
            jumped[number] = count + 1 if again else 0
            plan.current = step.jump_to if again else number + 1
            continue
        for _ in steps[step.do](pilot, i, step):
            idle = 0
            yield
        if plan.current != number:  # set from outside meanwhile
            continue
        pilot.status.told.append(Reached(i, number))
        plan.current += 1
    plan.finished = True
    plan.current = max(len(plan.steps) - 1, 0)


def _step_take_off(pilot: Pilot, i: int, step: Step) -> Routine:
    x, y, z = pilot.place(i)
    top = max(z, step.position[2]) if isfinite(step.position[2]) else z
    pilot.legs.go(i, (x, y, top), pilot.yaw(i), radius_m=inf, climb=bool(pilot.status.landed[i]))
    yield
    yield from _step_go(pilot, i, step)


def _step_go(pilot: Pilot, i: int, step: Step) -> Routine:
    yield from _off_the_ground(pilot, i)
    radius = step.radius_m
    if not isfinite(radius) or radius <= 0:
        radius = pilot.parameters.get(i, "NAV_ACC_RAD")
    go(pilot, i, step.position, step.yaw_rad, radius_m=radius)
    yield
    yield from _pause(pilot, i, step)


def _step_stay(pilot: Pilot, i: int, step: Step) -> Routine:
    yield from _off_the_ground(pilot, i)
    go(pilot, i, step.position, step.yaw_rad, radius_m=None)
    yield


def _step_land(pilot: Pilot, i: int, step: Step) -> Routine:
    if pilot.status.landed[i]:
        return
    x, y, z = pilot.place(i)
    tx, ty, _ = step.position
    if isfinite(tx) and hypot(tx - x, ty - y) > pilot.parameters.get(i, "NAV_ACC_RAD"):
        go(pilot, i, (tx, ty, z), nan, radius_m=pilot.parameters.get(i, "NAV_ACC_RAD"))
        yield
    x, y, _ = pilot.place(i)
    pilot.legs.descend(i, tx if isfinite(tx) else x, ty if isfinite(ty) else y, pilot.yaw(i))
    while not pilot.status.landed[i]:
        yield


def _step_return(pilot: Pilot, i: int, step: Step) -> Routine:
    pilot.plans[i].finished = True
    pilot.switch(i, Mode.RETURN)
    yield


def _step_speed(pilot: Pilot, i: int, step: Step) -> Routine:
    pilot.legs.set_speed(i, step.speed_m_s)
    yield from ()


def _pause(pilot: Pilot, i: int, step: Step) -> Routine:
    if step.pause_s > 0.0:
        pilot.legs.pause(i, pilot.now_us + round(min(step.pause_s, 1e9) * 1e6))
        yield


def _nothing(pilot: Pilot, i: int, step: Step) -> Routine:
    yield from ()


STEPS: Final[Mapping[Do, StepRoutine]] = {
    Do.TAKE_OFF: _step_take_off,
    Do.GO: _step_go,
    Do.STAY: _step_stay,
    Do.LAND: _step_land,
    Do.RETURN: _step_return,
    Do.SPEED: _step_speed,
    Do.PAUSE: _pause,
    Do.NOTHING: _nothing,
    Do.TURN: _nothing,
    Do.LANDING: _nothing,
}

ROUTINES: Final[Mapping[Mode, Make]] = {
    Mode.TAKEOFF: take_off,
    Mode.HOLD: hold,
    Mode.MISSION: mission(STEPS),
    Mode.RETURN: return_home,
    Mode.LAND: land,
}


def go(pilot: Pilot, i: int, position: Vector, yaw_rad: float, *, radius_m: float | None) -> None:
    """Fly to a place; NaN parts of it stay as they are, and it turns towards the place."""
    here = pilot.place(i)
    x, y, z = (there if isfinite(there) else now for there, now in zip(position, here, strict=True))
    if not isfinite(yaw_rad):
        east, north = x - here[0], y - here[1]
        turns = hypot(east, north) > _NEAR and pilot.parameters.get(i, "MPC_YAW_MODE") == 0
        yaw_rad = atan2(north, east) if turns else pilot.yaw(i)
    pilot.legs.go(i, (x, y, z), yaw_rad, radius_m=radius_m)


def stay(pilot: Pilot, i: int) -> None:
    """Brake, and stay where that ends."""
    pilot.legs.go(i, stopping_place(pilot, i), pilot.yaw(i))


def stopping_place(pilot: Pilot, i: int) -> Vector:
    """Where it comes to rest if it brakes now."""
    x, y, z = pilot.place(i)
    vx, vy, vz = pilot.states.velocity[i].tolist()
    run = hypot(vx, vy) / (2.0 * pilot.parameters.get(i, "MPC_ACC_HOR"))
    upright = pilot.parameters.get(i, "MPC_ACC_UP_MAX" if vz < 0 else "MPC_ACC_DOWN_MAX")
    return x + vx * run, y + vy * run, z + vz * abs(vz) / (2.0 * upright)


def _off_the_ground(pilot: Pilot, i: int) -> Routine:
    """A mission without a take-off item gets one."""
    if pilot.status.landed[i]:
        x, y, z = pilot.place(i)
        top = z + pilot.parameters.get(i, "MIS_TAKEOFF_ALT")
        pilot.legs.go(i, (x, y, top), pilot.yaw(i), radius_m=inf, climb=True)
        yield
