"""A hundred seeds: nobody comes within 5 m of anybody, in any phase."""

import pytest

from planners.registry import BUILTIN
from tests.soak.separation import MAD, TO_ONE_POINT, closest, fly

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


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("planner", [*BUILTIN, MAD, TO_ONE_POINT])
def test_homes_side_by_side_in_a_storm(tmp_path, seed, planner):
    result = fly(tmp_path, seed, planner=planner, duration=80, spacing=10.0, wind=6.0, gust=3.0)
    assert result.min_separation_m > LIMIT_M
    assert result.failures == ()
    assert {agent.state for agent in result.agents} == {"landed"}


@pytest.mark.parametrize("seed", range(20))
def test_a_mad_planner_leaves_nobody_outside_the_fence(tmp_path, seed):
    result = fly(tmp_path, seed, planner=MAD, duration=100, spacing=12.0)
    assert result.min_separation_m > LIMIT_M
    assert result.failures == ()
    for track in result.tracks.values():
        assert track[:, :2].min() > -51.5
        assert track[:, :2].max() < 291.5
        assert track[:, 2].max() < 76.0


@pytest.mark.parametrize("planner", ["esustpm", TO_ONE_POINT])
def test_without_the_filter_they_meet(tmp_path, planner):
    apart = [
        closest(tmp_path, seed, planner=planner, separation=False, duration=90)[0]
        for seed in range(5)
    ]
    assert min(apart) < LIMIT_M
