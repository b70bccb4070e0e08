"""PX4's aircraft: Offboard by attitudes, and by setpoints that name a manoeuvre."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import atan2, hypot, inf, nan
from typing import Final, TypeAlias

from sim_vehicles.arming import Refusal
from sim_vehicles.autopilot import Autopilot
from sim_vehicles.failsafe import Failsafes
from sim_vehicles.legs import DESCEND, Asked, Tilt
from sim_vehicles.modes import Mode
from sim_vehicles.pilot import Pilot, Routine
from sim_vehicles.plans import NOWHERE, Do, Vector
from sim_vehicles.winged.landing import course, go_around, land_at, legs_of, planned_landing

_SAME_M: Final = 1.0
_GLIDING: Final = Tilt(throttle=0.0)

Early: TypeAlias = tuple[Do | None, Vector, Tilt | None]
"""A manoeuvre, a place, an attitude: what is to be flown once Offboard is on."""


class Px4Plane(Autopilot):
    """Aircraft under PX4."""

    def _watch(self) -> Failsafes:
        self._doing: dict[int, tuple[Do, Vector]] = {}
        self._first: dict[int, Early] = {}
        return super()._watch()

    def follow(self, i: int, asked: Asked) -> None:
        self._first.pop(i, None)
        if self._doing.pop(i, None) is not None:
            self._routines[i] = None
            self.legs.start_following(i, asked)
        super().follow(i, asked)

    def tilt(self, i: int, asked: Tilt) -> None:
        self._lean(i, asked, NOWHERE)

    def glide(self, i: int, position: Vector) -> None:
        """A setpoint: towards a place without thrust, at the airspeed of trim."""
        self._lean(i, _GLIDING, position)

    def _lean(self, i: int, asked: Tilt, position: Vector) -> None:
        self.status.setpoint_us[i] = self.now_us
        if not self._heeds(i):
            self._first[i] = (None, position, asked)
            return
        if self._doing.pop(i, None) is not None:
            self._routines[i] = None
        self.legs.tilt(i, asked, position)

    def manoeuvre(self, i: int, what: Do, place: Vector) -> None:
        """A setpoint of a take-off to a place and height, or of a landing there."""
        self.status.setpoint_us[i] = self.now_us
        if not self._heeds(i):
            self._first[i] = (what, place, None)
            return
        doing = self._doing.get(i)
        if doing is not None and doing[0] is what and _apart(doing[1], place) < _SAME_M:
            return
        self._doing[i] = what, place
        self._routines[i] = _MANOEUVRES[what](self, i, place)
        self._resume(i)

    def start_landing(self, i: int) -> Refusal | None:
        """Go on with the mission at its landing, the nearest of several."""
        number = planned_landing(self, i)
        if number is None:
            return Refusal("planned mission landing not available")
        self.set_current(i, number)
        return self.start_mission(i)

    def go_around(self, i: int) -> Refusal | None:
        """Give up the landing that is flown: climb, and loiter over its end."""
        if self.legs.kind[i] == DESCEND and not self.status.landed[i]:
            self._routines[i] = go_around(self, i)
            self._resume(i)
        return None

    def change_height(self, i: int, z: float) -> Refusal | None:
        """Hold, round the same place, at another height (ENU m; NaN: as it is)."""
        x, y, _ = self.place(i)
        if self.legs.has_place(i) and self.status.mode[i] == Mode.HOLD:
            x, y, _ = legs_of(self).middle(i)
        else:
            self.legs.set_circle(i, nan)
        return self.reposition(i, (x, y, z), nan)

    def switch(self, i: int, mode: Mode) -> None:
        self._doing.pop(i, None)
        super().switch(i, mode)

    def stop_motors(self, i: int, text: str) -> None:
        self._doing.pop(i, None)
        super().stop_motors(i, text)

    def _stay_until_told(self, i: int) -> None:
        super()._stay_until_told(i)
        what, place, attitude = self._first.pop(i, (None, NOWHERE, None))
        if not self.has_setpoints(i):
            return
        if attitude is not None:
            self._lean(i, attitude, place)
        elif what is not None:
            self.manoeuvre(i, what, place)

    def _heeds(self, i: int) -> bool:
        return bool(self.status.armed[i] and self.status.mode[i] == Mode.OFFBOARD)


def _take_off(pilot: Pilot, i: int, place: Vector) -> Routine:
    """Straight ahead up to the height of a place, then to it and round it."""
    legs = legs_of(pilot)
    if pilot.status.landed[i]:
        legs.climb_out(i, place[2])
        yield
    legs.go(i, place, nan)
    yield


def _land(pilot: Pilot, i: int, place: Vector) -> Routine:
    """Come down at a place, on the course on which it is reached from here."""
    x, y, _ = pilot.place(i)
    east, north = place[0] - x, place[1] - y
    yaw = atan2(north, east) if hypot(east, north) > _SAME_M else course(pilot, i)
    yield from land_at(pilot, i, place[0], place[1], place[2], yaw)


_MANOEUVRES: Final[Mapping[Do, Callable[[Pilot, int, Vector], Routine]]] = {
    Do.TAKE_OFF: _take_off,
    Do.LAND: _land,
}


def _apart(one: Vector, other: Vector) -> float:
    return max((abs(a - b) for a, b in zip(one, other, strict=True)), default=inf)
