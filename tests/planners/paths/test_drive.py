"""Ways over terrain for vehicles that climb only so steep."""

from __future__ import annotations

from math import hypot, radians, tan

import numpy as np
import pytest

from planners.paths.drive import Routes, routes_to
from planners.terrain import Terrain, flat, mountains

BOUNDS = (0.0, 0.0, 600.0, 600.0)
HILLS = mountains(np.random.default_rng(7), BOUNDS, radians(45))


def driven(routes: Routes, terrain: Terrain, start: tuple[float, float]) -> tuple[float, float]:
    """Length of the way and the steepest climb on it; fails where the goal is not reached."""
    place, length, steepest, step = np.array(start), 0.0, 0.0, 2.0
    for _ in range(5000):
        (x, y), _ = routes.onwards(*place)
        way = np.array((x, y)) - place
        far = hypot(*way)
        if hypot(*(place - routes.goal)) < step:
            return length, steepest
        after = place + way / far * min(step, far)
        rise = float(terrain.height_at(after) - terrain.height_at(place))
        steepest = max(steepest, rise / min(step, far))
        length += min(step, far)
        place = after
    pytest.fail(f"still at {place}")


def test_on_level_ground_ways_are_about_straight() -> None:
    ground = flat(BOUNDS)
    length, steepest = driven(routes_to((100.0, 120.0), ground, 0.5), ground, (500.0, 430.0))
    assert length == pytest.approx(hypot(400.0, 310.0), rel=0.09)  # eight directions
    assert steepest == 0.0


@pytest.mark.parametrize("start", [(550.0, 550.0), (30.0, 500.0), (300.0, 300.0), (555.0, 20.0)])
def test_ways_over_mountains_climb_no_steeper(start: tuple[float, float]) -> None:
    climb = radians(30)
    _, steepest = driven(routes_to((50.0, 50.0), HILLS, climb), HILLS, start)
    assert steepest <= tan(climb) + 0.05  # between two lattice points a vehicle cuts corners


def test_a_wall_has_to_be_gone_around() -> None:
    heights = np.zeros((61, 61))
    heights[30, :50] = 100.0
    wall = Terrain(0.0, 0.0, 10.0, heights)
    routes = routes_to((100.0, 100.0), wall, radians(30))
    length, _ = driven(routes, wall, (500.0, 100.0))
    assert length > 2 * hypot(200.0, 400.0) - 60.0


def test_one_way_only() -> None:
    """Down a cliff there is a way, up there is none."""
    heights = np.where(np.arange(61)[:, None] < 30, 100.0, 0.0) * np.ones(61)
    step = Terrain(0.0, 0.0, 10.0, heights)
    below = routes_to((500.0, 300.0), step, radians(30))
    above = routes_to((100.0, 300.0), step, radians(30))
    assert np.isfinite(below.left_m).all()
    assert np.isinf(above.left_m[-1, 15])
    assert above.onwards(500.0, 300.0) == ((100.0, 300.0), 400.0)  # straight there
