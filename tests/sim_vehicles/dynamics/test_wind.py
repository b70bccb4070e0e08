from __future__ import annotations

import numpy as np
import pytest

from sim_vehicles.dynamics import Wind, WindSpec

GUSTY = WindSpec((4.0, -2.0, 0.0), gust_m_s=1.5, gust_up_m_s=0.5, gust_s=3.0, gust_up_s=1.0)


def series(dt_s: float, steps: int, n: int = 400) -> np.ndarray:
    wind = Wind(GUSTY, n, 11)
    return np.array([wind.step(dt_s).copy() for _ in range(steps)])


@pytest.mark.parametrize("dt_s", [0.02, 0.5, 20.0])
def test_mean_and_spread_are_as_asked_from_the_first_step_at_any_step(dt_s):
    flown = series(dt_s, 40)
    assert flown.mean(axis=(0, 1)) == pytest.approx([4.0, -2.0, 0.0], abs=0.25)
    for part in (flown[0], flown[-1]):
        assert part.std(axis=0) == pytest.approx([1.5, 1.5, 0.5], rel=0.12)


def test_gusts_forget_in_their_time_constants():
    flown = series(0.1, 31) - [4.0, -2.0, 0.0]
    after_3_s = (flown[0] * flown[-1]).mean(axis=0) / [1.5**2, 1.5**2, 0.5**2]
    assert after_3_s == pytest.approx([np.exp(-1), np.exp(-1), np.exp(-3)], abs=0.15)


def test_vehicles_have_gusts_of_their_own():
    flown = series(1.0, 200, n=3)
    assert abs(np.corrcoef(flown[:, 0, 0], flown[:, 1, 0])[0, 1]) < 0.4


def test_the_same_seed_gives_the_same_wind():
    assert np.array_equal(series(0.02, 20), series(0.02, 20))
    assert not np.array_equal(Wind(GUSTY, 2, 1).step(0.1), Wind(GUSTY, 2, 2).step(0.1))


def test_without_gusts_the_wind_is_the_mean_and_draws_nothing():
    rng = np.random.default_rng(0)
    wind = Wind(WindSpec((3.0, 1.0, 0.0)), 4, rng)
    assert wind.step(0.02) is wind.step(0.02)
    assert np.array_equal(wind.step(0.02), np.tile([3.0, 1.0, 0.0], (4, 1)))
    assert rng.random() == np.random.default_rng(0).random()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gust_m_s", -1.0),
        ("gust_up_m_s", np.nan),
        ("gust_s", 0.0),
        ("mean_m_s", (1.0, np.inf, 0.0)),
    ],
)
def test_a_wind_that_makes_no_sense_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        WindSpec(**{name: value})
