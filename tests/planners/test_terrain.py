"""Heights, gradients and lines of sight of the one terrain."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.memory import dumps, loads
from planners.terrain import Terrain, check_places, flat, mountains, steep_share

BOUNDS = (-100.0, 50.0, 400.0, 450.0)


def plane(east=0.3, north=-0.2, height=7.0):
    x, y = np.meshgrid(-100.0 + 10.0 * np.arange(51), 50.0 + 10.0 * np.arange(41), indexing="ij")
    return Terrain(-100.0, 50.0, 10.0, height + east * x + north * y)


@given(st.floats(-100.0, 400.0), st.floats(50.0, 450.0))
def test_a_plane_is_a_plane(x, y):
    assert plane().height_at((x, y)) == pytest.approx(7.0 + 0.3 * x - 0.2 * y, abs=1e-9)
    assert plane().gradient_at((x, y)) == pytest.approx((0.3, -0.2), abs=1e-9)
    assert plane().slope_at((x, y)) == pytest.approx(np.arctan(np.hypot(0.3, 0.2)))


def test_lattice_points_and_any_leading_axes():
    draw = np.random.default_rng(1)
    terrain = Terrain(0.0, 0.0, 2.0, draw.normal(size=(7, 5)))
    points = np.stack(np.meshgrid(2.0 * np.arange(7), 2.0 * np.arange(5), indexing="ij"), -1)
    assert terrain.height_at(points) == pytest.approx(terrain.heights)
    assert terrain.height_at((3.0, 0.0)) == pytest.approx(terrain.heights[1:3, 0].mean())
    assert terrain.height_at((-50.0, -50.0)) == terrain.heights[0, 0], "the edge counts outside"
    assert list(terrain.contains([(0, 0), (12, 8), (12.1, 0)])) == [True, True, False]


@settings(max_examples=15)
@given(st.integers(0, 10**6), st.floats(0.05, 1.2))
def test_mountains_have_the_largest_slope_asked_for(seed, steepest):
    terrain = mountains(np.random.default_rng(seed), BOUNDS, steepest, cell_m=10.0)
    assert terrain.steepest() == pytest.approx(steepest)
    assert terrain.heights.min() == 0.0
    points = np.random.default_rng(seed).uniform(BOUNDS[:2], BOUNDS[2:], (500, 2))
    assert (terrain.slope_at(points) <= steepest + 1e-9).all()
    there = points + np.random.default_rng(seed + 1).normal(0.0, 30.0, points.shape)
    inside = terrain.contains(there)
    rise = terrain.height_at(there[inside]) - terrain.height_at(points[inside])
    far = np.linalg.norm((there - points)[inside], axis=1)
    assert (abs(rise) <= np.tan(steepest) * far + 1e-9).all(), "nor between any two places"
    assert 0.0 < steep_share(terrain, 0.8 * steepest) < 1.0


def test_the_same_seed_gives_the_same_mountains():
    one, other = (mountains(np.random.default_rng(4), BOUNDS, 0.5) for _ in range(2))
    assert (one.heights == other.heights).all()
    assert not (one.heights == mountains(np.random.default_rng(5), BOUNDS, 0.5).heights).all()


def test_a_ridge_hides_what_is_behind_it():
    heights = np.zeros((21, 3))
    heights[10] = 10.0
    ridge = Terrain(0.0, 0.0, 5.0, heights)
    low, high = (0.0, 5.0, 2.0), (0.0, 5.0, 30.0)
    far = [(100.0, 5.0, 2.0), (100.0, 5.0, 30.0), (40.0, 5.0, 2.0)]
    assert list(ridge.sees(low, far)) == [False, True, True]
    assert list(ridge.sees(far, low)) == [False, True, True], "sight is mutual"
    assert ridge.sees(high, high)
    assert flat(BOUNDS).sees((0, 60, 0), (300, 400, 0))


def test_a_part_of_the_terrain_is_the_terrain_there():
    terrain = mountains(np.random.default_rng(2), BOUNDS, 0.6)
    part = terrain.around((120.0, 300.0), 40.0)
    points = np.random.default_rng(0).uniform((80.0, 260.0), (160.0, 340.0), (100, 2))
    assert part.contains(points).all()
    assert part.height_at(points) == pytest.approx(terrain.height_at(points))
    assert part.heights.size < 0.1 * terrain.heights.size
    assert terrain.around((1e6, -1e6), 1.0).heights.shape >= (2, 2)
    assert (loads(Terrain, dumps(part)).heights == part.heights).all()


@pytest.mark.parametrize(
    ("cell", "heights", "words"),
    [
        (0.0, np.zeros((3, 3)), "spacing must be positive, not 0"),
        (1.0, np.zeros((1, 3)), "at least 2 x 2 heights, not 1 x 3"),
        (1.0, np.zeros(9), "at least 2 x 2"),
        (1.0, np.array([[0, 1], [np.nan, 2]]), "1 of 4 heights are missing, .* column 1, row 0"),
    ],
)
def test_what_is_no_terrain(cell, heights, words):
    with pytest.raises(ValueError, match=words):
        Terrain(0.0, 0.0, cell, heights)


def test_what_lies_nowhere():
    with pytest.raises(ValueError, match="terrain: lies at no place"):
        Terrain(0.0, float("nan"), 1.0, np.zeros((2, 2)))


@pytest.mark.parametrize(
    "change",
    [
        {"steepest_rad": 1.6},
        {"hills": 0},
        {"width_m": (0.0, 1.0)},
        {"cell_m": 0.0},
        {"cell_m": float("nan")},
        {"bounds": (0.0, 0.0, 0.0, 10.0)},
        {"bounds": (0.0, 0.0, float("inf"), 10.0)},
    ],
)
def test_what_are_no_mountains(change):
    usual = {"bounds": BOUNDS, "steepest_rad": 0.5}
    with pytest.raises(ValueError, match="terrain: "):
        mountains(np.random.default_rng(0), **{**usual, **change})


def test_places_to_stand_on():
    alpha = np.arctan(np.hypot(0.3, 0.2))
    check_places(plane(), "start", [(0.0, 100.0), (400.0, 450.0)], alpha + 1e-9)
    with pytest.raises(ValueError, match=r"start 2 at \(401, 60\) is off the terrain \(-100 to"):
        check_places(plane(), "start", [(0.0, 100.0), (401.0, 60.0)], np.pi / 2)
    with pytest.raises(ValueError, match=r"target 1 at .* slope of 19.8 degrees, above 10.0"):
        check_places(plane(), "target", [(0.0, 100.0)], np.radians(10.0))
