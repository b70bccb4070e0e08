"""No-fly columns: no velocity is let through that could not be stopped in time."""

from dataclasses import replace
from math import hypot

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uavbridge.safety.envelope import Envelope
from uavbridge.safety.filter import constrain

COLUMNS = ((300.0, 300.0, 40.0), (390.0, 320.0, 30.0), (600.0, 200.0, 60.0))
BOX = Envelope(0, 0, 1000, 1000, 15, 120, columns=COLUMNS)
places = st.tuples(st.floats(0, 1000), st.floats(0, 1000), st.floats(15, 120))
speeds = st.floats(-30, 30)


def nearest(position, columns=COLUMNS):
    return min(hypot(x - position[0], y - position[1]) - r for x, y, r in columns)


def fly(start, wanted, steps=600, envelope=BOX):
    """A vehicle that answers setpoints with a lag of half a second; how near it came."""
    position, velocity = np.array(start, float), np.zeros(3)
    least = np.inf
    for step in range(steps):
        asked = constrain(
            wanted(step, position), tuple(position), tuple(velocity), (), envelope
        ).velocity
        velocity += (np.array(asked) - velocity) * 0.2
        position += velocity * 0.1
        least = min(least, nearest(position))
    return least, position


@pytest.mark.parametrize("driving", [False, True])
def test_a_way_through_columns_leads_round_them(driving):
    envelope = replace(BOX, drives=driving)

    def towards(_step, position):
        x, y = 900.0 - position[0], 320.0 - position[1]
        far = max(hypot(x, y), 1e-9)
        return 10.0 * x / far, 10.0 * y / far, 0.0

    least, end = fly((50.0, 290.0, 40.0), towards, 1500, envelope)
    assert least > 0.0
    assert hypot(end[0] - 900.0, end[1] - 320.0) < 60.0


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6))
def test_whatever_is_wanted_no_column_is_entered(seed):
    draw = np.random.default_rng(seed)
    start = (*draw.uniform(0, 1000, 2), 40.0)
    while nearest(start) < 3.0:
        start = (*draw.uniform(0, 1000, 2), 40.0)
    turns = draw.uniform(-30.0, 30.0, (20, 3))
    least, _ = fly(start, lambda step, _: tuple(turns[step // 20]), 400)
    assert least > 0.0


@given(places)
def test_inside_a_column_the_way_is_out(place):
    if nearest(place) >= 0.0:
        return
    x, y, _ = min(COLUMNS, key=lambda c: hypot(c[0] - place[0], c[1] - place[1]) - c[2])
    vx, vy, _ = constrain((0.0, 0.0, 0.0), place, (0.0, 0.0, 0.0), (), BOX).velocity
    if hypot(x - place[0], y - place[1]) > 1.0 and nearest(place) < -2.0:
        inside = sum(hypot(c[0] - place[0], c[1] - place[1]) < c[2] for c in COLUMNS)
        if inside == 1:
            assert vx * (place[0] - x) + vy * (place[1] - y) > 0.0


def test_it_says_what_bent_the_way():
    near = constrain((10.0, 0.0, 0.0), (250.0, 300.0, 40.0), (10.0, 0.0, 0.0), (), BOX)
    assert near.limited_by == ("obstacle",)
    assert constrain((10.0, 0.0, 0.0), (50.0, 800.0, 40.0), (0.0,) * 3, (), BOX).limited_by == ()
