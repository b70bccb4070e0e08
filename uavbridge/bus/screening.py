"""What no honest agent sends: dropped and counted before any radio or planner sees it."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass
from math import dist, inf, isfinite
from typing import Protocol

from uavbridge.bus import keys
from uavbridge.bus.wire import Frame, Vector
from uavbridge.clock import SECOND_US, to_us

FUTURE_S = 1.0  # clocks may differ by this much
OLD_S = 30.0  # nobody hears of anything so old
FRESH = 0.1  # share of that after which a second copy is no accident
REMEMBERED = 64  # messages of a sender, to know a duplicate
FAR_M = 5000.0  # so far outside the area nobody is
HIGH_M = 10000.0
JUMP_M = 50.0  # positions may be wrong by so much
HASTE = 2.0  # and vehicles faster than they should
TRUSTED_S = 10.0  # an earlier position says nothing about a later one after this time
MOST_WARNINGS = 1000

_FUTURE_US, _TRUSTED_US = to_us(FUTURE_S), to_us(TRUSTED_S)

_log = logging.getLogger(__name__)


class Sent(Protocol):
    """What frames and beacons have in common."""

    @property
    def sender(self) -> int: ...
    @property
    def t_us(self) -> int: ...
    @property
    def position(self) -> Vector: ...


@dataclass(frozen=True, slots=True)
class Bounds:
    """What is possible in a mission; the defaults let everything pass.

    Attributes:
        team: agents that there are; None: any.
        mission: mark that frames must bear; None: any.
        most_bytes: of the cells of a frame.
        area: west, south, east, north in m.
        speed_m_s: of the fastest vehicle, in space.
        old_s: what was sent so long ago is a replay.
    """

    team: Collection[int] | None = None
    mission: int | None = None
    most_bytes: float = inf
    area: tuple[float, float, float, float] = (-inf, -inf, inf, inf)
    speed_m_s: float = inf
    old_s: float = inf


ANY = Bounds()


class Screening:
    """Looks at every message of one kind that reaches a process.

    Args:
        bounds: of the mission.
        what: the kind, for warnings; empty: nobody is warned.

    Attributes:
        rejects: messages dropped, by reason.
    """

    def __init__(self, bounds: Bounds = ANY, what: str = "") -> None:
        self.rejects: Counter[str] = Counter()
        self._bounds, self._what = bounds, what
        west, south, east, north = bounds.area
        self._west, self._east = west - FAR_M, east + FAR_M
        self._south, self._north = south - FAR_M, north + FAR_M
        self._high = HIGH_M if isfinite(west) else inf
        self._old_us = bounds.old_s * SECOND_US
        self._m_per_us = HASTE * bounds.speed_m_s / SECOND_US
        self._known: dict[int, dict[tuple[int, int], None]] = {}
        self._places: dict[int, tuple[int, Vector]] = {}  # newest time and position of a sender
        self._warned: set[tuple[int | None, str]] = set()

    def refuse(self, key: str, reason: str) -> None:
        """Count what came under a key; warn once of each sender and reason."""
        self.rejects[reason] += 1
        sender = keys.agent_of(key)
        if not self._what or reason == "duplicate" or (sender, reason) in self._warned:
            return
        if len(self._warned) < MOST_WARNINGS:
            self._warned.add((sender, reason))
            whose = "somebody" if sender is None else f"agent {sender}"
            _log.warning("%s of %s dropped: %s", self._what, whose, reason)

    def passes(self, key: str, message: Sent, kind: int, t_us: int) -> bool:
        """Whether a message is possible; else it is counted.

        Args:
            key: under which it came.
            message: as decoded.
            kind: of the message, ``wire.Kind``.
            t_us: now.
        """
        reason = self._fault(key, message, kind, t_us)
        if reason:
            self.refuse(key, reason)
        return not reason

    def _fault(self, key: str, message: Sent, kind: int, t_us: int) -> str:
        bounds, sender, sent_us = self._bounds, message.sender, message.t_us
        if sender != keys.agent_of(key):
            return "sender"
        if bounds.team is not None and sender not in bounds.team:
            return "stranger"
        if isinstance(message, Frame):  # a beacon has neither mission nor cells
            if bounds.mission is not None and message.mission != bounds.mission:
                return "mission"
            if len(message.cells) > bounds.most_bytes:
                return "size"
        if sent_us > t_us + _FUTURE_US:
            return "future"
        if sent_us < t_us - self._old_us:
            return "replayed"
        misplaced = self._misplaced(sender, sent_us, message.position)
        if misplaced:
            return misplaced
        again = self._twice(sender, (sent_us, kind))
        # two subscriptions may bring one message twice, but at one time
        return "replayed" if again and sent_us < t_us - FRESH * self._old_us else again

    def _twice(self, sender: int, identity: tuple[int, int]) -> str:
        """Whether a sender's message was there before, by sending time and kind; else noted."""
        known = self._known.get(sender)
        if known is None:
            known = self._known[sender] = {}
        if identity in known:
            return "duplicate"
        if len(known) >= REMEMBERED:
            oldest = next(iter(known))
            if identity < oldest:
                return "replayed"
            del known[oldest]
        known[identity] = None
        return ""

    def _misplaced(self, sender: int, sent_us: int, position: Vector) -> str:
        x, y, z = position
        if not (self._west <= x <= self._east and self._south <= y <= self._north):
            return "position"
        if not -self._high <= z <= self._high:
            return "position"
        before = self._places.get(sender)
        if before is not None:
            gap_us = sent_us - before[0]
            if gap_us < 0:
                gap_us = -gap_us
            way_m = self._m_per_us * gap_us + JUMP_M
            if gap_us < _TRUSTED_US and dist(position, before[1]) > way_m:
                return "jump"
            if sent_us < before[0]:
                return ""
        self._places[sender] = sent_us, position
        return ""
