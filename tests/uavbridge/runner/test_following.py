"""A clock that follows the launcher's."""

import pytest

from uavbridge.clock import PacedClock
from uavbridge.runner.briefing import Agreement
from uavbridge.runner.following import SLEW, Following

START_NS = 5_000_000_000


def following(*, speed=1.0):
    return Following(None, PacedClock(speed), Agreement(START_NS, 0.0005, 0.04))


def stepped(one, ticks):
    moved = []
    for _ in range(ticks):
        before = one._paced.epoch_ns
        one.step()
        moved.append(one._paced.epoch_ns - before)
    return moved


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_drift_is_made_up_for_slowly_and_then_it_rests(sign):
    one = following()
    one.newest = Agreement(START_NS + sign * 3_000_000, 0.0005, 0.04)
    assert one.offset_s == pytest.approx(sign * 0.003)
    moved = stepped(one, 100)
    assert max(map(abs, moved)) <= SLEW * 100_000_000  # of a tick's 0.1 s
    assert abs(one.offset_s) <= 0.0005
    assert moved[-1] == 0


def test_what_may_be_an_error_of_the_question_changes_nothing():
    one = following()
    one.newest = Agreement(START_NS + 400_000, 0.0005, 0.0)
    assert not any(stepped(one, 10))


def test_a_fast_mission_is_followed_in_wall_time():
    slow, fast = following(), following(speed=10.0)
    for one in (slow, fast):
        one.newest = Agreement(START_NS + 50_000_000, 0.0005, 0.0)
    assert sum(stepped(slow, 10)) == 10 * sum(stepped(fast, 10))


def test_what_is_reported():
    one = following()
    one.newest = Agreement(START_NS - 2_000_000, 0.0005, -1.25)
    told = one.clocks
    assert (told.offset_s, told.error_s, told.date_offset_s) == (-0.002, 0.0005, -1.25)
