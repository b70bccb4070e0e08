"""The modes of an autopilot, as data: what each does, needs and permits."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final


class Mode(IntEnum):
    """What an autopilot can be told to do, in words common to all autopilots."""

    MANUAL = 0
    ALTITUDE = 1  # sticks ask for tilt, height is held
    POSITION = 2  # sticks ask for velocity
    TAKEOFF = 3
    HOLD = 4
    MISSION = 5
    RETURN = 6
    LAND = 7
    OFFBOARD = 8  # follows setpoints
    BRAKE = 9  # stops, and holds whatever the sticks say


@dataclass(frozen=True, slots=True)
class ModeSpec:
    """One row of the mode table.

    Attributes:
        name: the autopilot's name of the mode.
        auto: the autopilot navigates by itself.
        needs_position: not flown without a position estimate.
        needs_sticks: not flown without a pilot's remote control, which is never there.
        needs_setpoints: not flown without a stream of setpoints.
        armable: arming is allowed in it.
        passing: left again on disarming, for the mode before it.
    """

    name: str
    auto: bool = False
    needs_position: bool = False
    needs_sticks: bool = False
    needs_setpoints: bool = False
    armable: bool = True
    passing: bool = False


MODES: Final[dict[Mode, ModeSpec]] = {
    Mode.MANUAL: ModeSpec("Manual", needs_sticks=True),
    Mode.ALTITUDE: ModeSpec("Altitude", needs_sticks=True),
    Mode.POSITION: ModeSpec("Position", needs_position=True, needs_sticks=True),
    Mode.TAKEOFF: ModeSpec("Takeoff", auto=True, needs_position=True),
    Mode.HOLD: ModeSpec("Hold", auto=True, needs_position=True),
    Mode.MISSION: ModeSpec("Mission", auto=True, needs_position=True),
    Mode.RETURN: ModeSpec("Return", auto=True, needs_position=True, armable=False, passing=True),
    Mode.LAND: ModeSpec("Land", auto=True, armable=False, passing=True),
    Mode.OFFBOARD: ModeSpec("Offboard", needs_position=True, needs_setpoints=True),
}
"""Land needs no position: without one it just descends."""
