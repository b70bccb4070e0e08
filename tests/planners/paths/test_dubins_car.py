import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.paths.dubins import car_lengths, shortest_car
from planners.paths.dubins.car import by_length

places = st.floats(-200.0, 200.0)
angles = st.floats(-math.pi, math.pi)
poses = st.tuples(places, places, angles)
radii = st.floats(5.0, 80.0)


def wrapped(angle):
    return math.remainder(angle, math.tau)


@settings(max_examples=150)
@given(poses, poses, radii)
def test_it_ends_at_the_end_and_turns_no_tighter_than_allowed(start, end, radius):
    path = shortest_car(start, end, radius)
    step = radius / 20.0
    points = path.points(step)
    assert np.allclose(points[0], start)
    assert np.hypot(*(points[-1] - end)[:2]) < 1e-5
    assert abs(wrapped(points[-1, 2] - end[2])) < 1e-6
    apart = np.hypot(*np.diff(points[:, :2], axis=0).T)
    assert (apart <= step * (1 + 1e-9)).all()
    turned = np.abs(np.diff(points[:, 2]))
    assert (turned <= path.length / (len(points) - 1) / radius * (1 + 1e-9)).all()
    assert apart.sum() <= path.length + 1e-6
    assert apart.sum() >= path.length * (1 - 1e-3)


@settings(max_examples=80)
@given(poses, poses, radii)
def test_no_shorter_than_straight_and_the_same_from_the_back_and_in_the_mirror(start, end, radius):
    length = shortest_car(start, end, radius).length
    assert length >= math.hypot(end[0] - start[0], end[1] - start[1]) - 1e-9
    back = [(x, y, psi + math.pi) for x, y, psi in (end, start)]
    mirror = [(x, -y, -psi) for x, y, psi in (start, end)]
    for other in (back, mirror):
        # Where the shortest path is just ending to exist, rounding may decide either way.
        assert shortest_car(*other, radius).length == pytest.approx(length, rel=1e-5, abs=1e-5)


@settings(max_examples=60)
@given(poses, poses, radii, st.floats(0.1, 50.0), angles)
def test_lengths_scale_and_do_not_depend_on_where_and_which_way(start, end, radius, scale, spin):
    def moved(pose):
        x, y, psi = pose
        u = x * math.cos(spin) - y * math.sin(spin) + 13.0
        v = x * math.sin(spin) + y * math.cos(spin) - 7.0
        return scale * u, scale * v, psi + spin

    length = shortest_car(start, end, radius).length
    other = shortest_car(moved(start), moved(end), radius * scale).length
    assert other / scale == pytest.approx(length, rel=1e-5, abs=1e-5)


@settings(max_examples=40)
@given(poses, poses, poses, radii)
def test_a_detour_is_no_shorter(start, middle, end, radius):
    direct = shortest_car(start, end, radius).length
    detour = shortest_car(start, middle, radius).length + shortest_car(middle, end, radius).length
    assert direct <= detour + 1e-5


def searched(start, end, radius):
    """The length of the shortest word, by a search that knows no formula of a word."""
    best = math.inf
    grid = np.linspace(-math.pi, math.pi, 4001)
    s, e = np.array(start), np.array(end)
    left = {
        turn: s[:2] + turn * radius * np.array((-math.sin(s[2]), math.cos(s[2])))
        for turn in (1, -1)
    }
    right = {
        turn: e[:2] + turn * radius * np.array((-math.sin(e[2]), math.cos(e[2])))
        for turn in (1, -1)
    }

    def normal(chi):
        return np.stack((-np.sin(chi), np.cos(chi)), axis=-1)

    def gap(chi, first, last):  # how far the straight line passes by the last circle's tangent
        a = left[first] - first * radius * normal(chi)
        b = right[last] - last * radius * normal(chi)
        line = b - a
        ahead = line[..., 0] * np.cos(chi) + line[..., 1] * np.sin(chi)
        return line[..., 1] * np.cos(chi) - line[..., 0] * np.sin(chi), ahead

    for first in (1, -1):
        for last in (1, -1):
            for chi in roots(lambda c, f=first, t=last: gap(c, f, t)[0], grid):
                ahead = gap(np.array(chi), first, last)[1]
                if ahead >= -1e-6:
                    arcs = (first * (chi - s[2])) % math.tau + (last * (e[2] - chi)) % math.tau
                    best = min(best, float(ahead) + radius * arcs)

        # Arc, arc, arc: the middle circle lies across the point where the first arc ends.
        def far(chi, turn=first):
            middle = left[turn] - 2.0 * turn * radius * normal(chi)
            return np.hypot(*(middle - right[turn]).T) - 2.0 * radius

        for chi in roots(far, grid):
            middle = left[first] - 2.0 * first * radius * normal(np.array(chi))
            out = right[first] - middle
            leave = math.atan2(out[1], out[0]) - first * math.pi / 2.0
            arcs = (
                (first * (chi - s[2])) % math.tau
                + (-first * (leave - chi)) % math.tau
                + (first * (e[2] - leave)) % math.tau
            )
            best = min(best, radius * arcs)
    return best


def roots(function, grid):
    values = function(grid)
    found = []
    for at in np.nonzero((values[:-1] <= 0) != (values[1:] <= 0))[0]:
        low, high = grid[at], grid[at + 1]
        sign = values[at] <= 0
        for _ in range(60):
            middle = (low + high) / 2
            if (function(np.array([middle]))[0] <= 0) == sign:
                low = middle
            else:
                high = middle
        found.append((low + high) / 2)
    return found


def test_as_short_as_a_brute_force_search_finds():
    rng = np.random.default_rng(4)
    seen = set()
    for span in (30.0, 60.0, 200.0):
        for _ in range(25):
            start, end = rng.uniform(-span, span, (2, 3))
            path = shortest_car(start, end, 25.0)
            seen.add(path.word)
            assert path.length == pytest.approx(searched(start, end, 25.0), rel=1e-6)
    assert seen == {"LSL", "RSR", "LSR", "RSL", "LRL", "RLR"}


def test_every_word_that_exists_arrives():
    rng = np.random.default_rng(5)
    for _ in range(50):
        start, end = rng.uniform(-60.0, 60.0, (2, 3))
        found = by_length(start, end, 20.0)
        assert [path.length for path in found] == sorted(path.length for path in found)
        for path in found:
            assert np.hypot(*(path.points(5.0)[-1] - end)[:2]) < 1e-6


def test_lengths_in_batches_are_those_of_single_paths():
    rng = np.random.default_rng(6)
    start, end = rng.uniform(-90.0, 90.0, (2, 40, 3))
    single = [shortest_car(a, b, 30.0).length for a, b in zip(start, end, strict=True)]
    assert np.allclose(car_lengths(start, end, 30.0), single)
    assert car_lengths(start[:, None], end[None], 30.0).shape == (40, 40)


@pytest.mark.parametrize(
    ("end", "length"),
    [
        ((0.0, 0.0, 0.0), 0.0),
        ((100.0, 0.0, 0.0), 100.0),
        ((0.0, 60.0, math.pi), 30.0 * math.pi),
        ((30.0, 30.0, math.pi / 2), 15.0 * math.pi),
        ((-30.0, 30.0, 3 * math.pi / 2), 45.0 * math.pi),
        ((60.0, 60.0, 0.0), 30.0 * math.pi),
    ],
)
def test_simple_ones_take_no_turn_too_many(end, length):
    assert shortest_car((0.0, 0.0, 0.0), end, 30.0).length == pytest.approx(length, abs=1e-6)


@pytest.mark.parametrize("radius", [0.0, -3.0, math.nan, math.inf])
def test_a_radius_that_makes_no_sense(radius):
    with pytest.raises(ValueError, match="r_min"):
        shortest_car((0, 0, 0), (1, 1, 1), radius)


def test_a_pose_that_makes_no_sense():
    with pytest.raises(ValueError, match="pose"):
        shortest_car((0, 0), (1, 1, 1), 3.0)
    with pytest.raises(ValueError, match="pose"):
        shortest_car((0, 0, math.nan), (1, 1, 1), 3.0)
