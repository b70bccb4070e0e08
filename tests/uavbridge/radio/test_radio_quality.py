"""Loss, bursts, delay and bandwidth: as stated, and whatever the order of asking."""

import math
from dataclasses import replace

import numpy as np
import pytest

from uavbridge.radio import Link, Quality, Queue, Radio, Transmissions, Verdict

HERE = np.zeros((1, 1, 3))


def sent(sender, tick, size=100):
    ticks = np.atleast_1d(np.asarray(tick))
    return Transmissions(
        np.full(len(ticks), sender), ticks, np.zeros((len(ticks), 3)), np.full(len(ticks), size)
    )


def lost(radio, sender, receiver, ticks):
    """(ticks, receivers) bools."""
    ids = np.atleast_1d(np.asarray(receiver))
    verdicts = radio.judge(sent(sender, np.arange(ticks)), ids, np.zeros((ticks, len(ids), 3)))
    return verdicts != Verdict.DELIVERED


@pytest.mark.parametrize("loss", [0.0, 0.1, 0.5, 1.0])
def test_losses_are_as_many_as_stated(loss):
    share = lost(Radio(math.inf, 3, Quality(loss=loss)), 1, np.arange(2, 12), 4000).mean()
    assert share == pytest.approx(loss, abs=0.01)


@pytest.mark.parametrize(("enter", "leave"), [(0.02, 0.1), (0.3, 0.3), (0.005, 0.05), (0.4, 0.6)])
def test_bursts_have_the_stated_share_and_length(enter, leave):
    radio = Radio(math.inf, 5, Quality(burst_enter=enter, burst_leave=leave))
    bad = lost(radio, 1, np.arange(2, 22), 20000)
    assert bad.mean() == pytest.approx(enter / (enter + leave), rel=0.08)
    ends = bad[:-1] & ~bad[1:]
    assert bad.sum() / ends.sum() == pytest.approx(1.0 / leave, rel=0.08)
    assert radio.quality.loss_share == pytest.approx(enter / (enter + leave))


def test_in_a_burst_a_share_gets_through():
    quality = Quality(burst_enter=0.05, burst_leave=0.05, burst_loss=0.4, loss=0.1)
    share = lost(Radio(math.inf, 1, quality), 1, np.arange(2, 12), 10000).mean()
    assert share == pytest.approx(quality.loss_share, abs=0.02)
    assert quality.loss_share == pytest.approx(1 - 0.9 * (1 - 0.5 * 0.4))


def test_draws_do_not_depend_on_what_else_is_asked():
    quality = Quality(loss=0.3, burst_enter=0.05, burst_leave=0.2, jitter_s=2.0)
    radio = Radio(math.inf, 7, quality)
    ids = np.arange(2, 8)
    everything = radio.judge(sent(1, np.arange(300)), ids, np.zeros((300, 6, 3)))
    late = radio.latency_us(sent(1, np.arange(300)), ids)
    for tick in (299, 0, 17, 131):
        for column in (5, 0, 3):
            one = sent(1, tick)
            assert radio.judge(one, ids[[column]], HERE)[0, 0] == everything[tick, column]
            assert radio.latency_us(one, ids[[column]])[0, 0] == late[tick, column]
    again = replace(radio, seed=8).judge(sent(1, np.arange(300)), ids, np.zeros((300, 6, 3)))
    assert (again != everything).any()
    back = radio.judge(sent(2, np.arange(300)), np.array([1]), np.zeros((300, 1, 3)))
    assert (back[:, 0] != everything[:, 0]).any()  # there and back are two links


def test_reasons_are_told_apart():
    quality = Quality(loss=0.2, burst_enter=0.1, burst_leave=0.2)
    radio = Radio(100.0, 1, quality)
    where = np.zeros((500, 3, 3))
    where[:, 2] = (101.0, 0, 0)
    verdicts = radio.judge(sent(1, np.arange(500)), np.array([1, 2, 3]), where)
    assert set(verdicts[:, 0]) == {Verdict.OWN}
    assert set(verdicts[:, 1]) == {Verdict.DELIVERED, Verdict.LOSS, Verdict.BURST}
    assert set(verdicts[:, 2]) == {Verdict.OUT_OF_RANGE}
    reasons = [Verdict(v).reason for v in (Verdict.OUT_OF_RANGE, Verdict.LOSS, Verdict.BURST)]
    assert [*reasons, Verdict.QUEUE.reason] == ["out of range", "loss", "burst", "queue"]


def test_delay_and_jitter_lie_where_stated():
    late = Radio(math.inf, 1, Quality(delay_s=0.5, jitter_s=1.5)).latency_us(
        sent(1, np.arange(5000)), np.array([2, 3])
    )
    assert late.min() >= 500_000
    assert late.max() < 2_000_001
    assert late.mean() == pytest.approx(1_250_000, rel=0.02)
    assert abs(np.corrcoef(late.T)[0, 1]) < 0.05


def test_links_have_numbers_of_their_own():
    links = (
        Link(receiver=3, loss=1.0),
        Link(1, 3, loss=0.0, delay_s=2.0),
        Link(2, range_m=50.0, burst_enter=0.5, burst_leave=0.5),
    )
    radio = Radio(1000.0, 1, Quality(delay_s=0.1), links)
    ids = np.array([3, 4])
    where = np.full((1, 2, 3), 40.0)
    assert radio.judge(sent(1, 5), ids, where).tolist() == [[0, 0]]
    assert radio.judge(sent(9, 5), ids, where).tolist() == [[Verdict.LOSS, 0]]
    assert radio.judge(sent(2, 5), ids[1:], where[:, 1:])[0, 0] == Verdict.OUT_OF_RANGE  # 69 m
    assert radio.latency_us(sent(1, 5), ids).tolist() == [[2_000_000, 100_000]]
    assert radio.longest_m == 1000.0
    assert not radio.delivers_at_once
    assert Radio(1000.0, links=(Link(loss=0.5),)).delivers_at_once


def test_a_link_may_reach_farther_than_all_others():
    radio = Radio(100.0, links=(Link(1, 2, range_m=500.0),))
    where = np.full((1, 2, 3), 200.0)
    assert radio.judge(sent(1, 0), np.array([2, 3]), where).tolist() == [[0, Verdict.OUT_OF_RANGE]]
    assert radio.longest_m == 500.0


def test_a_queue_takes_its_time_and_overflows():
    queue = Queue(bytes_per_s=1000.0, longest_s=0.15)
    assert queue.leaves(100, 0.0) == 100_000
    assert queue.leaves(100, 0.0) == 200_000
    assert queue.leaves(100, 0.0) is None
    assert queue.leaves(100, 60_000.0) == 300_000
    assert queue.leaves(100, 5e6) == 5_100_000


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"loss": -0.1}, "loss"),
        ({"loss": math.nan}, "loss"),
        ({"burst_enter": 1.1}, "burst_enter"),
        ({"burst_enter": 0.5, "burst_leave": 0.6}, "burst_leave"),
        ({"burst_enter": 0.5, "burst_leave": 0.0}, "burst_leave"),
        ({"delay_s": -1.0}, "delay_s"),
        ({"jitter_s": math.inf}, "jitter_s"),
        ({"bytes_per_s": 0.0}, "bytes_per_s"),
        ({"range_m": -1.0}, "range"),
    ],
)
def test_numbers_out_of_bounds_are_refused(change, name):
    with pytest.raises(ValueError, match=name):
        Quality(**change)
    with pytest.raises(ValueError, match=name):
        Radio(400.0, links=(Link(1, 2, **change),))


def test_what_is_emulated_is_said_in_short():
    assert Radio(math.inf).words() == ""
    quality = Quality(loss=0.1, burst_enter=0.01, burst_leave=0.1, delay_s=0.2, bytes_per_s=500)
    said = Radio(400.0, 1, quality, (Link(1, 2, loss=1.0),)).words()
    for part in (
        "range 400 m",
        "loss 0.1",
        "bursts of 10 ticks",
        "delay 0.2 s",
        "500 B/s",
        "1 link",
    ):
        assert part in said
