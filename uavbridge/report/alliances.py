"""Suballiances over time, from what their leaders tell on the radio (Zhou 2023, section 3.2)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from planners.search.mountain.payload import decode
from planners.types import I64
from uavbridge.bus.wire import Frame
from uavbridge.clock import SECOND_US
from uavbridge.report.result import Alliances

PLANNER = "mountain"
_MOST = 16  # members that a roster may list


@dataclass(slots=True)
class _Second:
    rosters: dict[int, tuple[int, ...]] = field(default_factory=dict)  # target: members
    first: dict[int, int] = field(default_factory=dict)  # agent of class I: its target


class Rosters:
    """Who led whom to which target, second by second.

    Args:
        targets: how many there are.
    """

    def __init__(self, targets: int) -> None:
        self._targets = targets
        self._seconds: dict[int, _Second] = {}

    def hear(self, frame: Frame) -> None:
        """One frame of anybody."""
        told = decode(frame.payload, _MOST)
        if not 0 <= told.task < self._targets:
            return
        second = self._seconds.setdefault(frame.t_us // SECOND_US, _Second())
        if told.first:
            second.first[frame.sender] = told.task
        if told.leads:
            known = second.rosters.get(told.task, ())
            second.rosters[told.task] = max(known, told.roster, key=len)

    def alliances(self) -> Alliances | None:
        """Members of each target's suballiance over time; None where there never was one."""
        if not any(second.rosters for second in self._seconds.values()):
            return None
        times = np.arange(max(self._seconds) + 1)
        members = np.zeros((len(times), self._targets), dtype=np.int64)
        first: I64 = np.zeros_like(members)
        for t, second in self._seconds.items():
            for target, roster in second.rosters.items():
                members[t, target] = len(roster)
                first[t, target] = sum(second.first.get(one) == target for one in roster)
        return Alliances(times.astype(np.float64), members, first)
