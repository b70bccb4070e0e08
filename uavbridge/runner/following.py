"""Mission time of another machine's launcher, followed as the two machines' clocks drift apart.

It is asked for again every few seconds, beside the control loop, and what it is off by is made up
slowly: mission time never jumps, never runs backwards, and a single bad answer does little.
"""

from __future__ import annotations

import threading
from types import TracebackType
from typing import Self

from uavbridge.agent.report import Clocks
from uavbridge.bus.api import Bus
from uavbridge.clock import PacedClock
from uavbridge.errors import BusError
from uavbridge.runner.briefing import Agreement, agree
from uavbridge.runner.ticks import CONTROL_US

ASK_S = 5.0  # wall time between two times that it is asked for
SLEW = 1e-3  # of the time that passes: 1 ms a second, twenty times what cheap clocks drift


class Following:
    """Keeps a clock with the launcher's.

    Args:
        bus: a session of the mission; None: nobody is asked, as in tests.
        paced: the clock; its moment of mission start is moved.
        agreed: at the start.
    """

    def __init__(self, bus: Bus | None, paced: PacedClock, agreed: Agreement) -> None:
        self.newest = agreed  # set by another thread, read as a whole
        self._bus, self._paced = bus, paced
        self._over = threading.Event()
        self._asking = threading.Thread(target=self._ask, daemon=True)
        paced.epoch_ns = agreed.epoch_ns

    @property
    def offset_s(self) -> float:
        """Wall time by which the clock is ahead of the launcher's, as the newest answers say."""
        return (self.newest.epoch_ns - self._paced.epoch_ns) / 1e9

    @property
    def clocks(self) -> Clocks:
        """For the agents' reports."""
        newest = self.newest
        return Clocks(
            offset_s=round(self.offset_s, 6),
            error_s=round(newest.error_s, 6),
            date_offset_s=round(newest.date_offset_s, 6),
        )

    def step(self) -> None:
        """Make up for some of the offset; call it once a control tick."""
        off_ns = self.newest.epoch_ns - self._paced.epoch_ns
        if abs(off_ns) <= self.newest.error_s * 1e9:
            return  # it may be none
        most_ns = int(SLEW * CONTROL_US * 1000 / self._paced.speed)
        self._paced.epoch_ns += max(-most_ns, min(off_ns, most_ns))

    def __enter__(self) -> Self:
        if self._bus is not None:
            self._asking.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._over.set()
        if self._asking.is_alive():
            self._asking.join()

    def _ask(self) -> None:
        assert self._bus is not None
        while not self._over.wait(ASK_S):
            try:
                self.newest = agree(self._bus, until=self._over.is_set)
            except BusError:  # no launcher any more: the clock goes on as it does
                continue
