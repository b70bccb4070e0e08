"""One question to an autopilot until its answer: a transition table over time and answers.

Commands and parameters are both asked this way: sent, repeated while nothing
comes back, given up after a number of tries. The table knows no bytes and no
clock; what is not in it (late or doubled answers) changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Final

from uavbridge.clock import to_us


class State(Enum):
    """Where an exchange stands."""

    WAITING = "waiting"  # not sent yet
    SENT = "sent"
    WORKING = "working"  # the autopilot says that it is at it
    PAUSED = "paused"  # refused for now, to be asked again
    ACCEPTED = "accepted"
    REFUSED = "refused"
    SILENT = "silent"  # never answered


class Event(Enum):
    """What moves an exchange on."""

    TIMER = "timer"  # its deadline has passed
    LAST = "last"  # its deadline has passed and no try is left
    ACCEPT = "accept"
    PROGRESS = "progress"
    REFUSE = "refuse"
    LATER = "later"


TABLE: Final[dict[tuple[State, Event], State]] = {
    (State.WAITING, Event.TIMER): State.SENT,
    (State.SENT, Event.TIMER): State.SENT,
    (State.SENT, Event.LAST): State.SILENT,
    (State.SENT, Event.ACCEPT): State.ACCEPTED,
    (State.SENT, Event.PROGRESS): State.WORKING,
    (State.SENT, Event.REFUSE): State.REFUSED,
    (State.SENT, Event.LATER): State.PAUSED,
    (State.WORKING, Event.TIMER): State.SENT,
    (State.WORKING, Event.LAST): State.SILENT,
    (State.WORKING, Event.ACCEPT): State.ACCEPTED,
    (State.WORKING, Event.PROGRESS): State.WORKING,
    (State.WORKING, Event.REFUSE): State.REFUSED,
    (State.WORKING, Event.LATER): State.PAUSED,
    (State.PAUSED, Event.TIMER): State.SENT,
    (State.PAUSED, Event.LAST): State.REFUSED,
    (State.PAUSED, Event.ACCEPT): State.ACCEPTED,
}

OVER: Final = frozenset({State.ACCEPTED, State.REFUSED, State.SILENT})


@dataclass(frozen=True, slots=True)
class Patience:
    """How often and how long to ask.

    Attributes:
        tries: times a question is sent before it is given up.
        retry_s: wait for an answer before the next try.
        working_s: wait after "in progress" before the next try.
    """

    tries: int = 18  # with three datagrams of ten lost each way, one in 200,000 fails
    retry_s: float = 0.3
    working_s: float = 5.0


class Exchange:
    """One question on its way through ``TABLE``, on mission time."""

    __slots__ = ("_patience", "deadline_us", "state", "tries")

    def __init__(self, patience: Patience, t_us: int) -> None:
        self._patience = patience
        self.state = State.WAITING
        self.tries = 0
        self.deadline_us = t_us

    @property
    def over(self) -> bool:
        """Nothing more will happen."""
        return self.state in OVER

    def hear(self, event: Event, t_us: int) -> None:
        """Take an answer; one that does not fit the state changes nothing."""
        after = TABLE.get((self.state, event))
        if after is None:
            return
        self.state = after
        if after is State.WORKING:
            self.deadline_us = t_us + to_us(self._patience.working_s)

    def due(self, t_us: int) -> bool:
        """Run the timer; True: send the question now."""
        if t_us < self.deadline_us or self.over:
            return False
        last = self.tries >= self._patience.tries
        self.state = TABLE[self.state, Event.LAST if last else Event.TIMER]
        if self.state is not State.SENT:
            return False
        self.tries += 1
        self.deadline_us = t_us + to_us(self._patience.retry_s)
        return True
