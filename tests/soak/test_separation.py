"""A hundred seeds: nobody comes within 5 m of anybody, in any phase."""

import pytest

from tests.soak.separation import TO_ONE_POINT, closest

pytestmark = pytest.mark.soak
LIMIT_M = 5.0


@pytest.mark.parametrize("seed", range(100))
def test_a_search_at_one_altitude(tmp_path, seed):
    apart_m, failures, states = closest(tmp_path, seed)
    assert apart_m > LIMIT_M
    assert failures == ()
    assert states == {"landed"}


@pytest.mark.parametrize("seed", range(100))
def test_everybody_sent_to_one_point(tmp_path, seed):
    apart_m, failures, states = closest(tmp_path, seed, planner=TO_ONE_POINT, duration=90)
    assert apart_m > LIMIT_M
    assert failures == ()
    assert states == {"landed"}


@pytest.mark.parametrize("planner", [None, TO_ONE_POINT])
def test_without_the_filter_they_meet(tmp_path, planner):
    apart = [
        closest(tmp_path, seed, planner=planner, separation=False, duration=90)[0]
        for seed in range(5)
    ]
    assert min(apart) < LIMIT_M
