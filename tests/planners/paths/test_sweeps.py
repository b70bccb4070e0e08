"""Sweeps visit every cell, by steps to adjacent cells."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.paths import loop, sweeps

sizes = st.integers(1, 9)


def steps(cells):
    return abs(np.diff(np.vstack((cells, cells[:1])), axis=0)).sum(axis=1)


@pytest.mark.parametrize("name", sweeps.LOOPS)
@given(columns=sizes, rows=sizes)
def test_a_loop_visits_every_cell_of_the_grid(name, columns, rows):
    cells = sweeps.LOOPS[name](columns, rows)
    assert {tuple(cell) for cell in cells.tolist()} == set(np.ndindex(columns, rows))


@pytest.mark.parametrize("name", sweeps.LOOPS)
@given(columns=sizes, rows=sizes)
def test_only_the_documented_joints_are_not_adjacent(name, columns, rows):
    joints = int((steps(sweeps.LOOPS[name](columns, rows)) > 1).sum())
    if name == "snake-and-jump":
        assert joints <= 1
    elif name == "closed-tour":
        assert joints == (columns % 2 and rows % 2 and min(columns, rows) > 1)
    else:
        assert joints == 0


@given(columns=st.integers(2, 9), rows=st.integers(2, 9))
def test_a_closed_tour_visits_no_cell_twice(columns, rows):
    assert len(sweeps.closed_tour(columns, rows)) == columns * rows


def test_columns_and_rows_alternate():
    loop_cells = sweeps.columns_and_rows(3, 3)
    first = sweeps.snake(3, 3, along_rows=False)
    assert (loop_cells[:9] == first).all()
    assert loop_cells[8:, 1].tolist() == [2, 2, 2, 1, 1, 1, 0, 0]


@given(columns=sizes, rows=sizes, start=st.integers(0, 80))
def test_corners_keep_the_length_of_the_loop(columns, rows, start):
    cells = np.roll(sweeps.closed_tour(columns, rows), -start, axis=0)
    points = sweeps.corners(cells)
    assert (points[0] == cells[0]).all()

    def length(path):
        way = np.vstack((path, path[:1]))
        return np.hypot(*np.diff(way, axis=0).T).sum()

    assert length(points) == pytest.approx(length(cells.astype(float)))


def test_following_a_loop_in_exact_steps():
    points, count = loop.stack([np.array([[0.0, 0.0], [0.0, 30.0]]), np.array([[5.0, 5.0]])])
    position, leg = np.array([[0.0, 0.0], [5.0, 0.0]]), np.zeros(2, int)
    heights = []
    for _ in range(7):
        leg = loop.advance(position, points, count, leg, 0.001)
        goal = loop.target(points, leg)
        position = position + loop.towards(position, goal, 10.0, 1.0)
        heights.append(position[0, 1])
    assert heights == [10, 20, 30, 20, 10, 0, 10]
    assert position[1].tolist() == [5.0, 5.0]
