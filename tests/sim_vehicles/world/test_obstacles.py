"""The detector of obstacles."""

from __future__ import annotations

import numpy as np

from sim_vehicles.world.obstacles import ObstacleDetector, ObstacleSeen

COLUMNS = np.array([[100.0, 0.0, 20.0], [500.0, 0.0, 10.0]])


def test_a_column_is_told_of_when_it_comes_into_reach_and_now_and_then_after_that() -> None:
    detector = ObstacleDetector(COLUMNS, 50.0, 2)
    told = [
        (t_us // 1_000_000, seen)
        for t_us in range(0, 12_000_000, 1_000_000)
        for seen in detector.look(t_us, np.array([[25.0 + t_us * 5e-6, 0.0, 0.0], [460, 0, 90]]))
    ]
    assert [t_s for t_s, seen in told if seen.vehicle == 0] == [1, 6, 11]
    assert [t_s for t_s, seen in told if seen.vehicle == 1] == [0, 5, 10]
    assert {seen for _, seen in told} == {ObstacleSeen(0, 0), ObstacleSeen(1, 1)}


def test_who_comes_back_sees_it_at_once() -> None:
    detector = ObstacleDetector(COLUMNS[:1], 50.0, 1)
    seen = [
        bool(detector.look(t_us, np.array([[x, 0.0, 40.0]])))
        for t_us, x in ((0, 40.0), (100_000, 0.0), (200_000, 40.0), (300_000, 40.0))
    ]
    assert seen == [True, False, True, False]


def test_a_place_that_is_no_number_sees_nothing() -> None:
    assert ObstacleDetector(COLUMNS, 50.0, 1).look(0, np.full((1, 3), np.nan)) == []
