import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from uavbridge.radio import Radio, Transmissions, Verdict

coordinates = st.floats(-1e5, 1e5)
points = hnp.arrays(np.float64, (5, 3), elements=coordinates)
ranges = st.floats(0, 1e6)


@given(points, ranges)
def test_links_are_symmetric(positions: np.ndarray, range_m: float) -> None:
    reach = Radio(range_m).reaches(positions[:, None], positions[None])
    assert np.array_equal(reach, reach.T)


@given(points, ranges, ranges)
def test_a_longer_range_loses_no_link(positions: np.ndarray, a: float, b: float) -> None:
    short, long = sorted((a, b))
    near = Radio(short).reaches(positions[0], positions)
    far = Radio(long).reaches(positions[0], positions)
    assert np.all(far[near])
    assert np.all(Radio(math.inf).reaches(positions[0], positions))


@given(points, ranges)
def test_many_links_at_once_are_as_one_by_one(positions: np.ndarray, range_m: float) -> None:
    radio = Radio(range_m)
    one_by_one = [bool(radio.reaches(positions[0], p)) for p in positions]
    assert radio.reaches(positions[0], positions).tolist() == one_by_one
    assert one_by_one[0]


@pytest.mark.parametrize(("distance_m", "heard"), [(0.0, True), (400.0, True), (400.001, False)])
def test_range_is_inclusive_and_counts_height(distance_m: float, heard: bool) -> None:
    for axis in range(3):
        there = np.zeros(3)
        there[axis] = distance_m
        assert bool(Radio(400.0).reaches(np.zeros(3), there)) is heard


def test_range_zero_reaches_only_the_same_place() -> None:
    there = [[0, 0, 0], [0, 0, 1e-9]]
    assert Radio(0.0).reaches([0, 0, 0], there).tolist() == [True, False]


@pytest.mark.parametrize("range_m", [-1.0, -1e-9, math.nan, -math.inf])
def test_a_range_that_is_none_is_refused(range_m: float) -> None:
    with pytest.raises(ValueError, match="range"):
        Radio(range_m)


def test_a_position_that_is_not_a_number_is_out_of_range() -> None:
    assert not Radio(400.0).reaches([math.nan, 0, 0], [[0, 0, 0]]).any()


def test_nobody_hears_itself_and_the_order_of_arrival_changes_nothing() -> None:
    ids = np.array([3, 1, 2])
    place = np.array([[0.0, 0, 0], [300, 0, 0], [600, 0, 0]])
    sent = Transmissions(ids, np.zeros(3, np.int64), place, np.full(3, 52))
    verdicts = Radio(400.0).judge(sent, ids, np.broadcast_to(place, (3, 3, 3)))
    own, ok, far = Verdict.OWN, Verdict.DELIVERED, Verdict.OUT_OF_RANGE
    assert verdicts.tolist() == [[own, ok, far], [ok, own, ok], [far, ok, own]]
    turn = np.array([2, 0, 1])
    turned = Transmissions(ids[turn], sent.tick, place[turn], sent.size)
    again = Radio(400.0).judge(turned, ids, np.broadcast_to(place, (3, 3, 3)))
    assert np.array_equal(again, verdicts[turn])
    assert far.reason == "out of range"
