"""Mission time that waits for a simulation."""

from __future__ import annotations

from itertools import count

from uavbridge.clock import LedClock, PacedClock

FAST = 1e6  # mission seconds per second: always far ahead


def test_it_stays_with_the_simulation() -> None:
    steps = count(0, 100)
    clock = LedClock(PacedClock(FAST), lambda: next(steps), lead_us=50)
    clock.wait_until(1000)
    assert 1000 <= clock.now_us() <= 1050


def test_it_never_goes_back() -> None:
    positions = iter([500, 100, 100, 600])
    clock = LedClock(PacedClock(FAST), lambda: next(positions), lead_us=0)
    clock.wait_until(500)
    clock.wait_until(500)
    assert clock.now_us() == 500


def test_a_simulation_that_stands_still_is_left_behind() -> None:
    clock = LedClock(PacedClock(FAST), lambda: 0, lead_us=0, patience_s=0.01)
    clock.wait_until(1_000_000)
    assert clock.now_us() >= 1_000_000


def test_it_is_no_faster_than_its_pace() -> None:
    clock = LedClock(PacedClock(1e-3), lambda: 1_000_000, lead_us=0)
    assert clock.now_us() < 1000
