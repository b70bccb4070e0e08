"""The control ticks of a paced loop: when they are due, which come late or are left out."""

from __future__ import annotations

from dataclasses import dataclass

from uavbridge.clock import SECOND_US, Clock, PacedClock, to_s, to_us

CONTROL_US = 100_000  # between two steps of the agents
LEAP_S = 3.0  # so much too late the process stood still: what it missed is not made up for
SETTLE_S = 0.3  # wall time after that until vehicles have been heard
STOOD_S = 1.0  # wall time between two ticks after which setpoints may have been missed
LATE_TICKS = 5  # so many ticks late, the next ones but those on a full second are left out


@dataclass(frozen=True, slots=True)
class Punctuality:
    """How well a loop kept time.

    Attributes:
        ticks: control ticks that were due.
        late: of them, those that began more than a tick after their time, or were left out.
        left_out: of those, the ones left out to catch up.
        worst_s: longest delay, in mission time.
    """

    ticks: int = 0
    late: int = 0
    left_out: int = 0
    worst_s: float = 0.0


class Ticks:
    """Walks through control ticks.

    Args:
        clock: what the loop goes by; it may wait for a simulation.
        paced: real time, by which a tick is late.
        first_us: mission time of the first tick.

    Attributes:
        t_us: of the next tick, or of the one that runs.
        late_s: of the one that runs, by ``clock``; after standing still, or waiting long for a
            simulation, for how long.
        leapt: the one that runs is the first after the process stood still.
    """

    def __init__(self, clock: Clock, paced: PacedClock, first_us: int = 0) -> None:
        self.t_us = first_us
        self.late_s = 0.0
        self.leapt = False
        self._clock, self._paced = clock, paced
        self._ticks = self._late = self._left_out = 0
        self._worst_us = 0
        self._done_us = 0  # real time of the end of the newest tick; 0: none yet

    @property
    def kept(self) -> Punctuality:
        """How well time was kept so far."""
        return Punctuality(self._ticks, self._late, self._left_out, to_s(self._worst_us))

    def wait(self) -> int:
        """Wait for the next tick; its mission time."""
        self._clock.wait_until(self.t_us)
        self.late_s = to_s(self._clock.now_us() - self.t_us)
        stood_us = self._paced.now_us() - self._done_us
        if self._done_us and stood_us > to_us(STOOD_S * self._paced.speed):
            self.late_s = max(self.late_s, to_s(stood_us))
        self._leap()
        behind_us = self._paced.now_us() - self.t_us
        self._worst_us = max(self._worst_us, behind_us)
        self._ticks += 1
        self._late += behind_us > CONTROL_US
        return self.t_us

    def done(self) -> None:
        """The tick is over. Of those that should be over, too, only full seconds still come."""
        self._done_us = self._paced.now_us()
        self.t_us += CONTROL_US
        while self.t_us % SECOND_US and self._clock.now_us() - self.t_us > LATE_TICKS * CONTROL_US:
            self.t_us += CONTROL_US
            self._ticks += 1
            self._late += 1
            self._left_out += 1

    def _leap(self) -> None:
        """After standing still, go on with the full second that it is.

        What came meanwhile is heard in one tick: spread over the seconds that were missed, it would
        look as if everybody had been silent for most of them.
        """
        self.leapt = self._clock.now_us() - self.t_us > to_us(LEAP_S)
        if not self.leapt:
            return
        self._clock.wait_until(self._clock.now_us() + to_us(SETTLE_S * self._paced.speed))
        missed = (self._clock.now_us() // SECOND_US * SECOND_US - self.t_us) // CONTROL_US
        self.t_us += missed * CONTROL_US
        self._ticks += missed
        self._late += missed
        self._left_out += missed
