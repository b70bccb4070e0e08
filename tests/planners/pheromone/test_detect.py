"""Decisions of detection and revisit (Shao 2020, Fig. 3, Eqs. 9-11)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.pheromone import Field, FieldLaw, Weights, look
from planners.pheromone.detect import (
    STAY,
    DetectRule,
    approach,
    chances,
    decide,
    desirability,
    stepped,
)
from planners.pheromone.look import free_steps
from planners.pheromone.sectors import STEPS, sectors

ALL = np.ones(8, np.bool_)
EAST = np.array(0)
INFORMED, RANDOM = DetectRule(random_share=0.0), DetectRule(random_share=1.0)


def test_costs_are_those_of_equations_10_and_11():
    eta = desirability(np.array([0, 1]))
    np.testing.assert_allclose(eta[0], [0.35, 5 / 24, 1.4 / 6, 0, 0, 0, 1.4 / 6, 5 / 24])
    # On a diagonal heading a turn of 45 degrees beats straight on.
    np.testing.assert_allclose(eta[1, [1, 2, 0]], [0.25, 1.4 * 5 / 24, 1.4 * 5 / 24])


def test_every_cell_in_range_is_in_the_sector_of_its_nearest_heading():
    offsets, members = sectors(4.0)
    assert len(offsets) == 48
    assert (members.sum(axis=1) == 1).all()
    unit = STEPS / np.hypot(*STEPS.T)[:, None]
    assert (members.argmax(axis=1) == (offsets @ unit.T).argmax(axis=1)).all()


def test_means_count_cells_of_the_map_only():
    field = Field.fresh((20, 20), FieldLaw())
    for cell in ((0, 0), (19, 7), (10, 10)):
        seen = look(field, np.array([cell]), 4.0)
        means = seen.means(Weights())[0]
        on_map = seen.known[0] @ sectors(4.0)[1] > 0
        np.testing.assert_allclose(means[on_map], 0.6, atol=1e-6)
        assert (means[~on_map] == 0.0).all()


def test_the_informed_take_the_maximum_and_ties_are_drawn():
    means = np.array([0.1, 0.9, 0.1, 0.1, 5.0, 0.1, 0.1, 0.1])
    assert decide(means, EAST, ALL, np.array(STAY), np.zeros(2), INFORMED) == 1
    symmetric = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    drawn = {
        int(decide(symmetric, EAST, ALL, np.array(STAY), np.array((0.0, u)), INFORMED))
        for u in (0.1, 0.9)
    }
    assert drawn == {1, 7}


def test_the_random_group_draws_by_costs_alone():
    means = np.zeros(8)
    means[1] = 100.0
    draws = np.stack((np.zeros(20_000), np.random.default_rng(0).random(20_000)), axis=-1)
    many = (20_000,)
    chosen = decide(
        np.broadcast_to(means, (*many, 8)), np.zeros(many, np.int64), np.ones((*many, 8), np.bool_),
        np.full(many, STAY), draws, RANDOM,
    )  # fmt: skip
    share = np.bincount(chosen, minlength=8) / many[0]
    eta = desirability(EAST)
    np.testing.assert_allclose(share, eta / eta.sum(), atol=0.015)


def test_near_obstacles_the_chance_stays_a_number():
    negative = np.full(8, -0.5)
    for alpha in (0.5, 1.0, 2.0):
        found = chances(negative, EAST, ALL, DetectRule(alpha=alpha))
        assert np.isfinite(found).all()
        assert (found >= 0.0).all()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
def test_steps_are_legal(seed):
    draw = np.random.default_rng(seed)
    blocked = draw.random((2, 6, 5)) < draw.uniform(0.0, 0.9)
    cells = np.stack((draw.integers(0, 6, (2, 40)), draw.integers(0, 5, (2, 40))), axis=-1)
    heading, means = draw.integers(0, 8, (2, 40)), draw.normal(0.0, 1.0, (2, 40, 8))
    free = free_steps(blocked, cells)
    nobody = np.full((2, 40), STAY)
    chosen = decide(means, heading, free, nobody, draw.random((2, 40, 2)), DetectRule())
    after = stepped(cells, chosen)
    moved = chosen != STAY
    assert (moved == free.any(axis=-1)).all()
    assert (after >= 0).all()
    assert (after < (6, 5)).all()
    run = np.broadcast_to(np.arange(2)[:, None], moved.shape)[moved]
    assert not blocked[run, after[moved, 0], after[moved, 1]].any()
    turn = (chosen - heading) % 8
    forward = (desirability(heading) > 0) & free
    assert np.isin(turn[moved & forward.any(axis=-1)], (0, 1, 2, 6, 7)).all()


def test_a_target_in_sight_is_approached_round_a_wall():
    blocked = np.zeros((1, 9, 9), np.bool_)
    blocked[0, 5, 2:8] = True
    at, heading, path = np.array([4, 4]), np.array([0]), []
    goal = np.array([7, 4])
    for _ in range(9):
        shift = at - 4
        window = np.zeros((1, 9, 9), np.bool_)
        source = np.pad(blocked[0], 4)[at[0] : at[0] + 9, at[1] : at[1] + 9]
        window[0] = source
        heading = approach(window, (goal - at)[None], heading)
        assert heading[0] != STAY, shift
        at = stepped(at[None], heading)[0]
        path.append(tuple(at))
        assert not blocked[0][tuple(at)]
        if tuple(at) == tuple(goal):
            break
    assert path[-1] == (7, 4)


def test_a_target_that_is_walled_in_draws_nobody():
    blocked = np.zeros((1, 9, 9), np.bool_)
    blocked[0, 5:8, 3:6] = True
    blocked[0, 6, 4] = False
    assert approach(blocked, np.array([[2, 0]]), np.array([0])) == [STAY]


@pytest.mark.parametrize("heading", range(8))
def test_a_target_behind_is_reached_within_a_few_steps(heading):
    at, way = np.array([0, 0]), np.array([heading])
    goal = -2 * STEPS[heading]
    for _ in range(7):
        way = approach(np.zeros((1, 17, 17), np.bool_), (goal - at)[None], way)
        at = stepped(at[None], way)[0]
        if (at == goal).all():
            break
    assert tuple(at) == tuple(goal)
