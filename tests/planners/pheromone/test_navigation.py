"""Leaders by vector and scalar pheromones, followers in both forms (Shao 2020, Eqs. 12-24)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.pheromone.follow import FollowLaw, bump, flock, sigma_norm
from planners.pheromone.lead import cell_of, scalar_step, sector_vectors, vector_step

SIZE = 41
SLOPE = np.add.outer(np.arange(SIZE) * 1.0, np.zeros(SIZE))  # rises to the east
NOTHING = np.zeros((SIZE, SIZE), np.bool_)
MIDDLE = np.array([20.0, 20.0])
STILL = np.zeros(2)


def test_vector_pheromones_point_up_the_field():
    vectors = sector_vectors(MIDDLE, SLOPE, 5.0)
    assert (vectors[:, 0] >= -1e-12).all(), "out of every sector towards higher values"
    velocity = vector_step(MIDDLE, STILL, SLOPE, NOTHING, 5.0, 2.0)
    assert abs(velocity[0]) > 1.99 * 0.7
    assert np.hypot(*velocity) == pytest.approx(2.0)


def test_a_sum_over_a_sector_is_equation_12():
    vectors = sector_vectors(MIDDLE, SLOPE, 1.0)
    expected = np.zeros((8, 2))
    expected[0] = expected[4] = (1.0, 0.0)  # tau_i - tau_j is -1 and 1, q_i - q_j too
    np.testing.assert_allclose(vectors, expected, atol=1e-12)


def test_kernels_take_runs_one_by_one_or_together():
    draw = np.random.default_rng(2)
    total = draw.random((3, 12, 15))
    closed = draw.random((3, 12, 15)) < 0.2
    place = draw.uniform(2.0, 9.0, (3, 2))
    heading = draw.normal(0.0, 1.0, (3, 2))
    together = vector_step(place, heading, total, closed, 3.0, 2.0)
    scalar = scalar_step(place, total, closed, 3.0, 1.0, True)
    for run in range(3):
        one = vector_step(place[run], heading[run], total[run], closed[run], 3.0, 2.0)
        np.testing.assert_allclose(together[run], one)
        alone = scalar_step(place[run], total[run], closed[run], 3.0, 1.0, True)
        np.testing.assert_allclose(scalar[run], alone)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6), st.booleans())
def test_no_leader_enters_an_obstacle_or_leaves_the_map(seed, vector):
    draw = np.random.default_rng(seed)
    total = draw.normal(0.0, 1.0, (12, 9))
    closed = draw.random((12, 9)) < draw.uniform(0.0, 0.7)
    place = draw.uniform(-0.49, (11.49, 8.49))
    if vector:
        velocity = vector_step(place, STILL, total, closed, 4.0, 2.0)
    else:
        velocity = scalar_step(place, total, closed, 4.0, 1.0, True)
    after = cell_of(place + velocity)
    assert (after >= 0).all()
    assert (after < (12, 9)).all()
    assert not velocity.any() or not closed[tuple(after)]


def test_an_even_field_keeps_the_heading():
    velocity = vector_step(MIDDLE, np.array([0.0, -3.0]), NOTHING * 1.0, NOTHING, 5.0, 2.0)
    np.testing.assert_allclose(velocity, (0.0, -2.0), atol=1e-12)


def test_sigma_norm_and_bump():
    assert sigma_norm(np.array(25.0), 0.1) == pytest.approx((np.sqrt(3.5) - 1.0) / 0.1)
    np.testing.assert_allclose(bump(np.array((0.0, 0.5, 0.75, 1.0, 2.0)), 0.5), (1, 1, 0.5, 0, 0))


def fly(law, places, steps=400, speed=2.0):
    """Followers behind a leader that goes east."""
    place, velocity = np.array(places), np.zeros((len(places), 2))
    leader, way = np.zeros(2), np.array((speed, 0.0))
    for _ in range(steps):
        velocity = flock(place, velocity, leader, way, law)
        place, leader = place + velocity, leader + way
    return place - leader


def test_the_working_form_settles_around_the_leader_without_lag():
    one = fly(FollowLaw(), [(-4.0, 3.0)])
    np.testing.assert_allclose(one, 0.0, atol=1e-6)
    two = fly(FollowLaw(), [(-4.0, 3.0), (-3.0, -2.0)])
    np.testing.assert_allclose(two.sum(axis=0), 0.0, atol=1e-3)
    assert np.hypot(*(two[0] - two[1])) > 1.0


def test_the_printed_form_lags_alone_and_leaves_in_company():
    lag = fly(FollowLaw(form="printed"), [(-4.0, 3.0)])[0]
    np.testing.assert_allclose(lag, (-2.0 / 0.6, 0.0), atol=1e-6)
    far = fly(FollowLaw(form="printed"), [(-4.0, 3.0), (-3.0, 1.0), (-2.0, 2.0)], steps=60)
    assert np.abs(far).max() > 1000.0
