"""Which control ticks come late, and which are left out."""

from uavbridge.clock import PacedClock, SteppedClock
from uavbridge.runner.ticks import CONTROL_US, LATE_TICKS, Ticks


class Hand(PacedClock):
    """Real time, moved by hand."""

    def __init__(self):
        super().__init__()
        self.us = 0

    def now_us(self):
        return self.us

    def wait_until(self, t_us):
        self.us = max(self.us, t_us)


def walked(*busy_us):
    """A walk in which each step takes so long."""
    clock = Hand()
    ticks = Ticks(clock, clock)
    came = []
    for duration_us in busy_us:
        came.append(ticks.wait() // CONTROL_US)
        clock.us += duration_us
        ticks.done()
    return came, ticks.kept


def test_in_time():
    came, kept = walked(*[90_000] * 25)
    assert came == list(range(25))
    assert (kept.ticks, kept.late, kept.left_out) == (25, 0, 0)


def test_one_slow_step_makes_the_next_ones_late_until_it_is_made_up_for():
    came, kept = walked(450_000, *[10_000] * 9)
    assert came == list(range(10))
    # at 450, 460, 470, 480 ms: 350, 260, 170 and 80 behind
    assert (kept.ticks, kept.late, kept.left_out) == (10, 3, 0)
    assert kept.worst_s == 0.35


def test_far_behind_only_full_seconds_come():
    came, kept = walked(3_050_000, *[1_000] * 9)
    # 1 s and 2 s, then those at most LATE_TICKS old
    assert came[:3] == [0, 10, 20]
    assert came[3] == 30 - LATE_TICKS + 1
    assert kept.left_out == came[-1] + 1 - len(came)
    assert kept.late >= kept.left_out + 3
    assert kept.ticks == came[-1] + 1


def test_after_standing_still_it_goes_on_with_the_second_that_it_is():
    clock = Hand()
    ticks = Ticks(clock, clock)
    ticks.wait()
    clock.us += 15_234_000
    ticks.done()
    assert ticks.wait() == 15_000_000
    assert ticks.late_s > 14.0
    assert (ticks.kept.ticks, ticks.kept.left_out) == (151, 149)
    ticks.done()
    assert ticks.wait() == 15_100_000
    assert ticks.late_s < 0.5


def test_who_waited_long_for_a_simulation_may_have_missed_setpoints():
    paced = Hand()
    ticks = Ticks(SteppedClock(), paced)
    for stood_us, late_s in ((10_000, 0.0), (2_500_000, 2.5), (10_000, 0.0)):
        ticks.wait()
        ticks.done()
        paced.us += stood_us
        ticks.wait()
        assert ticks.late_s == late_s


def test_late_by_real_time_though_the_mission_s_own_clock_waits_for_a_simulation():
    paced = Hand()
    ticks = Ticks(SteppedClock(), paced)
    paced.us = 5_000_000
    ticks.wait()
    assert ticks.late_s == 0.0
    assert ticks.kept.late == 1
