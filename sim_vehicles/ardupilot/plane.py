"""ArduPlane: it loiters where others hover, and takes off in a mode of its own."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, degrees, hypot, inf, isfinite, nan, pi, radians, sin
from typing import Final

import numpy as np

from sim_vehicles.ardupilot.failsafe import PlaneFailsafes
from sim_vehicles.ardupilot.pilot import ArduPilot
from sim_vehicles.ardupilot.routines import all_told
from sim_vehicles.arming import Refusal
from sim_vehicles.dynamics.plane import PlaneLimits
from sim_vehicles.failsafe import Failsafes
from sim_vehicles.legs import Asked, Tilt
from sim_vehicles.modes import Mode
from sim_vehicles.pilot import Pilot, Routine
from sim_vehicles.plans import Do, Step
from sim_vehicles.px4_parameters import HIDDEN as _HIDDEN
from sim_vehicles.routines import Make, mission, refuge
from sim_vehicles.winged import PX4
from sim_vehicles.winged.landing import legs_of, planned_landing
from sim_vehicles.winged.routines import FLOWN

_WARNING, _INFO = 4, 6
_AUTOLAND_AFTER, _AUTOLAND_AT_ONCE = 1, 2  # of RTL_AUTOLAND
_TILTED_US: Final = 3_000_000
_AHEAD_M: Final = 1e4  # as far as a course is held
_NAMES: Final = frozenset(each.name for each in PX4)
HIDDEN: Final = (*PX4, *(each for each in _HIDDEN if each.name not in _NAMES))
LIMITS: Final = PlaneLimits(
    slowest_m_s=18.0,  # it stalls at 15, whatever AIRSPEED_MIN says
    trim_m_s=22.0,
    fastest_m_s=30.0,
    bank_rad=radians(45.0),
    rotate_m_s=17.0,
)
"""Of the aircraft that ArduPilot simulates, near enough."""


class ArduPlane(ArduPilot):
    """Aircraft under ArduPilot."""

    def _watch(self) -> Failsafes:
        super()._watch()
        self._ways: dict[int, tuple[float, float, float, float, float]] = {}
        self._speeds: dict[int, float] = {}  # asked for in Guided
        self._tilted_us: dict[int, int] = {}  # when an attitude came last
        return PlaneFailsafes(self)

    @property
    def _arming(self) -> str:
        return "Throttle armed"

    @property
    def _disarming(self) -> str:
        return "Throttle disarmed"

    def take_off(self, i: int, height_m: float = nan) -> Refusal | None:
        """Only by the mode of that name, or in a mission."""
        return Refusal("")

    def follow(self, i: int, asked: Asked) -> None:
        """A place to fly round, or a height alone; velocities are passed over."""
        if self.status.landed[i]:
            return
        if isfinite(asked[0]):
            self._tilted_us.pop(i, None)
            super().follow(i, (*asked[:3], nan, nan, nan, nan, nan))
            self._targets[i] = asked[:3]
            self._ways[i] = (*asked[:3], nan, nan)
        elif isfinite(asked[2]):
            self.change_height(i, asked[2])

    def tilt(self, i: int, asked: Tilt) -> None:
        """Guided: the angles and the throttle that are named, for three seconds."""
        if self._guided(i):
            self.legs.tilt(i, asked)
            self._tilted_us[i] = self.now_us

    def tick(self, t_us: int) -> None:
        super().tick(t_us)
        for i in [i for i, since in self._tilted_us.items() if t_us - since > _TILTED_US]:
            self._go_on(i, self._ways.get(i, (*self.place(i), nan, nan)))

    def change_height(self, i: int, z: float) -> Refusal | None:
        """Guided: the same place, or the same way, at another height (ENU m)."""
        if not self._guided(i):
            return Refusal("")
        x, y, _, vx, vy = self._ways.get(i, (*self.place(i), nan, nan))
        self._go_on(i, (x, y, z, vx, vy))
        return None

    def change_heading(self, i: int, yaw_rad: float) -> Refusal | None:
        """Guided: straight on over ground in a direction, at the height asked for before."""
        if not self._guided(i):
            return Refusal("")
        height = self._ways.get(i, (*self.place(i), nan, nan))[2]
        speed = self._speeds.get(i, self.parameters.get(i, "MPC_XY_CRUISE"))
        self._targets.pop(i, None)
        self._go_on(i, (nan, nan, height, speed * cos(yaw_rad), speed * sin(yaw_rad)))
        return None

    def change_airspeed(self, i: int, speed_m_s: float) -> Refusal | None:
        """Guided: another airspeed."""
        if not self._guided(i):
            return Refusal("")
        self.legs.set_speed(i, speed_m_s)
        self._speeds[i] = speed_m_s
        x, y, z, vx, vy = self._ways.get(i, (*self.place(i), nan, nan))
        if isfinite(vx):
            scale = speed_m_s / max(hypot(vx, vy), 1e-6)
            self._go_on(i, (x, y, z, vx * scale, vy * scale))
        return None

    def start_landing(self, i: int) -> Refusal | None:
        """Go on with the mission at its landing, the nearest of several."""
        number = planned_landing(self, i)
        refusal = Refusal("") if number is None else self.change_mode(i, Mode.MISSION)
        if number is None or refusal is not None:
            self.say(i, _WARNING, "Unable to start landing sequence")
            return refusal
        self.say(i, _INFO, "Landing sequence start")
        self.set_current(i, number)
        return None

    def why_not_arm(self, i: int) -> str | None:
        reason = super().why_not_arm(i)
        unused = not self.parameters.get(i, "RTL_AUTOLAND") and planned_landing(self, i) is not None
        return "DO_LAND_START set and RTL_AUTOLAND disabled" if unused and not reason else reason

    def _go_on(self, i: int, way: tuple[float, float, float, float, float]) -> None:
        """Place and velocity over ground, NaN where there is none, at a height."""
        self._ways[i] = way
        self._tilted_us.pop(i, None)
        self.legs.start_following(i, (*way, nan, nan, nan))

    def switch(self, i: int, mode: Mode) -> None:
        self._ways.pop(i, None)
        self._tilted_us.pop(i, None)
        self._speeds.pop(i, None)
        super().switch(i, mode)

    def _guided(self, i: int) -> bool:
        flies = self.status.armed[i] and not self.status.landed[i]
        return bool(flies and self.status.mode[i] == Mode.OFFBOARD)

    def _why_not_change(self, i: int, mode: Mode) -> str | None:
        if not self.status.armed[i]:
            return None
        if self.modes[mode].needs_position and self.now_us < self.status.ready_us[i]:
            return "requires position"
        return "init failed" if mode is Mode.MISSION and len(self.plans[i].steps) < 2 else None

    def _may_arm_in_auto(self, i: int) -> bool:
        return True

    def may_start(self, i: int) -> bool:
        return True

    def _towards(self, i: int, asked: Asked) -> float:
        return nan

    def _near_m(self, i: int) -> float:
        return 1.5 * abs(self.parameters.get(i, "NAV_LOITER_RAD"))

    def _disarm_late(self, t_us: int) -> None:
        status = self.status
        idle = status.armed & status.landed & status.flown
        if not idle.any():
            return
        wait_s = self.parameters.column("LAND_DISARMDELAY")
        idle &= (wait_s > 0) & (t_us - status.landed_us >= wait_s * 1e6)
        for i in np.flatnonzero(idle).tolist():
            self.stop_motors(i, self._disarming)


def _take_off(pilot: Pilot, i: int) -> Routine:
    """Climb straight ahead to TKOFF_ALT, then round the point at TKOFF_DIST."""
    legs, (x, y, z) = legs_of(pilot), pilot.place(i)
    yaw, height = pilot.yaw(i), pilot.parameters.get(i, "TKOFF_ALT")
    distance = pilot.parameters.get(i, "TKOFF_DIST")
    top = max(float(pilot.status.home[i, 2]) + height, z)
    if pilot.status.landed[i]:
        heading = degrees(pi / 2 - yaw) % 360.0
        pilot.say(
            i, _INFO, f"Takeoff to {height:.0f}m for {distance:.1f}m heading {heading:.1f} deg"
        )
        legs.climb_out(i, top)
        yield
    legs.set_circle(i, nan)
    legs.go(i, (x + distance * cos(yaw), y + distance * sin(yaw), top), nan)
    yield


def _loiter(pilot: Pilot, i: int) -> Routine:
    """Round the place where it is."""
    pilot.take_goal(i)
    legs_of(pilot).set_circle(i, nan)
    legs_of(pilot).go(i, pilot.place(i), nan)
    yield


def _straight(pilot: Pilot, i: int) -> Routine:
    """Nobody touches the sticks: on the way it has, at the height it has."""
    x, y, z = pilot.place(i)
    if pilot.status.landed[i]:
        legs_of(pilot).go(i, (x, y, z), nan)
    else:
        yaw = pilot.yaw(i)
        end = x + _AHEAD_M * cos(yaw), y + _AHEAD_M * sin(yaw), z
        legs_of(pilot).line(i, (x, y, z), end, radius_m=inf)
    yield


def _return(pilot: Pilot, i: int) -> Routine:
    """To RTL_ALTITUDE over home, or a rally point, and round it for good."""
    get = pilot.parameters.get
    hx, hy, hz = refuge(pilot, i, get(i, "RALLY_LIMIT_KM") * 1e3)
    height, radius = get(i, "RTL_ALTITUDE"), get(i, "RTL_RADIUS")
    top = hz + height if height >= 0 else pilot.place(i)[2]
    legs_of(pilot).set_circle(i, -radius if radius else nan)
    autoland, circle = get(i, "RTL_AUTOLAND"), abs(legs_of(pilot).circle(i))
    if autoland == _AUTOLAND_AT_ONCE and _lands(pilot, i):
        return
    if autoland == _AUTOLAND_AFTER:
        legs_of(pilot).go(i, (hx, hy, top), nan, radius_m=1.5 * circle)
        yield
        if _lands(pilot, i):
            return
    legs_of(pilot).go(i, (hx, hy, top), nan)
    yield


def _lands(pilot: Pilot, i: int) -> bool:
    """It has left its return for the landing of its mission."""
    assert isinstance(pilot, ArduPlane)
    return pilot.start_landing(i) is None


def _step_return(pilot: Pilot, i: int, step: Step) -> Routine:
    yield from _return(pilot, i)
    while not pilot.status.landed[i]:
        yield


ROUTINES: Final[Mapping[Mode, Make]] = {
    Mode.MANUAL: _straight,
    Mode.ALTITUDE: _straight,
    Mode.POSITION: _straight,
    Mode.HOLD: _loiter,
    Mode.TAKEOFF: _take_off,
    Mode.RETURN: _return,
    Mode.MISSION: mission(
        all_told({**FLOWN, Do.RETURN: _step_return}),
        ending="Mission complete, changing mode to RTL",
        then=Mode.RETURN,
    ),
}
"""What ArduPlane does by itself; in Guided it flies round the place it was sent to."""
