"""Signals, answering and ranking; Table 1 of Zhou 2023 as printed."""

import numpy as np
import pytest

from planners.search.mountain import rank_members, respond, signal

# robot, class, intensity, nearest communication robot, distance from it, priority
TABLE_1 = (
    (2, 2, 0.0, 14, 213.2349341, 11),
    (3, 2, 0.0, 19, 209.3224293, 9),
    (5, 1, 2.099988287, 0, 0.0, 2),
    (9, 2, 0.0, 14, 33.53008801, 5),
    (11, 2, 0.0, 5, 44.66655953, 6),
    (14, 1, 2.024188002, 0, 0.0, 3),
    (17, 2, 0.0, 19, 171.3542868, 8),
    (18, 2, 0.0, 14, 232.4477832, 12),
    (19, 1, 6.13611151, 0, 0.0, 1),
    (21, 2, 0.0, 5, 212.6859702, 10),
    (22, 2, 0.0, 14, 30.39406231, 4),
    (23, 2, 0.0, 19, 142.4618399, 7),
)
ROBOT, CLASS, STRENGTH, LINK, DISTANCE, PRIORITY = (
    np.array(part) for part in zip(*TABLE_1, strict=True)
)
BY_ROBOT = {row[0]: row[2] for row in TABLE_1}
LINK_STRENGTH = np.array([BY_ROBOT.get(robot, 0.0) for robot in LINK])


def order(rows=slice(None), **changes):
    values = {
        "first_class": CLASS == 1,
        "strength": STRENGTH,
        "distance": DISTANCE,
        "link_strength": LINK_STRENGTH,
        **changes,
    }
    return rank_members(*(part[rows] for part in values.values()))


def test_table_1():
    assert list(PRIORITY[order()]) == list(range(1, 13))
    assert list(ROBOT[order()]) == [19, 5, 14, 22, 9, 11, 23, 17, 3, 21, 2, 18]


def test_the_order_of_the_candidates_does_not_matter():
    rows = np.random.default_rng(3).permutation(12)
    assert list(PRIORITY[rows][order(rows)]) == list(range(1, 13))


def test_equal_distances_go_by_the_strength_of_the_link():
    level = np.where(CLASS == 2, 50.0, 0.0)
    links = LINK_STRENGTH[order(distance=level)][3:]
    assert list(links) == sorted(links, reverse=True)


def test_batches_and_rows_that_are_no_candidates():
    present = np.array([[True] * 12, [False] * 6 + [True] * 6])
    both = rank_members(
        np.broadcast_to(CLASS == 1, (2, 12)),
        np.broadcast_to(STRENGTH, (2, 12)),
        np.broadcast_to(DISTANCE, (2, 12)),
        np.broadcast_to(LINK_STRENGTH, (2, 12)),
        present,
    )
    assert list(both[0]) == list(order())
    assert list(ROBOT[both[1][:6]]) == [19, 22, 23, 17, 21, 18]


def test_signals():
    noise = np.array([0.0, 1.0, -3.0, 5.0])
    heard = signal(np.array([50.0, 100.0, 100.0, 100.01]), noise, 0.1, 1e5, 100.0)
    assert heard == pytest.approx((4.0, 2.0, -2.0, 0.0))
    assert np.isfinite(signal(np.zeros(1), np.zeros(1), 0.1, 1e5, 100.0)).all()


def test_roulette_goes_by_squares():
    draw = np.random.default_rng(5).random(20_000)
    strength = np.broadcast_to((1.0, -2.0, 7.0, 2.0), (20_000, 4))
    heard = np.broadcast_to((True, True, False, True), (20_000, 4))
    share = np.bincount(respond(strength, heard, draw), minlength=4) / 20_000
    assert share == pytest.approx((1 / 9, 4 / 9, 0.0, 4 / 9), abs=0.015)
    assert respond(np.zeros((1, 2)), np.zeros((1, 2), bool), np.zeros(1)) == -1
    assert respond(np.zeros((1, 0)), np.zeros((1, 0), bool), np.zeros(1)) == -1
