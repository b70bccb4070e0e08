"""The phases of an agent's mission, as a table.

Rule 1: everything that says which phase may follow which, and by which order, is here.
Rule 2: this file knows neither vehicles nor maps.
"""

from __future__ import annotations

from enum import Enum

from uavbridge.agent.orders import Verb


class Phase(Enum):
    """What an agent is doing."""

    CONNECT = "connect"  # waits for its vehicle's heartbeat and position
    ARM = "arm"  # waits for readiness, then asks for the motors
    START = "start"  # on the ground: waits to follow our setpoints
    TAKEOFF = "takeoff"  # climbs by the autopilot
    CLIMB = "climb"  # follows our setpoints to its start at search height
    SEARCH = "search"
    PAUSE = "hold"  # stands still on order
    RISE = "rise"  # straight up or down to its return height
    HOME = "return"  # level flight to over home; the drive there
    DESCEND = "descend"  # straight down over home, when the column is free
    LAND = "land"  # by the autopilot
    PARK = "park"  # on the ground: stops, and the motors with it
    DONE = "landed"
    ALOFT = "aloft"  # the mission is over in the air: the autopilot circles
    YIELDED = "yielded"  # the autopilot or a pilot took the vehicle
    FAILED = "failed"


_HOMEWARDS = (Phase.RISE, Phase.LAND, Phase.HOME, Phase.PARK)
_ENDS = (Phase.ALOFT, Phase.YIELDED, Phase.FAILED)

NEXT: dict[Phase, frozenset[Phase]] = {
    Phase.CONNECT: frozenset({Phase.ARM, Phase.YIELDED, Phase.DONE, Phase.FAILED}),
    Phase.ARM: frozenset({Phase.START, Phase.TAKEOFF, Phase.CLIMB, Phase.DONE, Phase.FAILED}),
    Phase.START: frozenset({Phase.SEARCH, Phase.PARK, Phase.YIELDED, Phase.FAILED}),
    Phase.TAKEOFF: frozenset({Phase.CLIMB, Phase.LAND, Phase.YIELDED, Phase.FAILED}),
    Phase.CLIMB: frozenset(
        {Phase.SEARCH, Phase.PAUSE, Phase.RISE, Phase.LAND, Phase.YIELDED, Phase.FAILED}
    ),
    Phase.SEARCH: frozenset({Phase.PAUSE, *_HOMEWARDS, *_ENDS}),
    Phase.PAUSE: frozenset({Phase.SEARCH, *_HOMEWARDS, *_ENDS}),
    Phase.RISE: frozenset({Phase.HOME, Phase.LAND, Phase.YIELDED, Phase.FAILED}),
    Phase.HOME: frozenset({Phase.DESCEND, Phase.LAND, Phase.PARK, Phase.YIELDED, Phase.FAILED}),
    Phase.DESCEND: frozenset({Phase.LAND, Phase.YIELDED, Phase.FAILED}),
    Phase.LAND: frozenset({Phase.DONE, Phase.YIELDED, Phase.FAILED}),
    Phase.PARK: frozenset({Phase.DONE, Phase.YIELDED, Phase.FAILED}),
    Phase.YIELDED: frozenset({Phase.SEARCH, Phase.DONE, Phase.FAILED}),
    Phase.DONE: frozenset(),
    Phase.ALOFT: frozenset(),
    Phase.FAILED: frozenset(),
}

# Tuples: looked at in every tick, and finding one of a few by identity costs less than a hash.
FOLLOWING = (Phase.SEARCH, Phase.CLIMB, Phase.PAUSE, Phase.RISE, Phase.HOME, Phase.DESCEND)
RETURNING = (Phase.RISE, Phase.HOME, Phase.DESCEND, Phase.LAND, Phase.PARK)
ENDED = (Phase.DONE, Phase.ALOFT, Phase.FAILED)

# What a phase of flight is to a vehicle on the ground.
DRIVEN: dict[Phase, Phase] = {
    Phase.TAKEOFF: Phase.START,
    Phase.RISE: Phase.HOME,
    Phase.LAND: Phase.PARK,
}

_FLYING = frozenset({*FOLLOWING, Phase.TAKEOFF, Phase.START})
_ON_THE_WAY = frozenset(FOLLOWING) - frozenset(RETURNING)

# In which phases an order is obeyed, and the phase it leads to.
ORDERS: dict[Verb, tuple[frozenset[Phase], Phase]] = {
    Verb.PAUSE: (frozenset({Phase.CLIMB, Phase.SEARCH}), Phase.PAUSE),
    Verb.RESUME: (frozenset({Phase.PAUSE}), Phase.SEARCH),
    Verb.GOTO: (frozenset({Phase.CLIMB, Phase.SEARCH, Phase.PAUSE}), Phase.PAUSE),
    Verb.HOLD: (_FLYING, Phase.YIELDED),
    Verb.TAKEOVER: (frozenset({Phase.YIELDED}), Phase.SEARCH),
    Verb.RETURN: (_ON_THE_WAY, Phase.RISE),
    Verb.LAND: (_FLYING, Phase.LAND),
    Verb.ABORT: (_FLYING, Phase.LAND),
}


def check(before: Phase, after: Phase) -> Phase:
    """``after``, if the table allows it; otherwise the agent has a fault: RuntimeError."""
    if after not in NEXT[before]:
        raise RuntimeError(f"no way from phase {before.value} to {after.value}")
    return after
