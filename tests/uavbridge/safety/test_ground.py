"""The ground in the safety filter: whatever is wanted, nothing flies into it."""

from __future__ import annotations

from math import hypot, pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.terrain import Terrain, flat, mountains
from uavbridge.safety.envelope import Braking, Envelope
from uavbridge.safety.filter import Traffic, Vector, constrain

BOUNDS = (0.0, 0.0, 600.0, 600.0)
HILLS = mountains(np.random.default_rng(5), BOUNDS, radians(40))
CLIFF = Terrain(0.0, 0.0, 10.0, np.where(np.arange(61)[:, None] < 30, 0.0, 90.0) * np.ones(61))
LOW_M, HIGH_M = 12.0, 80.0
STEP_S, LAG_S = 0.1, 0.5


def envelope(terrain: Terrain, *, drives: bool = False, steepest: float = pi / 2) -> Envelope:
    return Envelope(
        *(-30.0, -30.0, 630.0, 630.0, LOW_M, HIGH_M),
        climb_m_s=5.0,
        sink_m_s=4.0,
        terrain=terrain,
        drives=drives,
        steepest_rad=steepest,
        braking=Braking(2.0, 0.6) if drives else Braking(),
    )


def height(terrain: Terrain, place: Vector) -> float:
    return place[2] - float(terrain.height_at(place))


def moved(vector: Vector, by: list[float]) -> Vector:
    return vector[0] + by[0], vector[1] + by[1], vector[2] + by[2]


def flown(terrain: Terrain, wishes: list[Vector], start: tuple[float, float]) -> list[Vector]:
    """Positions of a vehicle with a lag that wants each of some velocities for three seconds."""
    rules = envelope(terrain)
    place = (*start, float(terrain.height_at(start)) + 20.0)
    velocity, places = (0.0, 0.0, 0.0), []
    for wish in wishes:
        for _ in range(30):
            safe = constrain(wish, place, velocity, [], rules).velocity
            share = STEP_S / LAG_S
            velocity = moved(
                velocity, [share * (s - v) for v, s in zip(velocity, safe, strict=True)]
            )
            place = moved(place, [STEP_S * v for v in velocity])
            places.append(place)
    return places


def vector(numbers: np.ndarray) -> Vector:
    x, y, z = (float(number) for number in numbers)
    return x, y, z


speeds = st.floats(-12, 12)
wishes = st.lists(st.tuples(speeds, speeds, st.floats(-6, 6)), min_size=3, max_size=10)
inside = st.tuples(st.floats(20, 580), st.floats(20, 580))


@settings(max_examples=25)
@given(wishes, inside)
def test_no_wish_leads_into_mountains(wishes: list[Vector], start: tuple[float, float]) -> None:
    heights = [height(HILLS, place) for place in flown(HILLS, wishes, start)]
    assert min(heights) > 0.5 * LOW_M


@pytest.mark.parametrize("seed", [31, 194, 220, 350])
def test_who_is_pushed_at_a_cliff_is_not_pushed_into_it(seed: int) -> None:
    """Vehicles that keep no distance come from where there is room; the ground goes first."""
    draw = np.random.default_rng(seed)
    rules = envelope(CLIFF)
    place = (float(draw.uniform(270.0, 292.0)), 300.0, 0.0)
    place = moved(place, [0.0, 0.0, float(CLIFF.height_at(place)) + float(draw.uniform(13, 25))])
    velocity, wish = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    pushers = np.array(place) + draw.normal(0.0, (15.0, 15.0, 4.0), (2, 3)) - (15.0, 0.0, 0.0)
    for step in range(100):
        way = np.array(place) - pushers
        apart = np.linalg.norm(way, axis=1, keepdims=True)
        going = way / np.maximum(apart, 1e-9) * draw.uniform(0.0, 9.0, (2, 1))
        pushers = pushers + STEP_S * going
        others = [Traffic(2 + row, vector(pushers[row]), vector(going[row])) for row in range(2)]
        if step % 30 == 0:
            wish = vector(draw.uniform((-12.0, -12.0, -6.0), (12.0, 12.0, 6.0)))
        safe = constrain(wish, place, velocity, others, rules).velocity
        velocity = moved(velocity, [0.2 * (s - v) for v, s in zip(velocity, safe, strict=True)])
        place = moved(place, [STEP_S * v for v in velocity])
        assert height(CLIFF, place) > 0.5 * LOW_M


def test_level_flight_at_a_cliff_climbs_or_stops() -> None:
    places = flown(CLIFF, [(10.0, 0.0, 0.0)] * 20, (150.0, 300.0))
    assert min(height(CLIFF, place) for place in places) > 0.5 * LOW_M
    assert max(place[0] for place in places) > 400.0  # and it gets over


def test_sinking_stops_above_the_ground() -> None:
    places = flown(HILLS, [(0.0, 0.0, -6.0)] * 6, (300.0, 300.0))
    assert height(HILLS, places[-1]) == pytest.approx(LOW_M, abs=2.0)


def test_the_rule_is_named() -> None:
    here = (285.0, 300.0, 20.0)
    safe = constrain((10.0, 0.0, 0.0), here, (0.0, 0.0, 0.0), [], envelope(CLIFF))
    assert "ground" in safe.limited_by
    assert safe.velocity[2] > 0.0 or safe.velocity[0] < 10.0


def test_on_level_ground_it_is_the_band() -> None:
    level = envelope(flat(BOUNDS, 100.0))
    safe = constrain((3.0, 4.0, 1.0), (300.0, 300.0, 140.0), (0.0, 0.0, 0.0), [], level)
    assert safe.velocity == (3.0, 4.0, 1.0)
    top = constrain((0.0, 0.0, 5.0), (300.0, 300.0, 180.0), (0.0, 0.0, 0.0), [], level)
    assert top.velocity[2] <= 1e-6


def test_landing_is_free_to_come_down() -> None:
    rules = envelope(flat(BOUNDS, 100.0))
    here, still = (300.0, 300.0, 106.0), (0.0, 0.0, 0.0)
    assert constrain((0.0, 0.0, -2.0), here, still, [], rules).velocity[2] > 0.0
    down = constrain((0.0, 0.0, -2.0), here, still, [], rules, keep_band=False)
    assert down.velocity == (0.0, 0.0, -2.0)


def test_what_drives_has_no_vertical_speed_and_stops_before_slopes_too_steep() -> None:
    rules = envelope(CLIFF, drives=True, steepest=radians(40))
    place, velocity = (200.0, 300.0, 0.0), (0.0, 0.0, 0.0)
    for _ in range(600):
        safe = constrain((8.0, 0.0, 3.0), place, velocity, [], rules).velocity
        assert safe[2] == 0.0
        velocity = moved(velocity, [0.4 * (s - v) for v, s in zip(velocity, safe, strict=True)])
        place = (place[0] + STEP_S * velocity[0], place[1], 0.0)
    assert 280.0 < place[0] < 290.0  # the cliff begins at 290 m


def test_what_stands_too_steep_may_leave() -> None:
    rules = envelope(CLIFF, drives=True, steepest=radians(40))
    here, still = (295.0, 300.0, 45.0), (0.0, 0.0, 0.0)
    assert constrain((-5.0, 0.0, 0.0), here, still, [], rules).velocity == (-5.0, 0.0, 0.0)


def test_robots_keep_apart_in_the_plane() -> None:
    rules = envelope(HILLS, drives=True)
    here = (300.0, 300.0, float(HILLS.height_at((300.0, 300.0))))
    beside = Traffic(2, (302.0, 300.0, here[2] + 1.0), (0.0, 0.0, 0.0))
    x, y, z = constrain((5.0, 0.0, 0.0), here, (0.0, 0.0, 0.0), [beside], rules).velocity
    assert x < 0.0
    assert z == 0.0
    assert hypot(x, y) <= rules.speed_m_s + 1e-9
    above = Traffic(2, (302.0, 300.0, here[2] + 30.0), (0.0, 0.0, 0.0))
    free = constrain((5.0, 0.0, 0.0), here, (0.0, 0.0, 0.0), [above], rules).velocity
    assert free == (5.0, 0.0, 0.0)
