"""Which cell draws an agent."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.grid import Grid
from planners.search.guidance import Guidance, choose, direction

GRID = Grid(0.0, 0.0, 100.0, 10, 10)
LITERAL = Guidance(0.95, "entered", 0.0)
LIVE = Guidance()


def cell(column, row):
    return column * GRID.rows + row


def chosen(belief, at, guide=-1, rule=LITERAL, **others):
    return int(choose(belief, np.array(at, float), np.asarray(guide), GRID, rule, **others))


def flat_map(value=0.5):
    return np.full(GRID.shape, value)


def test_the_likeliest_surrounding_cell_draws():
    belief = flat_map()
    belief[5, 6] = 0.6
    belief[9, 9] = 0.9
    assert chosen(belief, (450, 550)) == cell(5, 6)


def test_of_equals_the_nearest_centre_draws():
    assert chosen(flat_map(), (410, 550)) == cell(3, 5)
    assert chosen(flat_map(), (490, 560)) == cell(5, 5)


def test_the_own_cell_does_not_draw():
    belief = flat_map(0.1)
    belief[4, 5] = 0.9
    assert chosen(belief, (450, 550)) != cell(4, 5)


def test_a_suspicious_cell_draws_back_whoever_leaves_it():
    belief = flat_map()
    belief[4, 5] = 0.947
    assert chosen(belief, (501, 550)) == cell(4, 5)


def test_found_cells_draw_nobody():
    belief = flat_map(0.2)
    belief[5, 5] = 0.95
    assert chosen(belief, (450, 550)) != cell(5, 5)
    assert chosen(flat_map(0.99), (450, 550)) == -1


def test_a_guide_cell_is_kept_until_entered_or_found():
    belief = flat_map()
    belief[5, 5] = 0.7
    assert chosen(belief, (450, 550), cell(3, 4)) == cell(3, 4)
    assert chosen(belief, (350, 450), cell(3, 4)) != cell(3, 4)
    belief[3, 4] = 0.99
    assert chosen(belief, (450, 550), cell(3, 4)) == cell(5, 5)


def test_or_only_while_none_is_better():
    belief = flat_map()
    rule = Guidance(0.95, "best", 0.0)
    assert chosen(belief, (450, 550), cell(3, 4), rule) == cell(3, 4)
    belief[5, 5] = 0.7
    assert chosen(belief, (450, 550), cell(3, 4), rule) == cell(5, 5)


def test_a_guide_cell_that_surrounds_no_longer_is_dropped():
    assert chosen(flat_map(), (850, 850), cell(1, 1)) != cell(1, 1)


def test_among_searched_cells_the_literal_rule_stays_and_the_escape_leaves():
    belief = flat_map(0.05)
    belief[8:, 8:] = 0.5
    assert abs(np.array(divmod(chosen(belief, (250, 250)), 10)) - 2).max() == 1
    assert chosen(belief, (250, 250), rule=LIVE) == cell(8, 8)
    assert chosen(belief, (350, 350), cell(8, 8), LIVE) == cell(8, 8)  # kept on the way


def test_an_escaping_agent_yields_to_a_nearer_neighbour():
    belief = flat_map(0.05)
    belief[8, 8] = belief[0, 9] = 0.5
    other = {"others": np.array([[800.0, 800.0]]), "present": np.array([True])}
    assert chosen(belief, (450, 450), rule=LIVE) == cell(8, 8)
    assert chosen(belief, (450, 450), rule=LIVE, **other) == cell(0, 9)
    belief[0, 9] = 0.05
    assert chosen(belief, (450, 450), rule=LIVE, **other) == cell(8, 8)  # nothing else remains


def test_direction():
    at = np.array([[450.0, 550.0], [550.0, 550.0], [450.0, 550.0]])
    guide = np.array([cell(5, 5), cell(5, 5), -1])
    assert direction(at, guide, GRID) == pytest.approx(np.array([[1, 0], [0, 0], [0, 0.0]]))


@given(st.integers(0, 2**32), st.sampled_from([LITERAL, LIVE]))
def test_a_batch_equals_its_single_agents(seed, rule):
    rng = np.random.default_rng(seed)
    belief = rng.choice([0.05, 0.3, 0.5, 0.96], (3, 1, 10, 10))  # one map a run, shared
    position = rng.uniform(-50, 1050, (3, 4, 2))
    guide = rng.integers(-1, 100, (3, 4))
    others, present = rng.uniform(0, 1000, (3, 4, 2, 2)), rng.random((3, 4, 2)) < 0.7
    batch = choose(belief, position, guide, GRID, rule, others, present)
    for at in np.ndindex(3, 4):
        one = choose(belief[at[0], 0], position[at], guide[at], GRID, rule, others[at], present[at])
        assert batch[at] == one
