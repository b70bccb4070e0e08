import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.paths.dubins import airplane, airplane_lengths, shortest_car

CLIMB = math.radians(30.0)
places = st.floats(-300.0, 300.0)
heights = st.floats(-400.0, 400.0)
angles = st.floats(-math.pi, math.pi)
poses = st.tuples(places, places, heights, angles)


def arrives(path, end):
    last = path.points(5.0)[-1]
    offset = np.abs(last[:3] - np.asarray(end)[:3]).max()
    return offset < 1e-4 and abs(math.remainder(last[3] - end[3], math.tau)) < 1e-5


@settings(max_examples=60, deadline=None)
@given(poses, poses, st.floats(10.0, 80.0), st.floats(0.1, 1.2))
def test_it_can_be_flown_and_ends_at_the_end(start, end, radius, climb):
    path = airplane(start, end, radius, climb)
    assert arrives(path, end)
    points = path.points(2.0)
    assert np.allclose(points[0], start)
    assert path.radius >= radius * (1 - 1e-9)
    assert abs(path.gamma) <= climb * (1 + 1e-9)
    steps = np.diff(points, axis=0)
    level = math.sqrt(max(path.length**2 - (end[2] - start[2]) ** 2, 0.0)) / len(steps)
    assert (np.abs(steps[:, 3]) * radius <= level * (1 + 1e-6) + 1e-9).all()
    assert (np.abs(steps[:, 2]) <= level * math.tan(climb) * (1 + 1e-6) + 1e-9).all()
    assert (np.hypot(steps[:, 0], steps[:, 1]) <= level * (1 + 1e-9) + 1e-9).all()
    straight = float(np.linalg.norm(np.subtract(end, start)[:3]))
    assert path.length >= straight * (1 - 1e-9) - 1e-6
    assert path.length >= float(airplane_lengths(*np.array([start, end]), radius, climb)) - 1e-6


@settings(max_examples=40, deadline=None)
@given(poses, poses, st.floats(10.0, 60.0))
def test_the_case_is_by_the_climb_and_the_car(start, end, radius):
    path = airplane(start, end, radius, CLIMB)
    car = shortest_car((*start[:2], start[3]), (*end[:2], end[3]), radius)
    needed = abs(end[2] - start[2]) / math.tan(CLIMB)
    if needed < car.length * (1 - 1e-9):
        assert (path.case, path.turns) == ("low", 0)
        assert path.length == pytest.approx(math.hypot(car.length, end[2] - start[2]))
    elif car.length * (1 + 1e-9) < needed < car.length + math.tau * radius - 1e-6:
        assert path.case == "medium"
    elif needed > car.length + math.tau * radius + 1e-6:
        assert path.case == "high"
        climb_alone = abs(end[2] - start[2]) / math.sin(CLIMB)
        assert path.turns >= 1 or path.length == pytest.approx(climb_alone)


@settings(max_examples=40, deadline=None)
@given(places, places, heights, angles, st.floats(10.0, 60.0))
def test_far_apart_the_climb_alone_sets_the_length(x, y, height, psi, radius):
    away = math.hypot(x, y)
    scale = 8.0 * radius / max(away, 1.0)
    end = (x * scale, y * scale, height * 4.0, psi)
    if math.hypot(end[0], end[1]) < 6.0 * radius:
        return
    start = (0.0, 0.0, 0.0, 0.0)
    path = airplane(start, end, radius, CLIMB)
    wanted = airplane_lengths(np.array(start), np.array(end), radius, CLIMB)
    assert path.length == pytest.approx(float(wanted), rel=1e-8)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("dz", "case", "length", "turns"),
    [
        (75.0, "low", math.hypot(185.0, 75.0), 0),
        (175.0, "medium", 350.0, 0),
        (400.0, "high", 800.0, 2),
    ],
)
def test_the_papers_examples(dz, case, length, turns, sign):
    end = (185.0, 0.0, sign * dz, 0.0)
    path = airplane((0.0, 0.0, 0.0, 0.0), end, 40.0, CLIMB)
    assert (path.case, path.turns) == (case, turns)
    assert path.length == pytest.approx(length)
    assert math.copysign(1.0, path.gamma) == sign
    assert arrives(path, end)
    if case != "low":
        assert abs(path.gamma) == pytest.approx(CLIMB)
        # The arc or the helix comes first in a climb and last in a descent.
        arc = path.pieces[0] if sign > 0 else path.pieces[-1]
        assert arc.turn != 0
        assert arc.length > 50.0


def test_climbing_and_descending_back_are_equally_long():
    rng = np.random.default_rng(2)
    for _ in range(20):
        start, end = rng.uniform(-150.0, 150.0, (2, 4))
        back = [pose + np.array((0.0, 0.0, 0.0, math.pi)) for pose in (end, start)]
        there = airplane(start, end, 40.0, CLIMB).length
        assert airplane(*back, 40.0, CLIMB).length == pytest.approx(there, rel=1e-3)


def test_where_no_path_is_as_long_as_the_climb_wants_a_longer_one_is_flown():
    """Straight on by less than a radius: between straight and a loop there is a gap."""
    end = (20.0, 0.0, 20.0, 0.0)
    path = airplane((0.0, 0.0, 0.0, 0.0), end, 40.0, CLIMB)
    assert path.case == "medium"
    assert arrives(path, end)
    assert path.gamma < CLIMB - 0.01
    assert path.length > 40.0


@pytest.mark.parametrize(
    ("psi", "end"),
    [
        (2.6383, (-40.2577, 4.7464, -217.7917, 3.3145)),
        (0.5218, (5.9529, 81.4339, -222.0882, 1.6986)),
        (-3.2553, (-76.2411, 1.1070, 237.2917, -2.2880)),
    ],
)
def test_close_together_where_no_whole_turn_fits_there_is_none(psi, end):
    path = airplane((0.0, 0.0, 0.0, psi), end, 40.0, CLIMB)
    assert path.case == "high"
    assert arrives(path, end)
    assert path.length == pytest.approx(abs(end[2]) / math.sin(CLIMB))


@pytest.mark.parametrize("dz", [0.5, 30.0, 144.0, 145.0, 146.0, 700.0, -700.0])
def test_straight_up_and_down(dz):
    end = (0.0, 0.0, dz, 0.0)
    path = airplane((0.0, 0.0, 0.0, 0.0), end, 40.0, CLIMB)
    assert arrives(path, end)
    assert abs(path.gamma) <= CLIMB * (1 + 1e-9)


def test_staying_put_is_no_path():
    path = airplane((1.0, 2.0, 3.0, 0.5), (1.0, 2.0, 3.0, 0.5), 40.0, CLIMB)
    assert path.length == pytest.approx(0.0, abs=1e-9)
    assert np.allclose(path.points(1.0)[[0, -1]], [[1.0, 2.0, 3.0, 0.5]] * 2)


@pytest.mark.parametrize("climb", [0.0, -0.1, math.pi / 2, math.nan])
def test_a_climb_angle_that_makes_no_sense(climb):
    with pytest.raises(ValueError, match="gamma_max"):
        airplane((0, 0, 0, 0), (1, 1, 1, 1), 3.0, climb)


def test_a_pose_that_makes_no_sense():
    with pytest.raises(ValueError, match="pose"):
        airplane((0, 0, 0), (1, 1, 1, 1), 3.0, CLIMB)
