import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.paths import rrt
from planners.paths.ground import gaps, path_gap
from planners.terrain import Terrain, mountains

RULES = rrt.RrtRules(step_m=40.0, clearance_m=10.0, ceiling_m=150.0)


def walled(cell=10.0, thick=1, gate=None, height=300.0):
    """Level ground 400 m square with a wall across the middle, higher than the ceiling."""
    size = int(400.0 / cell) + 1
    heights = np.zeros((size, size))
    heights[size // 2 : size // 2 + thick] = height
    if gate is not None:
        heights[:, int(gate / cell) : int(gate / cell) + 5] = 0.0
    return Terrain(0.0, 0.0, cell, heights)


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.floats(-20.0, 60.0), st.floats(-20.0, 60.0))
def test_gaps_are_those_of_very_many_samples(seed, lift, other):
    rng = np.random.default_rng(seed)
    ground = Terrain(-20.0, 5.0, 7.0, rng.uniform(0.0, 40.0, (9, 7)))
    ends = rng.uniform(-60.0, 90.0, (4, 2, 3))
    ends[:, 0, 2], ends[:, 1, 2] = lift, other
    found = gaps(ground, ends[:, 0], ends[:, 1])
    share = np.linspace(0.0, 1.0, 8_001)[:, None, None]
    line = ends[:, 0] + share * (ends[:, 1] - ends[:, 0])
    sampled = (line[..., 2] - ground.height_at(line)).min(axis=0)
    assert (found <= sampled + 1e-9).all()
    assert np.allclose(found, sampled, atol=0.1)


def test_a_line_straight_down_and_a_point():
    ground = Terrain(0.0, 0.0, 10.0, np.full((3, 3), 4.0))
    assert gaps(ground, [5.0, 5.0, 30.0], [5.0, 5.0, 10.0]) == pytest.approx(6.0)
    assert gaps(ground, [5.0, 5.0, 30.0], [5.0, 5.0, 30.0]) == pytest.approx(26.0)
    assert path_gap(ground, np.array([[1.0, 1.0, 9.0]])) == pytest.approx(5.0)


@settings(max_examples=12, deadline=None)
@given(
    st.sampled_from([2.0, 10.0, 40.0]),
    st.sampled_from([15.0, 90.0, 1000.0]),
    st.booleans(),
    st.integers(0, 1000),
)
def test_a_wall_of_one_lattice_line_is_never_crossed(cell, step, diagonal, seed):
    wall = walled(cell)
    start, goal = (50.0, 210.0, 50.0), (350.0, 190.0, 50.0)
    if diagonal:
        wall = replace(wall, heights=np.fliplr(np.eye(len(wall.heights))) * 400.0)
        start, goal = (60.0, 60.0, 50.0), (350.0, 340.0, 50.0)
    rules = replace(RULES, step_m=step, nodes=100)
    assert rrt.plan(wall, start, goal, rules, np.random.default_rng(seed)) is None


def test_without_a_ceiling_the_ends_may_be_high():
    ground = Terrain(0.0, 0.0, 100.0, np.zeros((3, 3)))
    rules = replace(RULES, ceiling_m=math.inf)
    ends = (1.0, 1.0, 900.0), (150.0, 150.0, 20.0)
    path = rrt.plan(ground, *ends, rules, np.random.default_rng(0))
    assert np.allclose(path.points, ends)


@pytest.mark.parametrize("smoothing", ["farthest", "printed", "none"])
def test_it_goes_through_the_gate(smoothing):
    wall = walled(gate=300.0)
    start, goal = (50.0, 50.0, 50.0), (350.0, 50.0, 50.0)
    rules = replace(RULES, smoothing=smoothing)
    path = rrt.plan(wall, start, goal, rules, np.random.default_rng(3))
    assert np.allclose(path.points[[0, -1]], [start, goal])
    assert path_gap(wall, path.points) >= RULES.clearance_m - 1e-6
    assert (path.points[:, 2] <= RULES.ceiling_m + 1e-6).all()
    assert path.length <= path.raw_length + 1e-9
    legs = np.linalg.norm(np.diff(path.raw, axis=0), axis=1)
    assert (legs[:-1] <= RULES.step_m + 1e-6).all()
    assert path.samples > 0


def test_skipping_is_no_longer_and_farthest_no_longer_than_none():
    ground = mountains(np.random.default_rng(1), (0.0, 0.0, 1500.0, 900.0), 1.0, cell_m=20.0)
    start, goal = (40.0, 40.0, 150.0), (1450.0, 850.0, 150.0)
    start = (*start[:2], float(ground.height_at(start)) + 40.0)
    goal = (*goal[:2], float(ground.height_at(goal)) + 40.0)
    for seed in range(2):
        path = rrt.plan(ground, start, goal, RULES, np.random.default_rng(seed))
        assert path is not None
        assert path_gap(ground, path.points) >= RULES.clearance_m - 1e-6
        printed = rrt.skipped(ground, path.raw, replace(RULES, smoothing="printed"))
        assert path.length <= path.raw_length + 1e-9
        assert rrt.path_length(printed) <= path.raw_length + 1e-9
        assert path_gap(ground, printed) >= RULES.clearance_m - 1e-6


def test_printed_skipping_stops_at_the_first_leg_that_is_blocked():
    heights = np.zeros((41, 41))
    heights[10] = 100.0
    heights[10, 20] = 0.0
    ridge = Terrain(0.0, 0.0, 10.0, heights)
    zigzag = np.array(
        [[0.0, 200.0, 30], [50, 200, 30], [150, 200, 30], [150, 350, 30], [300, 200, 30]]
    )
    rules = replace(RULES, clearance_m=0.0)
    printed = rrt.skipped(ridge, zigzag, replace(rules, smoothing="printed"))
    farthest = rrt.skipped(ridge, zigzag, rules)
    assert len(farthest) == 2
    assert len(printed) > 2


def test_the_same_seed_the_same_path():
    wall = walled(gate=300.0)
    ends = (50.0, 50.0, 50.0), (350.0, 50.0, 50.0)
    paths = [rrt.plan(wall, *ends, RULES, np.random.default_rng(9)) for _ in range(2)]
    assert np.array_equal(paths[0].points, paths[1].points)
    other = rrt.plan(wall, *ends, RULES, np.random.default_rng(10))
    assert not np.array_equal(paths[0].raw, other.raw)


def test_steep_legs_are_refused():
    wall = walled(gate=300.0)
    rules = replace(RULES, climb_rad=0.3)
    path = rrt.plan(wall, (50.0, 50.0, 20.0), (350.0, 50.0, 120.0), rules, np.random.default_rng(3))
    legs = np.diff(path.points, axis=0)
    assert (np.abs(legs[:, 2]) <= np.hypot(legs[:, 0], legs[:, 1]) * math.tan(0.3) + 1e-6).all()


def test_in_sight_it_is_a_straight_line():
    ground = Terrain(0.0, 0.0, 100.0, np.zeros((3, 3)))
    path = rrt.plan(ground, (1, 1, 20), (150, 150, 20), RULES, np.random.default_rng(0))
    assert len(path.points) == 2
    assert path.samples == 0


@pytest.mark.parametrize(
    ("start", "rules", "words"),
    [
        ((1.0, 1.0, 5.0), RULES, "start .* 5 m above ground, 10 m are the least"),
        ((1.0, 1.0, 500.0), RULES, "start .* above the ceiling of 150 m"),
        ((-1.0, 1.0, 50.0), RULES, "start .* outside the terrain"),
        ((1.0, 1.0), RULES, "start"),
        ((1.0, 1.0, 50.0), replace(RULES, step_m=0.0), "step_m"),
        ((1.0, 1.0, 50.0), replace(RULES, smoothing="some"), "smoothing"),
        ((1.0, 1.0, 50.0), replace(RULES, clearance_m=math.nan), "clearance_m"),
        ((1.0, 1.0, 50.0), replace(RULES, climb_rad=0.0), "climb_rad"),
        ((1.0, 1.0, 50.0), replace(RULES, goal_bias=1.5), "goal_bias"),
        ((1.0, 1.0, 50.0), replace(RULES, ceiling_m=math.nan), "ceiling_m"),
    ],
)
def test_what_makes_no_sense(start, rules, words):
    ground = Terrain(0.0, 0.0, 100.0, np.zeros((3, 3)))
    with pytest.raises(ValueError, match=words):
        rrt.plan(ground, start, (150.0, 150.0, 20.0), rules, np.random.default_rng(0))


def test_resampled_keeps_the_ends_and_the_spacing():
    line = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [100.0, 65.0, 0.0]])
    points = rrt.resampled(line, 50.0)
    assert np.allclose(points[[0, -1]], line[[0, -1]])
    assert len(points) == 5
    assert np.allclose(rrt.resampled(line[:2], 50.0)[:, 0], (0.0, 50.0, 100.0))
