"""The separation of tests/soak, for two seeds in every test run."""

import pytest

from tests.soak.separation import TO_ONE_POINT, closest

pytestmark = pytest.mark.integration


@pytest.mark.parametrize(("seed", "planner"), [(101, None), (102, TO_ONE_POINT)])
def test_nobody_comes_near_anybody(tmp_path, seed, planner):
    apart_m, failures, states = closest(tmp_path, seed, planner=planner, duration=70)
    assert apart_m > 5.0
    assert failures == ()
    assert states == {"landed"}


def test_without_the_filter_they_meet(tmp_path):
    apart_m, _, _ = closest(tmp_path, 102, planner=TO_ONE_POINT, separation=False, duration=70)
    assert apart_m < 5.0
