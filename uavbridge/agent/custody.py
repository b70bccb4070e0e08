"""Whose vehicle it is: the modes in which a vehicle does what its agent asked it for.

Any other mode was chosen by somebody: a pilot, a ground station, the autopilot's own failsafe.
"""

from __future__ import annotations

from typing import Final

from uavbridge.agent.phases import FOLLOWING, Phase
from uavbridge.vehicle.api import Mode

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
