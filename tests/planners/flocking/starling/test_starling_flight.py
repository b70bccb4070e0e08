import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.flocking.starling import prediction, ridge, route, wing
from planners.flocking.starling.flock import Flock, Setting, update
from planners.flocking.starling.prediction import Foresight
from planners.flocking.starling.ridge import Watch
from planners.flocking.starling.route import RouteRules
from planners.flocking.starling.rules import StarlingRules
from planners.flocking.starling.wing import Wing
from planners.paths.ground import path_gap
from planners.terrain import Terrain

WING = Wing()


def hill(height=400.0, x=1000.0, y=0.0, width=150.0):
    """One hill on level ground, 3 km by 2 km."""
    east = np.arange(151) * 20.0
    north = -1000.0 + np.arange(101) * 20.0
    bump = np.exp(-0.5 * (((east - x) / width)[:, None] ** 2 + ((north - y) / width) ** 2))
    return Terrain(0.0, -1000.0, 20.0, height * bump)


vectors = st.tuples(*[st.floats(-60.0, 60.0)] * 3)


@settings(max_examples=80)
@given(st.tuples(st.floats(20.0, 99.0), st.floats(-3.0, 3.0), st.floats(-0.3, 0.5)), vectors)
def test_what_is_flown_stays_within_the_limits(motion, wanted):
    velocity = wing.whole(*(np.array([part]) for part in motion))
    after = wing.flown(velocity, np.array([wanted]), WING, 0.1)
    speed, course, climb = wing.parts(after)
    assert WING.slowest_m_s - 1e-9 <= speed[0] <= WING.fastest_m_s + 1e-9
    assert -WING.sink_rad - 1e-9 <= climb[0] <= WING.climb_rad + 1e-9
    turn = math.remainder(course[0] - motion[1], math.tau)
    level = motion[0] * math.cos(motion[2])
    assert abs(turn) <= WING.across_m_s2 / level * 0.1 * (1 + 1e-6)


def test_a_wish_within_the_limits_is_flown_as_it_is():
    velocity = np.array([[50.0, 0.0, 0.0]])
    wish = np.array([[2.0, 3.0, 1.0]])
    after = wing.flown(velocity, wish, WING, 0.01)
    assert np.allclose(after, velocity + wish * 0.01, atol=1e-3)


def test_the_radius_is_that_of_equation_twelve():
    assert Wing(bank_rad=math.radians(30.0)).radius(50.0) == pytest.approx(441.0, abs=1.0)
    assert Wing(bank_rad=math.radians(60.0)).radius(50.0) == pytest.approx(147.0, abs=1.0)


def test_over_level_ground_nothing_is_escaped_from():
    ground = hill(0.0)
    place, pace = np.array([[100.0, 0.0, 80.0]]), np.array([[50.0, 0.0, 0.0]])
    wish = np.array([[0.5, 1.0, 0.0]])
    after, blocked = ridge.avoid(place, pace, wish, ground, WING, Watch())
    assert np.array_equal(after, wish)
    assert not blocked.any()


@pytest.mark.parametrize("height", [90.0, 400.0])
@pytest.mark.parametrize("offset", [-120.0, 0.0, 60.0])
def test_a_hill_ahead_is_passed_by_or_over(height, offset):
    ground = hill(height)
    watch = Watch()
    place, pace = np.array([[50.0, offset, 60.0]]), np.array([[50.0, 0.0, 0.0]])
    least, changed = math.inf, 0
    for _ in range(450):
        wish = 0.4 * (50.0 * np.array([[1.0, 0.0, 0.0]]) - pace)
        wish, blocked = ridge.avoid(place, pace, wish, ground, WING, watch)
        changed += int(blocked[0])
        after = wing.flown(pace, wish, WING, 0.1)
        place, pace = place + (pace + after) * 0.05, after
        least = min(least, float((place[:, 2] - ground.height_at(place))[0]))
    assert least > watch.clearance_m - 5.0
    assert changed > 0


def test_widened_ground_is_the_highest_nearby():
    heights = np.zeros((11, 9))
    heights[5, 4] = 7.0
    wide = route.widened(Terrain(0.0, 0.0, 10.0, heights), 20.0)
    assert wide.heights.shape == heights.shape
    assert wide.heights[3, 4] == wide.heights[5, 6] == wide.heights[6, 5] == 7.0
    assert wide.heights[3, 3] == wide.heights[2, 4] == 0.0
    assert (wide.heights >= heights).all()


def test_a_way_leads_around_the_hill_and_is_better_than_none():
    ground = hill()
    rules = RouteRules(step_m=100.0)
    start, aim = np.array([50.0, 0.0, 100.0]), np.array([2800.0, 0.0, 100.0])
    way = route.plan(
        route.widened(ground, 60.0),
        start,
        0.0,
        aim,
        rules,
        WING,
        50.0,
        np.random.default_rng(1),
    )
    assert np.allclose(way[[0, -1]], [start, aim])
    assert not route.blocked(ground, way, rules.clearance_m)
    assert route.blocked(ground, np.stack((start, aim)), rules.clearance_m)
    assert route.score(way, 0.0, WING, 50.0) >= 2750.0


def test_a_way_that_turns_back_costs_more():
    straight = np.array([[0.0, 0, 100], [1000, 0, 100], [2000, 0, 100]])
    bent = np.array([[0.0, 0, 100], [1000, 300, 100], [2000, 0, 100]])
    assert route.score(straight, 0.0, WING, 50.0) == pytest.approx(2000.0)
    assert route.score(bent, 0.0, WING, 50.0) > 2000.0
    assert route.score(straight, math.pi, WING, 50.0) > 2700.0


def test_ahead_goes_along_the_way_and_straight_on_at_its_end():
    way = np.array([[0.0, 0, 0], [100, 0, 0], [100, 100, 0]])
    places = np.array([[10.0, 5.0, 0.0], [90.0, 3.0, 0.0], [100.0, 90.0, 0.0]])
    points = route.ahead(way, places, 30.0)
    assert np.allclose(points, [[40, 0, 0], [100, 20, 0], [100, 120, 0]])


def test_remaining_starts_beside_the_way():
    way = np.array([[0.0, 0, 0], [100, 0, 0], [100, 100, 0]])
    left = route.remaining(way, np.array([50.0, 10.0, 0.0]))
    assert np.allclose(left, [[50, 10, 0], [100, 0, 0], [100, 100, 0]])
    past = route.remaining(way, np.array([110.0, 130.0, 0.0]))
    assert np.allclose(past, [[110, 130, 0], [110, 131, 0]])


def in_flight(count=5, seed=3):
    rng = np.random.default_rng(seed)
    position = rng.uniform(0.0, 90.0, (count, 3)) + np.array((300.0, -45.0, 60.0))
    return Flock.of(position, np.tile([50.0, 0.0, 0.0], (count, 1)))


def setting(ground, rules=None):
    aim = np.array([2800.0, 0.0, 100.0])
    wide = route.widened(ground, 100.0)
    return Setting(rules or StarlingRules(), WING, Watch(), ground, wide, aim)


def test_an_update_changes_nothing_it_is_given_and_needs_no_neighbour():
    ground = hill()
    flock = in_flight(1)
    for part in (flock.position, flock.velocity, flock.danger_s, flock.alarm_s):
        part.setflags(write=False)
    towards = np.array([[2800.0, 0.0, 100.0]])
    done = update(
        flock, towards, np.zeros((0, 3)), np.zeros(1), np.zeros((1, 3)), setting(ground), 0.1
    )
    assert np.isfinite(done.acceleration).all()
    assert done.acceleration.shape == (1, 3)


def test_high_ground_beside_makes_danger_space_for_all():
    ground = hill(y=150.0)
    flock = in_flight(6)
    near = Flock.of(flock.position + np.array((620.0, -60.0, 0.0)), flock.velocity)
    args = np.zeros((0, 3)), np.zeros(6), np.zeros((6, 3)), setting(ground), 0.1
    far = update(flock, flock.position + np.array((300.0, 0.0, 0.0)), *args)
    close = update(near, near.position + np.array((300.0, 0.0, 0.0)), *args)
    assert np.isinf(far.danger_s).all()
    assert (close.danger_s < 1.0).any()


def test_the_prefix_is_what_a_period_flies_and_a_node_at_least():
    points = np.array([[0.0, 0, 0], [30, 0, 0], [60, 0, 0], [90, 0, 0]])
    assert len(prediction.prefix(points, 50.0, 1.5)) == 3  # Eq. (31): 60 m of 75
    assert len(prediction.prefix(points, 10.0, 1.0)) == 2


def test_prediction_finds_a_branch_that_can_be_flown():
    ground = hill()
    flock, seed = in_flight(4), np.random.default_rng(5)
    foresight = Foresight(nodes=16, learning=2, ways=1)
    branch = prediction.predict(1, flock, setting(ground), foresight, 0.0, None, seed)
    assert branch.kind in ("learning", "rrt")
    assert np.allclose(branch.points[0], flock.position[1])
    assert path_gap(ground, branch.points) >= Watch().clearance_m - 1e-6
    kept = prediction.predict(1, flock, setting(ground), foresight, 0.0, branch, seed)
    assert kept.kind == "kept" or kept.cost < branch.cost * 0.93


def test_learning_branches_die_out_in_danger():
    """Eq. (32): after t_e only RRT ways are left."""
    flock, seed = in_flight(3), np.random.default_rng(5)
    foresight = Foresight(nodes=8, learning=3, ways=1, learning_s=10.0)
    kinds = {
        prediction.predict(0, flock, setting(hill()), foresight, unsafe, None, seed).kind
        for unsafe in (10.0, 30.0)
    }
    assert kinds == {"rrt"}
