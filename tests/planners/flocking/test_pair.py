"""Liu 2022, Eqs. (7)-(9)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.flocking.pair import PairLaw, beta, nearest, pull

LAW = PairLaw()


def test_beta_repels_inside_and_attracts_outside():
    inside, outside = np.linspace(60.0, 112.0, 53), np.linspace(128.0, 180.0, 53)
    assert (beta(inside, LAW) > 0).all()
    assert (beta(outside, LAW) < 0).all()


def test_beta_is_zero_and_flat_at_the_centre():
    assert beta(120.0, LAW) == 0.0
    assert abs(beta([120.001, 119.999], LAW)).max() / 0.001 < 1e-2


def test_beta_dies_out_far_away_and_at_contact():
    assert abs(beta([250.0, 1000.0], LAW)).max() < 10.0
    assert abs(beta([0.0, 10.0], LAW)).max() < 30.0


def test_greatest_strength():
    distance = np.arange(0.0, 300.0, 0.01)
    strength = abs(beta(distance, LAW))
    assert strength.max() == pytest.approx(6860, abs=1)
    assert abs(distance[strength.argmax()] - 120.0) == pytest.approx(28.3, abs=0.1)


@given(st.floats(1.0, 119.0))
def test_beta_is_odd_about_the_centre(off):
    assert beta(120.0 + off, LAW) == pytest.approx(-beta(120.0 - off, LAW), abs=1e-9)


def test_pull_points_away_from_a_close_neighbour_and_to_a_distant_one():
    here, both = np.zeros(2), np.ones(1, bool)
    close = pull(here, np.array([[90.0, 0.0]]), both, LAW, 3)
    distant = pull(here, np.array([[150.0, 0.0]]), both, LAW, 3)
    assert close[0] < -1000
    assert distant[0] > 1000
    assert close[1] == distant[1] == 0.0


def test_only_the_closest_heard_count():
    others = np.array([[90.0, 0.0], [0.0, 91.0], [-92.0, 0.0], [0.0, -93.0]])
    full = pull(np.zeros(2), others, np.ones(4, bool), LAW, 3)
    assert full == pytest.approx(pull(np.zeros(2), others[:3], np.ones(3, bool), LAW, 3))
    deaf = pull(np.zeros(2), others, np.array([False, True, True, True]), LAW, 3)
    assert deaf == pytest.approx(pull(np.zeros(2), others[1:], np.ones(3, bool), LAW, 3))


def test_nobody_and_a_neighbour_on_the_same_point_pull_nowhere():
    assert pull(np.zeros(2), np.zeros((0, 2)), np.zeros(0, bool), LAW, 3).tolist() == [0, 0]
    assert pull(np.zeros(2), np.zeros((2, 2)), np.ones(2, bool), LAW, 3).tolist() == [0, 0]


def test_of_equally_near_the_first_is_nearest():
    assert nearest(np.array([5.0, 5.0, 5.0, 4.0]), 2).tolist() == [True, False, False, True]
    assert nearest(np.array([np.inf, 5.0]), 2).tolist() == [False, True]


def test_a_batch_equals_its_single_agents():
    rng = np.random.default_rng(3)
    here, others = rng.uniform(0, 300, (4, 5, 2)), rng.uniform(0, 300, (4, 5, 6, 2))
    present = rng.random((4, 5, 6)) < 0.7
    batch = pull(here, others, present, LAW, 3)
    for at in np.ndindex(4, 5):
        assert batch[at] == pytest.approx(pull(here[at], others[at], present[at], LAW, 3))
