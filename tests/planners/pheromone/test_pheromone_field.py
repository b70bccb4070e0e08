"""Evaporation, diffusion, aggregation and wear of the three pheromones (Shao 2020, Eqs. 1-8)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.pheromone import Field, FieldLaw, PathLaw, SpreadLaw, Weights, spread, step, worn
from planners.pheromone.field import around, disc

LAW = FieldLaw()
SHARES = st.one_of(st.sampled_from((0.0, 1.0)), st.floats(0.0, 1.0))


@st.composite
def layers(draw):
    sides = st.one_of(st.just(1), st.integers(1, 9))
    shape = draw(st.tuples(st.integers(1, 3), sides, sides))
    numbers = np.random.default_rng(draw(st.integers(0, 10**6)))
    sparse = numbers.random(shape) < draw(st.floats(0.05, 1.0))
    return numbers.random(shape) * sparse, (numbers.random(shape) < 0.2) * 1.0


@settings(max_examples=60, deadline=None)
@given(layers(), SHARES, SHARES, st.floats(0.0, 5.0))
def test_mass_is_exact_at_every_border(maps, evaporation, diffusion, deposit):
    field, sources = maps
    law = SpreadLaw(evaporation, diffusion, deposit)
    after = spread(field, sources * deposit, law)
    expected = (1.0 - evaporation) * (field + sources * deposit).sum(axis=(1, 2))
    np.testing.assert_allclose(after.sum(axis=(1, 2)), expected, rtol=1e-12, atol=1e-28)
    assert (after >= 0.0).all()


@settings(max_examples=30, deadline=None)
@given(layers(), SHARES)
def test_a_step_is_the_printed_sum_over_neighbours(maps, diffusion):
    field, sources = maps
    law = SpreadLaw(0.2, diffusion, 1.0)
    count = around(np.ones(field.shape[1:]))
    expected = np.zeros_like(field)
    held = field + sources
    for run, column, row in np.ndindex(field.shape):
        near = [
            (c, r)
            for c in (column - 1, column, column + 1)
            for r in (row - 1, row, row + 1)
            if (c, r) != (column, row) and 0 <= c < field.shape[1] and 0 <= r < field.shape[2]
        ]
        kept = held[run, column, row] * (1.0 if not near else 1.0 - diffusion)
        given_ = sum(diffusion / count[c, r] * held[run, c, r] for c, r in near)
        expected[run, column, row] = 0.8 * (kept + given_)
    np.testing.assert_allclose(spread(field, sources, law), expected, atol=1e-14)


def test_one_source_settles_at_the_known_values_and_is_gone_after_21_steps():
    field, source = np.zeros((31, 31)), np.zeros((31, 31))
    source[15, 15] = 1.0
    for _ in range(200):
        field = spread(field, source, LAW.target)
    expected = (1.866, 0.209, 0.0366, 0.0058, 0.0010, 0.0002)
    np.testing.assert_allclose(field[15, 15:21], expected, atol=5e-4)
    assert field.sum() == pytest.approx(4.0, rel=1e-3)
    peak = field.max()
    for _ in range(21):
        field = spread(field, source * 0.0, LAW.target)
    assert field.max() < 1e-3 * peak


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 2), (1, 100), (100, 100)])
def test_nothing_is_lost_at_any_border_over_many_steps(shape):
    draw = np.random.default_rng(5)
    field = draw.random(shape)
    mass = field.sum()
    for _ in range(50):
        field = spread(field, np.zeros(shape), SpreadLaw(0.0, 0.9, 1.0))
    assert field.sum() == pytest.approx(mass, rel=1e-12)


def test_all_that_evaporates_is_gone_and_all_that_spreads_is_with_the_neighbours():
    field = np.zeros((3, 3))
    field[1, 1] = 8.0
    assert not spread(field, field, SpreadLaw(1.0, 0.3, 1.0)).any()
    expected = np.ones((3, 3)) - np.eye(3)[1] * np.eye(3)[1][:, None]
    np.testing.assert_allclose(spread(field, field * 0.0, SpreadLaw(0.0, 1.0, 1.0)), expected)


def test_runs_do_not_touch_each_other():
    draw = np.random.default_rng(3)
    fields, sources = draw.random((4, 9, 7)), (draw.random((4, 9, 7)) < 0.1) * 1.0
    uavs = draw.integers(0, 7, (4, 3, 2))
    batch = Field(fields, fields * 0.5, 0.1 + 1.9 * fields)
    together = step(batch, sources, sources, uavs, LAW)
    for run in range(4):
        one = Field(batch.target[run], batch.obstacle[run], batch.path[run])
        alone = step(one, sources[run], sources[run], uavs[run], LAW)
        for name in ("target", "obstacle", "path"):
            np.testing.assert_array_equal(getattr(together, name)[run], getattr(alone, name))


def test_wear_falls_with_the_distance_or_grows_as_printed():
    at = np.array([[10, 10]])
    fresh = np.full((21, 21), 2.0)
    falling = 2.0 - worn(fresh, at, PathLaw())
    printed = 2.0 - worn(fresh, at, PathLaw(wear="printed"))
    np.testing.assert_allclose(
        falling[10, 10:16] / 2.0, (0.9, 0.121, 0.027, 0.0022, 6.7e-5, 0), atol=1e-3
    )
    np.testing.assert_allclose(
        printed[10, 11:16] / 2.0, (0.121, 0.176, 0.1887, 0.1933, 0), atol=1e-3
    )
    assert (falling[10, 10], printed[10, 10]) == (1.8, 1.8)


def test_path_pheromone_stays_between_its_bounds_and_may_recover():
    at = np.array([[0, 0], [0, 0], [1, 0]])
    path = np.full((5, 6), 2.0)
    for _ in range(5):
        path = worn(path, at, PathLaw())
    assert path.min() == pytest.approx(0.1)
    assert path[0, 0] == pytest.approx(0.1)
    for _ in range(60):
        path = worn(path, at[:0], PathLaw(recovery=0.05))
    np.testing.assert_allclose(path, 2.0)  # the upper clamp of Eq. (8) acts


def test_absent_uavs_wear_nothing():
    at = np.array([[2, 2], [4, 4]])
    path = np.full((9, 9), 2.0)
    some = worn(path, at, PathLaw(), np.array([True, False]))
    np.testing.assert_array_equal(some, worn(path, at[:1], PathLaw()))


def test_the_combined_map_is_the_weighted_sum():
    field = Field(np.ones((2, 2)), np.full((2, 2), 2.0), np.full((2, 2), 3.0))
    np.testing.assert_allclose(field.combined(Weights()), 1.0 - 0.6 + 0.9)


@pytest.mark.parametrize(
    "wrong", [{"evaporation": 1.1}, {"diffusion": -0.1}, {"diffusion": np.nan}]
)
def test_coefficients_out_of_range_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        SpreadLaw(**wrong)


def test_a_disc_of_radius_four_has_49_cells():
    assert len(disc(4.0)) == 49
