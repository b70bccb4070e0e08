"""What a robot has not heard changes nothing: neither where others are nor what they would say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.search.mountain import MountainParams, Rules, decide
from planners.search.mountain.state import DRAWS, Draws, Heard, Messages, Sensed, fresh

ROBOTS, TARGETS = 9, 3


def messages(draw, members, shape):
    """Whatever may be told, sense or nonsense."""
    count = (*shape, members)
    return Messages(
        task=draw.integers(-1, TARGETS, shape),
        first=draw.random(shape) < 0.5,
        free=draw.random(shape) < 0.5,
        leads=draw.random(shape) < 0.4,
        strength=draw.normal(3.0, 3.0, shape),
        best=np.where(draw.random(shape) < 0.3, -np.inf, draw.normal(5.0, 5.0, shape)),
        best_place=draw.uniform(0.0, 300.0, (*shape, 3)),
        roster=draw.integers(-1, ROBOTS, count),
        found=draw.random((*shape, TARGETS)) < 0.1,
    )


def same(one, other):
    for name in Messages.__slots__:
        assert np.array_equal(getattr(one.told, name), getattr(other.told, name)), name
    for name in ("member", "waited", "rest", "shared", "shared_place"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name


@settings(max_examples=60)
@given(st.integers(0, 10**6), st.sampled_from(["roam", "current", "none"]), st.integers(1, 6))
def test_what_is_not_heard_changes_no_decision(seed, escape, members):
    draw = np.random.default_rng(seed)
    ids = np.arange(ROBOTS)
    params = MountainParams(escape=escape, members=members)
    rules = Rules.of(params, 300.0, 1.0)
    place = draw.uniform(0.0, 300.0, (ROBOTS, 3))
    robots = fresh((ROBOTS,), TARGETS, members, draw.normal(0.0, 5.0, (ROBOTS, 3)))
    heard_target = draw.random((ROBOTS, TARGETS)) < 0.4
    strength = np.where(heard_target, draw.normal(4.0, 3.0, heard_target.shape), 0.0)
    sensed = Sensed(place, strength, heard_target, heard_target & (draw.random() < 0.2))
    known = (draw.random((ROBOTS, ROBOTS)) < 0.5) | np.eye(ROBOTS, dtype=bool)
    told = messages(draw, members, (ROBOTS, ROBOTS))
    seen = np.broadcast_to(place, (ROBOTS, ROBOTS, 3)).copy()

    lies = messages(draw, members, (ROBOTS, ROBOTS))
    mixed = Messages(
        **{
            name: np.where(
                known.reshape(*known.shape, *(1,) * (getattr(told, name).ndim - 2)),
                getattr(told, name),
                getattr(lies, name),
            )
            for name in Messages.__slots__
        }
    )
    elsewhere = np.where(known[..., None], seen, draw.uniform(0.0, 300.0, seen.shape))
    numbers = Draws.of(draw.random((ROBOTS, DRAWS)))

    velocity, after = decide(
        ids, robots, sensed, Heard(ids[None], seen, known, told), numbers, rules
    )
    again, other = decide(
        ids, robots, sensed, Heard(ids[None], elsewhere, known, mixed), numbers, rules
    )
    np.testing.assert_array_equal(velocity, again)
    same(after, other)


def test_the_robots_of_this_test_do_hear_something():
    """The same lies, were they heard, would be believed."""
    ids, rules = np.arange(2), Rules.of(MountainParams(), 300.0, 1.0)
    robots = fresh((2,), 1, 6, np.ones((2, 3)))
    place = np.array([[0.0, 0.0, 0.0], [50.0, 0.0, 0.0]])
    nothing = np.zeros((2, 1))
    sensed = Sensed(place, nothing, nothing > 0, nothing > 0)
    told = robots.told.map(lambda part: np.stack((part, part)))
    told.found[0, 1] = True
    draws = Draws.of(np.full((2, DRAWS), 0.5))
    for range_m, knows in ((100.0, True), (10.0, False)):
        apart = abs(place[:, None, 0] - place[:, 0])
        heard = Heard(ids[None], place[None], apart <= range_m, told)
        _, after = decide(ids, robots, sensed, heard, draws, rules)
        assert bool(after.told.found[0, 0]) is knows
        assert not after.told.found[1, 0]


def test_unknown_robots_push_nobody():
    ids, rules = np.arange(2), Rules.of(MountainParams(), 300.0, 1.0)
    robots = fresh((2,), 0, 6, np.array([[3.0, 4.0, 0.0]] * 2))
    place = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]])
    nothing = np.zeros((2, 0))
    sensed = Sensed(place, nothing, nothing > 0, nothing > 0)
    told = robots.told.map(lambda part: part[None])
    heard = Heard(ids[None], place[None], np.eye(2, dtype=bool), told)
    velocity, _ = decide(ids, robots, sensed, heard, Draws.of(np.full((2, DRAWS), 0.5)), rules)
    assert velocity[0] == pytest.approx([6.0, 8.0, 0.0]), "onwards at Vm"
