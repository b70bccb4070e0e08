"""Whose vehicle it is: the modes in which a vehicle does what its agent asked it for.

Any other mode was chosen by somebody: a pilot, a ground station, the autopilot's own failsafe.
"""

from __future__ import annotations

from enum import Enum
from typing import Final

from uavbridge.agent.phases import FOLLOWING, Phase
from uavbridge.clock import to_s
from uavbridge.vehicle.api import Mode, VehicleState

STRANGE_S: Final = 0.3  # a mode we did not ask for, for so long: somebody has the vehicle
STALL_S: Final = 0.5  # a step so late may have cost us the vehicle: then it is ours to take back
STALL_MEMORY_S: Final = 10.0
FAILSAFES: Final = frozenset({Mode.HOLD, Mode.RETURN, Mode.LAND})
OURS: Final = FAILSAFES | {Mode.OFFBOARD}  # what our own vehicle may be in when we come back
_LANDINGS: Final = frozenset({Mode.LAND})
_CIRCLED_LANDINGS: Final = frozenset({Mode.LAND, Mode.MISSION, Mode.RETURN})
_CLIMBS: Final = frozenset({Mode.TAKEOFF, Mode.OFFBOARD})
_PARKS: Final = frozenset({Mode.OFFBOARD, Mode.HOLD, Mode.LAND, Mode.UNKNOWN})


def is_ours(
    phase: Phase, mode: Mode, *, granted: bool, high: bool = False, circles: bool = False
) -> bool:
    """Nobody else chose this mode.

    Args:
        phase: of the agent.
        mode: of its vehicle.
        granted: what the phase asks its vehicle for was done once.
        high: it has taken off, after which autopilots may hold by themselves.
        circles: it lands as planes do: by a mission, or from its return.
    """
    if phase in FOLLOWING:
        return mode is Mode.OFFBOARD
    if not granted:
        return True
    if phase is Phase.TAKEOFF:
        return mode in _CLIMBS or (high and mode is Mode.HOLD)
    if phase is Phase.LAND:
        return mode in (_CIRCLED_LANDINGS if circles else _LANDINGS)
    return phase is not Phase.PARK or mode in _PARKS


class Held(Enum):
    """Who has a vehicle."""

    BY_US = "by us"
    LET_GO = "let go"  # our own setpoints came too late, and the autopilot's failsafe took over
    BY_SOMEBODY = "by somebody"


class Custody:
    """Watches whether a vehicle is still its agent's.

    Args:
        simulated: it may be taken back after our own lateness; others never are.
    """

    def __init__(self, *, simulated: bool) -> None:
        self._simulated = simulated
        self._strange_us: int | None = None  # in a strange mode since then
        self._stopped_us: int | None = None  # disarmed since then, though it was to go on
        self._stalled_us: int | None = None  # newest step that came too late

    def begin(self) -> None:
        """Another phase: what was strange may not be."""
        self._strange_us = None

    def late(self, t_us: int, late_s: float) -> None:
        """A step at ``t_us`` comes so late."""
        if late_s > STALL_S:
            self._stalled_us = t_us

    def stopped(self, state: VehicleState, t_us: int) -> bool:
        """Its motors stopped on the way, and not just now."""
        if state.armed or not state.link_ok:
            self._stopped_us = None
            return False
        if self._stopped_us is None:
            self._stopped_us = t_us
        return to_s(t_us - self._stopped_us) > STRANGE_S

    def held(self, mode: Mode, ours: bool, t_us: int) -> Held:
        """Who has it, by its mode and whether that ``is_ours``; called at every step."""
        if ours:
            self._strange_us = None
        elif self._strange_us is None:
            self._strange_us = t_us
        elif self._stalled_lately(t_us) and mode in FAILSAFES:
            return Held.LET_GO
        elif to_s(t_us - self._strange_us) > STRANGE_S:
            return Held.BY_SOMEBODY
        return Held.BY_US

    def _stalled_lately(self, t_us: int) -> bool:
        stalled_us = self._stalled_us if self._simulated else None
        return stalled_us is not None and to_s(t_us - stalled_us) < STALL_MEMORY_S
