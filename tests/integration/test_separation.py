"""The separation of tests/soak, for two seeds in every test run."""

import pytest

from tests.soak.separation import MAD, TO_ONE_POINT, closest, fly

pytestmark = pytest.mark.integration


@pytest.mark.parametrize(("seed", "planner"), [(101, "esustpm"), (102, TO_ONE_POINT)])
def test_nobody_comes_near_anybody(tmp_path, seed, planner):
    apart_m, failures, states = closest(tmp_path, seed, planner=planner, duration=70)
    assert apart_m > 5.0
    assert failures == ()
    assert states == {"landed"}


def test_without_the_filter_they_meet(tmp_path):
    apart_m, _, _ = closest(tmp_path, 102, planner=TO_ONE_POINT, separation=False, duration=70)
    assert apart_m < 5.0


@pytest.mark.soak
def test_homes_side_by_side_and_a_mad_planner(tmp_path):
    result = fly(tmp_path, 103, planner=MAD, duration=40, spacing=10.0, wind=6.0, gust=3.0)
    assert result.min_separation_m > 5.0
    assert result.failures == ()
    assert {agent.state for agent in result.agents} == {"landed"}
