"""Aircraft over points that they can not turn to at once."""

from math import atan2, cos, hypot, pi, sin

import pytest

from uavbridge.agent.passing import NEAR_M, Passing

SPEED, RATE = 25.0, 9.81 * 0.84 / 25.0  # a turn at 40 degrees of bank
DT = 0.1


def steer(points, start=(0.0, 0.0), seconds=400.0):
    """Fly to each point in turn; the times at which it was there."""
    passing, (x, y), course = Passing(SPEED), start, 0.0
    times, left = [], list(points)
    for step in range(round(seconds / DT)):
        passing.see((x, y, 50.0))
        if passing.was_there((*left[0], 50.0), (x, y, 50.0)):
            assert hypot(left[0][0] - x, left[0][1] - y) < NEAR_M
            times.append(step * DT)
            left.pop(0)
            if not left:
                break
            continue
        east, north = passing.way((*left[0], 50.0), (x, y, 50.0))
        if east or north:
            off = (atan2(north, east) - course + pi) % (2 * pi) - pi
            course += max(min(off, RATE * DT), -RATE * DT)
        x, y = x + SPEED * DT * cos(course), y + SPEED * DT * sin(course)
    return times


@pytest.mark.parametrize(
    "point", [(0.0, 60.0), (0.0, -60.0), (-50.0, 10.0), (40.0, 45.0), (500.0, 0.0), (-300.0, 0.0)]
)
def test_a_point_beside_it_is_reached(point):
    assert len(steer([(100.0, 0.0), (100.0 + point[0], point[1])])) == 2


def test_lanes_nearer_than_a_turn_are_all_flown():
    cells = [(100.0 * i, 100.0 * j) for j in range(4) for i in (range(4), range(3, -1, -1))[j % 2]]
    times = steer(cells, start=(-50.0, 0.0), seconds=900.0)
    assert len(times) == len(cells)


def test_who_was_there_stays_there_until_the_point_moves():
    passing = Passing(SPEED)
    assert not passing.was_there((100.0, 0.0, 50.0), (0.0, 0.0, 50.0))
    assert passing.was_there((100.0, 0.0, 50.0), (80.0, 0.0, 50.0))
    assert passing.was_there((102.0, 0.0, 50.0), (300.0, 0.0, 50.0))
    assert not passing.was_there((200.0, 0.0, 50.0), (300.0, 0.0, 50.0))
