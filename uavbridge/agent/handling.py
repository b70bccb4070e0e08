"""How closely each kind of vehicle can be flown to a place."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from uavbridge.vehicle.api import VehicleKind


@dataclass(frozen=True, slots=True)
class Handling:
    """What counts as being there.

    Attributes:
        start_m: horizontal distance to the start of the search.
        height_m: distance to a height.
        home_m: horizontal distance to home, above which it comes down.
        take_off_m: least height to take off to; 0: as the mission has it.
        flies: it has a height at all.
        circles: it can not stand still, so its autopilot ends the flight over home.
    """

    start_m: float = 5.0
    height_m: float = 1.5
    home_m: float = 1.5
    take_off_m: float = 0.0
    flies: bool = True
    circles: bool = False


HANDLING: dict[VehicleKind, Handling] = {
    "multirotor": Handling(),
    "rover": Handling(height_m=inf, home_m=3.0, flies=False),
    "plane": Handling(start_m=200.0, height_m=15.0, home_m=150.0, take_off_m=50.0, circles=True),
}
