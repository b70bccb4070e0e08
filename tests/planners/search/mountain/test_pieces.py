"""The pieces that other code calls, with what others bring: lists, integers, batches, nothing."""

import doctest

import numpy as np
import pytest

from planners.search.mountain import (
    advance,
    alliance,
    avoid_steep,
    ground_plane,
    rank_members,
    surface,
    track_surface,
)
from planners.terrain import Terrain, flat

BETA = np.radians(30.0)
LEVEL = flat((0.0, 0.0, 100.0, 100.0))
PLACE = [50.0, 50.0, 0.0]


def wall(bay=False):
    """Ground at 0 with a block of 20 m in the way east, or a bay of it open to the west."""
    heights = np.zeros((101, 101))
    heights[56:66, 30:71] = 20.0
    if bay:
        heights[36:66, 30:36] = heights[36:66, 65:71] = 20.0
    return Terrain(0.0, 0.0, 1.0, heights)


@pytest.mark.parametrize("module", [alliance, surface], ids=["alliance", "surface"])
def test_the_examples_are_true(module):
    done = doctest.testmod(module)
    assert done.attempted > 0
    assert done.failed == 0


def test_nobody_ranks_nobody():
    assert rank_members([], [], [], []).shape == (0,)
    assert rank_members(np.zeros((3, 0), bool), *np.zeros((3, 3, 0))).shape == (3, 0)


def test_equals_stay_in_their_order():
    order = rank_members([1, 0, 1, 0, 0], [2, 0, 2, 0, 0], [0, 5, 0, 5, 5], [0, 1, 0, 2, 1])
    assert order.tolist() == [0, 2, 3, 1, 4]


def test_suballiances_side_by_side_rank_as_each_alone():
    draw = np.random.default_rng(1)
    first, present = draw.random((2, 4, 5, 9)) < 0.6
    numbers = draw.integers(0, 3, (3, 4, 5, 9))
    order = rank_members(first, *numbers, present)
    for row in np.ndindex(4, 5):
        alone = rank_members(first[row], *(part[row] for part in numbers), present[row])
        assert order[row].tolist() == alone.tolist()
    shared = rank_members(first, numbers[0, 0, 0], 1.0, numbers[1])
    strength, ones = np.broadcast_to(numbers[0, 0, 0], first.shape), np.ones(first.shape)
    whole = rank_members(first, strength, ones, numbers[1])
    assert (shared == whole).all()


def test_what_does_not_count_may_be_anything():
    order = rank_members([0, 1, 0], [np.nan, 2.0, np.inf], [5.0, np.nan, 3.0], [1.0, np.nan, 1.0])
    assert order.tolist() == [1, 2, 0]


def test_whole_numbers_are_not_cut_off():
    plane = ground_plane(PLACE, wall())
    turned = avoid_steep([10, 0, 0], [50, 50, 0], plane, wall(), BETA)
    assert turned == pytest.approx(avoid_steep([10.0, 0.0, 0.0], PLACE, plane, wall(), BETA))
    assert np.hypot(turned[0], turned[1]) == pytest.approx(10.0)
    assert track_surface([3, 4, 9], plane, 10, True) == pytest.approx([6.0, 8.0, 0.0])


def test_level_ground_turns_nothing_and_nobody_is_turned():
    velocity = np.array([3.0, -4.0, 0.0])
    turned = avoid_steep(velocity, PLACE, ground_plane(PLACE, LEVEL), LEVEL, BETA)
    assert (turned == velocity).all()
    turned[0] = 7.0
    assert velocity[0] == 3.0, "a new array"
    none = np.zeros((2, 0, 3))
    assert avoid_steep(none, none, ground_plane(none, LEVEL), LEVEL, BETA).shape == (2, 0, 3)
    assert track_surface(none, ground_plane(none, LEVEL), 10.0, False).shape == (2, 0, 3)


def test_one_robot_with_many_wishes_and_many_robots_with_one():
    ground, wishes = wall(), np.array([[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [-10.0, 0.0, 0.0]])
    places = np.array([PLACE, [10.0, 10.0, 0.0]])
    for velocity, position in ((wishes, PLACE), (wishes[0], places), (wishes[:, None], places)):
        plane = ground_plane(position, ground)
        both = np.broadcast_arrays(velocity, position)
        turned = avoid_steep(velocity, position, plane, ground, BETA)
        tangent = track_surface(velocity, plane, 10.0, True)
        assert turned.shape == tangent.shape == both[0].shape
        for row in np.ndindex(turned.shape[:-1]):
            wish, place = both[0][row], both[1][row]
            alone = avoid_steep(wish, place, ground_plane(place, ground), ground, BETA)
            assert turned[row] == pytest.approx(alone)


def test_velocities_that_are_none():
    with pytest.raises(ValueError, match="must be finite"):
        avoid_steep([np.nan, 0.0, 0.0], PLACE, ground_plane(PLACE, LEVEL), LEVEL, BETA)


@pytest.mark.parametrize(("bay", "arrives"), [(False, True), (True, False)])
def test_a_target_behind_a_steep_zone(bay, arrives):
    """Round a block, turned step by step; a bay holds it, as it looks one step ahead."""
    ground, target, place = wall(bay), np.array([90.0, 20.0, 0.0]), np.array(PLACE)
    for _ in range(200):
        wish = target - place
        plane = ground_plane(place, ground)
        velocity = track_surface(wish, plane, 4.0, False)
        velocity = avoid_steep(velocity, place, plane, ground, BETA)
        driven, place = advance(place, velocity, ground)
        assert driven[2] <= np.tan(BETA) * np.hypot(driven[0], driven[1]) + 1e-6
    assert (np.hypot(*(target - place)[:2]) < 4.0) == arrives
