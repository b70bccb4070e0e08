"""Mission time: the only place that reads the wall clock.

Points in time are integer microseconds since mission start, durations float
seconds. A run has one time master: *stepped* time jumps where it is told,
*paced* time follows the monotonic clock times a factor.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Protocol

SECOND_US = 1_000_000
_LOOK_S = 0.001  # wall time between two looks at a simulation that is late
_LED_S = 0.4  # wall time that a simulation takes to go on without its launcher
_LONGEST_LOOK_S = 0.2  # between two looks; what is longer was spent elsewhere

# A stepped mission happens at no particular date; this one makes its files equal byte for byte.
STEPPED_DATE = datetime(2025, 1, 1, tzinfo=UTC)


def to_us(duration_s: float) -> int:
    """A duration in whole microseconds."""
    return round(duration_s * SECOND_US)


def to_s(t_us: int) -> float:
    """A point in time in seconds since mission start."""
    return t_us / SECOND_US


class Clock(Protocol):
    """Tells mission time and lets it pass."""

    def now_us(self) -> int:
        """Microseconds since mission start."""
        ...

    def wait_until(self, t_us: int) -> None:
        """Return when mission time has reached ``t_us`` (at once if it has)."""
        ...


class SteppedClock:
    """Time that jumps: as fast as the machine can go."""

    def __init__(self) -> None:
        self._now_us = 0

    def now_us(self) -> int:
        return self._now_us

    def wait_until(self, t_us: int) -> None:
        self._now_us = max(self._now_us, t_us)


class PacedClock:
    """Real time times a factor, from the moment it is made.

    Args:
        speed: mission seconds per wall second, above 0.
        epoch_ns: monotonic time (ns) of mission start; None: now. Processes on
            one machine that share it agree on mission time.
    """

    def __init__(self, speed: float = 1.0, *, epoch_ns: int | None = None) -> None:
        if not speed > 0:
            raise ValueError(f"speed must be positive, not {speed}")
        self.speed = speed
        self.epoch_ns = time.monotonic_ns() if epoch_ns is None else epoch_ns

    def now_us(self) -> int:
        return int((time.monotonic_ns() - self.epoch_ns) * self.speed) // 1000

    def wait_until(self, t_us: int) -> None:
        while (left_us := t_us - self.now_us()) > 0:
            time.sleep(left_us / self.speed / SECOND_US)


class LedClock:
    """Paced time that waits for a simulation which can not keep up.

    Agents must not run ahead of their vehicles: what they know of each other would be older
    than they believe. Where the simulation stands still the clock goes on from there without it,
    so that its silence is noticed.

    Args:
        paced: time as it should be.
        reached: asks how far the simulation is.
        lead_us: how far this clock may be ahead of it.
        patience_s: wall time after which a simulation that stands still is not waited for.
        led: asks whether a launcher leads both: then the simulation, too, has its patience with
            it, and is waited for a little longer.
    """

    def __init__(
        self,
        paced: PacedClock,
        reached: Callable[[], int],
        *,
        lead_us: int,
        patience_s: float = 2.0,
        led: Callable[[], bool] = lambda: False,
    ) -> None:
        self._paced = paced
        self._reached = reached
        self._lead_us = lead_us
        self._patience_s, self._led = patience_s, led
        self._seen_us = 0
        self._still_s = 0.0  # for so long nothing moved while this clock was looking
        self._looked_s = time.monotonic()
        self._now_us = 0

    def now_us(self) -> int:
        alone_s = max(self._still_s - self._patience_s, 0.0)
        if alone_s and self._led():
            alone_s = max(alone_s - _LED_S, 0.0)
        led_us = self._seen_us + self._lead_us + to_us(alone_s * self._paced.speed)
        self._now_us = max(self._now_us, min(self._paced.now_us(), led_us))
        return self._now_us

    def wait_until(self, t_us: int) -> None:
        self._paced.wait_until(t_us)
        self._look()
        while self.now_us() < t_us:
            time.sleep(_LOOK_S)
            self._look()

    def _look(self) -> None:
        seen_us, now_s = self._reached(), time.monotonic()
        if seen_us != self._seen_us:
            self._seen_us, self._still_s = seen_us, 0.0
        else:  # a delay of this process is no standstill of the other
            self._still_s += min(now_s - self._looked_s, _LONGEST_LOOK_S)
        self._looked_s = now_s


def wall_s() -> float:
    """Monotonic wall time in seconds, for durations shown to people."""
    return time.monotonic()


def pause(duration_s: float) -> None:
    """Let wall time pass."""
    time.sleep(duration_s)


def wall_date(after_s: float = 0.0) -> datetime:
    """UTC date and time, so long after now: for names of folders, reports, certificates."""
    return datetime.now(UTC) + timedelta(seconds=after_s)
