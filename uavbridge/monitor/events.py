"""The log of what happened, each thing once, whatever ways it was told."""

from __future__ import annotations

from collections import deque

from uavbridge.bus import keys
from uavbridge.clock import to_s
from uavbridge.monitor.past import PastEvent
from uavbridge.monitor.watched import RECENT_S, Happening

KEPT = 10_000
LONGEST_TEXT = 500
SAME_ORDER_S = 5.0  # the judge repeats its orders every second; that is one event


class EventLog:
    """The newest events.

    Attributes:
        events: as they came.
        count: all so far; ``events`` ends with number ``count - 1``.
    """

    def __init__(self) -> None:
        self.events: deque[Happening] = deque(maxlen=KEPT)
        self.count = 0
        self._orders: dict[str, tuple[str, int]] = {}
        self._recalled: set[tuple[int, str, str]] = set()

    def add(self, t_us: int, agent: int | None, kind: str, text: str) -> None:
        """Something happened."""
        self.events.append(Happening(t_us, agent, kind, text[:LONGEST_TEXT]))
        self.count += 1

    def order(self, t_us: int, target: str, verb: str) -> None:
        """An order was given; one said again and again is told once."""
        last, at_us = self._orders.get(target, ("", 0))
        self._orders[target] = (verb, t_us)
        if verb != last or to_s(t_us - at_us) > SAME_ORDER_S:
            to = "all" if target == keys.EVERYONE else f"agent {target}"
            self.add(t_us, None, "order", f"{verb} to {to}")

    def told(self, t_us: int, agent: int, kind: str, text: str) -> None:
        """An event came over the bus; one that was recalled just now is known."""
        if (agent, kind, text) in self._recalled:
            self._recalled.discard((agent, kind, text))
        else:
            self.add(t_us, agent, kind, text)

    def recall(self, now_us: int, event: PastEvent) -> None:
        """One of before we came; a fresh one may come by the other way too."""
        self.add(event.t_us, event.agent, event.kind, event.text)
        if to_s(now_us - event.t_us) < RECENT_S:
            self._recalled.add((event.agent, event.kind, event.text))
