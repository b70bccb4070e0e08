"""3D-COTA: tangent velocities, slopes that are not climbed, robots on the ground."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.search.mountain import advance, avoid_steep, ground_plane, track_surface
from planners.search.mountain.surface import reflected
from planners.terrain import Terrain, mountains

BETA = math.radians(30.0)
BOUNDS = (0.0, 0.0, 400.0, 400.0)


def incline(slope_rad):
    """A plane that rises to the east."""
    heights = np.repeat(np.tan(slope_rad) * 10.0 * np.arange(41)[:, None], 41, axis=1)
    return Terrain(0.0, 0.0, 10.0, heights)


def on(terrain, xy):
    xy = np.asarray(xy, dtype=float)
    return np.concatenate((xy, terrain.height_at(xy)[..., None]), axis=-1)


def tracked(terrain, place, expected, roams=True):
    plane = ground_plane(place, terrain, 1.0)
    velocity = track_surface(expected, plane, 10.0, np.asarray(roams))
    return plane, velocity, avoid_steep(velocity, place, plane, terrain, BETA)


@given(
    st.floats(100.0, 300.0),
    st.floats(100.0, 300.0),
    st.floats(-math.pi, math.pi),
    st.floats(0.0, 1.4),
)
def test_first_tracking_is_tangent_to_a_plane(x, y, heading, slope):
    terrain = incline(slope)
    place = on(terrain, (x, y))
    way = np.array((math.cos(heading), math.sin(heading), 0.7))
    _, velocity, _ = tracked(terrain, place, 10.0 * way)
    normal = np.array((-math.tan(slope), 0.0, 1.0))
    assert velocity @ normal == pytest.approx(0.0, abs=1e-6)
    assert np.linalg.norm(velocity) == pytest.approx(10.0), "roaming speed is Vm"


def test_on_an_obstacle_point_the_three_points_stay_apart():
    plane = ground_plane(on(incline(0.4), (20.0, 30.0)), incline(0.4), 1.0)
    assert abs(plane.c) == 1.0


def test_members_are_held_to_the_speed_and_no_faster():
    terrain = incline(0.4)
    place = on(terrain, [(50.0, 50.0), (60.0, 60.0), (70.0, 70.0)])
    expected = np.array([(1.0, 2.0, 5.0), (20.0, 0.0, 0.0), (0.0, 0.0, 0.0)])
    _, velocity, _ = tracked(terrain, place, expected, roams=False)
    assert velocity[0] == pytest.approx((1.0, 2.0, math.tan(0.4)))
    assert np.linalg.norm(velocity[1]) == pytest.approx(10.0)
    assert (velocity[2] == 0.0).all()


@settings(max_examples=10)
@given(st.integers(0, 10**6))
def test_where_nothing_is_too_steep_nothing_is_turned(seed):
    draw = np.random.default_rng(seed)
    terrain = mountains(draw, BOUNDS, BETA)
    place = on(terrain, draw.uniform(20.0, 380.0, (4, 50, 2)))
    _, velocity, turned = tracked(terrain, place, draw.normal(0.0, 10.0, (4, 50, 3)))
    assert (turned == velocity).all()


@pytest.mark.parametrize("slope_deg", [31.0, 35.0, 40.0, 60.0])
def test_straight_uphill_turns_to_the_first_whole_degree_that_is_allowed(slope_deg):
    terrain = incline(math.radians(slope_deg))
    place = on(terrain, (200.0, 200.0))
    _, _, turned = tracked(terrain, place, np.array((10.0, 0.0, 0.0)))
    allowed = math.degrees(math.acos(math.tan(BETA) / math.tan(math.radians(slope_deg))))
    heading = math.degrees(math.atan2(turned[1], turned[0]))
    assert abs(heading) == pytest.approx(math.ceil(allowed), abs=1e-9)
    climb = math.atan2(turned[2], math.hypot(turned[0], turned[1]))
    assert climb <= BETA + 1e-9


def test_down_any_slope_and_along_it():
    terrain = incline(math.radians(39.0))
    place = on(terrain, [(200.0, 200.0), (200.0, 200.0)])
    _, velocity, turned = tracked(terrain, place, np.array([(-5.0, 1.0, 0.0), (0.0, 5.0, 0.0)]))
    assert (turned == velocity).all()


@settings(max_examples=10)
@given(st.integers(0, 10**6))
def test_no_step_climbs_more_than_beta_or_leaves(seed):
    draw = np.random.default_rng(seed)
    terrain = mountains(draw, BOUNDS, math.radians(55.0))
    place = on(terrain, draw.uniform(0.0, 400.0, (200, 2)))
    plane = ground_plane(place, terrain, 1.0)
    expected = draw.normal(0.0, 10.0, (200, 3))
    velocity = track_surface(expected, plane, 10.0, np.ones(200, bool))
    turned = avoid_steep(velocity, place, plane, terrain, BETA, bounds=BOUNDS)
    driven, there = advance(place, turned, terrain)
    level = np.hypot(driven[:, 0], driven[:, 1])
    assert (driven[:, 2] <= np.tan(BETA) * level + 1e-6).all()
    assert terrain.contains(np.round(there, 6)).all()
    assert there[:, 2] == pytest.approx(terrain.height_at(there)), "on the surface after Eq. (28)"
    assert (np.hypot(turned[:, 0], turned[:, 1]) <= 10.0 + 1e-9).all()


def test_in_a_pit_a_robot_stays():
    x, y = np.meshgrid(np.arange(-50.0, 51.0), np.arange(-50.0, 51.0), indexing="ij")
    pit = Terrain(-50.0, -50.0, 1.0, 2.0 * np.hypot(x, y))
    place = on(pit, (0.0, 0.0))
    plane = ground_plane(place, pit, 1.0)
    still = avoid_steep(np.array((10.0, 0.0, 0.0)), place, plane, pit, BETA)
    assert (still == 0.0).all()


@pytest.mark.parametrize(("reading", "x"), [("reflect", -6.0), ("clip", 3.0)])
def test_the_boundary(reading, x):
    place, velocity = np.array((397.0, 10.0, 0.0)), np.array((6.0, -4.0, 1.0))
    assert reflected(place, velocity, BOUNDS, reading) == pytest.approx((x, -4.0, 1.0))
