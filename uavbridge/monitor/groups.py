"""Who belongs together and who leads, as planners tell it in their frames or in their words."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from planners.flocking.starling import message as starling
from planners.search.mountain import payload as mountain

MOST_MEMBERS = 255


@dataclass(frozen=True, slots=True)
class Membership:
    """One agent's word: its group, and whether it leads it."""

    group: int
    leads: bool


def _suballiance(agent: int, payload: bytes) -> Membership | None:
    """Of the search in mountains: a group a target (Zhou 2023)."""
    told = mountain.decode(payload, MOST_MEMBERS)
    return None if told.task < 0 else Membership(told.task, told.leads)


def _flock(agent: int, payload: bytes) -> Membership | None:
    """Of starlings: those on the same way, led by who planned it (Chen 2023)."""
    told = starling.decode(payload)
    return None if told.planner < 0 else Membership(told.planner, told.planner == agent)


GROUPS: Mapping[str, Callable[[int, bytes], Membership | None]] = MappingProxyType(
    {"mountain": _suballiance, "starling": _flock}
)
"""By the planner's name: from agent and payload to what it belongs to, if anything."""


_FOLLOWS = re.compile(r"follows (\d{1,5})\b")


def membership(planner: str, agent: int, payload: bytes, note: str) -> Membership | None:
    """What an agent belongs to, by its newest frame; None when it is in no group.

    Args:
        planner: its name.
        agent: id.
        payload: of the frame.
        note: the planner's own words, which count for planners that are not in ``GROUPS``: of
            one that "leads", or "follows" an agent by its id.
    """
    read = GROUPS.get(planner)
    if read is not None:
        return read(agent, payload) if payload else None
    if note.startswith("leads"):
        return Membership(agent, leads=True)
    found = _FOLLOWS.match(note)
    return Membership(int(found[1]), leads=False) if found else None
