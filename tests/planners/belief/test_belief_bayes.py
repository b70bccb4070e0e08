"""Numbers printed in, or derived from, Khan 2014 and Liu 2022."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.belief import bayes, scores

open_unit = st.floats(0.001, 0.999)


def test_liu_by_hand():
    # Notes: f(1) = 0.52989, f(2) = 0.52180 with P_d = 0.3, P_f = 0.1.
    once = bayes.liu(0.5, False, 0.3, 0.1)
    twice = bayes.liu(once, False, 0.3, 0.1)
    assert once == pytest.approx(0.5 * 7 / 9)
    maps = np.array([[[0.5]], [[once]], [[twice]]])
    assert scores.uncertainty(maps) == pytest.approx([0.5, 0.52989, 0.52180], abs=5e-6)


def test_liu_detections():
    value, seen = 0.5, []
    for _ in range(5):
        value = float(bayes.liu(value, True, 0.3, 0.1))
        seen.append(value)
    assert seen == pytest.approx([0.75, 0.9, 0.9643, 0.9878, 0.9959], abs=5e-5)


def test_mower_uncertainty_of_table_2():
    # A lane swept up and back: 8 inner cells twice, 2 end cells once; ten lanes.
    visits = np.full((10, 10), 2)
    visits[:, [0, -1]] = 1
    assert scores.uncertainty(0.5 * (7 / 9) ** visits) == pytest.approx(52.342, abs=5e-4)


@given(open_unit, open_unit, open_unit, st.booleans())
def test_bayes_multiplies_the_odds(prior, p, q, detected):
    after = float(bayes.bayes(prior, detected, p, q))
    ratio = p / q if detected else (1 - p) / (1 - q)
    assert after / (1 - after) == pytest.approx(prior / (1 - prior) * ratio, rel=1e-6)


@given(st.floats(0, 1), st.floats(0.3, 0.9), st.floats(0.01, 0.3), st.booleans())
def test_liu_stays_a_probability(prior, p, q, detected):
    assert 0.0 <= float(bayes.liu(prior, detected, p, q)) <= 1.0


@pytest.mark.parametrize("name", bayes.UPDATES)
def test_a_batch_equals_its_single_cells(name):
    update = bayes.UPDATES[name]
    prior = np.random.default_rng(1).uniform(0.01, 0.99, (4, 3, 2))
    detected = prior > 0.4
    batch = update(prior, detected, 0.8, 0.1)
    for index in np.ndindex(prior.shape):
        assert batch[index] == float(update(prior[index], bool(detected[index]), 0.8, 0.1))


def test_readings_needed_of_khan_section_iv_d():
    assert bayes.readings_needed(0.5, 0.9, 0.2, 0.99) == 4
    three = 0.9**3 / (0.9**3 + 0.2**3)
    assert three == pytest.approx(0.989145, abs=5e-7)
    assert bayes.readings_needed(0.5, 0.9, 0.05, 0.95) == 2
    assert bayes.readings_needed(0.96, 0.9, 0.05, 0.95) == 0
    for m in (1, 2, 3):  # the jumps of Figs. 5 and 6
        edge = 0.9 / 99 ** (1 / m)
        assert bayes.readings_needed(0.5, 0.9, edge * 0.999, 0.99) == m
        assert bayes.readings_needed(0.5, 0.9, edge * 1.001, 0.99) == m + 1


def test_scores():
    flat = np.full((2, 10, 10), 0.5)
    assert scores.uncertainty(flat).tolist() == [50.0, 50.0]
    assert scores.entropy(flat).tolist() == [100.0, 100.0]
    sure = np.array([[0.0, 1.0]])
    assert scores.uncertainty(sure) == 0.0
    assert scores.entropy(sure) == 0.0
    assert scores.coverage([[True, False], [True, True]]) == 0.75
    assert scores.declared([[0.95, 0.949]], 0.95).tolist() == [[True, False]]
