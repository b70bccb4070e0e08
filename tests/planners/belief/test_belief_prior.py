import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.belief import prior
from planners.grid import Grid

GRID = Grid(0.0, 0.0, 100.0, 10, 10)


def test_density_is_that_of_equation_1():
    assert prior.density((0.0, 0.0), (0.0, 0.0), 50.0) == pytest.approx(1 / (2 * np.pi * 2500))
    x, y = 30.0, -20.0
    one = np.exp(-(x**2) / 5000) / np.sqrt(2 * np.pi * 2500)
    other = np.exp(-(y**2) / 5000) / np.sqrt(2 * np.pi * 2500)
    assert prior.density((x, y), (0.0, 0.0), 50.0) == pytest.approx(one * other)


def test_cell_shares_are_the_integral_of_the_mixture():
    means, weights = ((450.0, 550.0), (120.0, 700.0)), (1.0, 0.4)
    shares = prior.cell_shares(GRID, means, weights, 80.0)
    fine = (np.arange(1000) + 0.5) * 1.0
    points = np.stack(np.meshgrid(fine[400:500], fine[500:600], indexing="ij"), axis=-1)
    assert shares[4, 5] == pytest.approx(prior.mixture(points, means, weights, 80.0).sum(), 1e-4)
    assert shares.sum() == pytest.approx(1.4, abs=0.1)  # some lies outside


@given(
    st.lists(st.tuples(st.floats(0, 1000), st.floats(0, 1000)), max_size=4),
    st.floats(20, 400),
    st.floats(0.01, 0.4),
    st.floats(0.5, 0.99),
)
def test_a_prior_lies_between_floor_and_peak(means, sigma, floor, peak):
    made = prior.gaussian_prior(GRID, means, sigma, floor=floor, peak=peak)
    assert made.shape == (10, 10)
    assert (made >= floor - 1e-12).all()
    assert made.max() == pytest.approx(peak if means else floor)


def test_a_target_is_expected_where_it_is_told():
    made = prior.gaussian_prior(GRID, ((450.0, 550.0),), 100.0, floor=0.1, peak=0.8)
    assert np.unravel_index(made.argmax(), made.shape) == (4, 5)
    assert made[4, 5] > made[4, 6] > made[4, 7] > made[4, 8]


@pytest.mark.parametrize(("floor", "peak"), [(0.0, 0.5), (0.6, 0.5), (0.1, 1.0)])
def test_impossible_priors_are_refused(floor, peak):
    with pytest.raises(ValueError, match="floor <= peak"):
        prior.gaussian_prior(GRID, (), 100.0, floor=floor, peak=peak)
