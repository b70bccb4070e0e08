"""The filter of aircraft that cannot stop, flown by the guidance model."""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np
import pytest

from planners.terrain import Terrain
from sim_vehicles.dynamics import Setpoints
from sim_vehicles.dynamics.plane import GuidedPlane
from uavbridge.safety import winged
from uavbridge.safety.envelope import Envelope
from uavbridge.safety.filter import Traffic

OPEN = Envelope(
    -1e4, -1e4, 1e4, 1e4, 20.0, 400.0,
    speed_m_s=50.0, climb_m_s=8.0, sink_m_s=6.0, separation_m=15.0, slowest_m_s=22.0,
)  # fmt: skip


def flown(places, headings, wanted, envelope, seconds, speed=40.0):
    """Tracks (k, n, 3) and airspeeds (k, n) of aircraft that all keep to the filter."""
    n = len(places)
    model = GuidedPlane(
        np.array(places, dtype=float), np.array(headings), airspeed=np.full(n, speed)
    )
    setpoints = Setpoints.idle(n)
    setpoints.motors[:] = True
    track, air = [], []
    for _ in range(round(seconds / 0.1)):
        states = model.states
        others = [
            Traffic(k, tuple(states.position[k].tolist()), tuple(states.velocity[k].tolist()))
            for k in range(n)
        ]
        for k in range(n):
            position, velocity = others[k].position, others[k].velocity
            safe = winged.constrain(
                wanted(k, position), position, velocity, others[:k] + others[k + 1 :], envelope
            )
            setpoints.velocity[k] = safe.velocity
        for _ in range(5):
            model.step(setpoints, np.zeros((n, 3)), 0.02)
        track.append(states.position.copy())
        air.append(states.airspeed.copy())
    return np.array(track), np.array(air)


def least_gap(track):
    gap = np.linalg.norm(track[:, :, None] - track[:, None], axis=-1)
    gap[:, np.arange(track.shape[1]), np.arange(track.shape[1])] = np.inf
    return float(gap.min())


def test_what_breaks_no_rule_is_left_alone():
    safe = winged.constrain((30.0, 5.0, 1.0), (0, 0, 100), (30.0, 0.0, 0.0), [], OPEN)
    assert safe.velocity == pytest.approx((30.0, 5.0, 1.0))
    assert safe.limited_by == ()


def test_no_setpoint_leaves_the_speeds_that_it_may_fly():
    for wanted, speed in (((12.0, 0.0, 0.0), 22.0), ((0.0, 90.0, 0.0), 50.0)):
        safe = winged.constrain(wanted, (0, 0, 100), (30.0, 0.0, 0.0), [], OPEN)
        assert hypot(*safe.velocity[:2]) == pytest.approx(speed)
        assert "speed" in safe.limited_by


def test_to_stand_still_is_to_circle():
    track, air = flown([(0, 0, 100)], [0.0], lambda k, at: (0.0, 0.0, 0.0), OPEN, 60.0)
    assert air.min() > 20.0
    assert np.abs(track[300:, 0, :2] - track[300:, 0, :2].mean(axis=0)).max() < 200.0
    assert track[-1, 0, 2] == pytest.approx(100.0, abs=1.0)


@pytest.mark.parametrize("side", [0.0, 3.0, -8.0])
def test_two_head_on_pass(side):
    goals = [(40.0, 0.0, 0.0), (-40.0, 0.0, 0.0)]
    places = [(-500.0, 0.0, 100.0), (500.0, side, 100.0)]
    track, air = flown(places, [0.0, pi], lambda k, at: goals[k], OPEN, 20.0)
    assert least_gap(track) > 12.0
    assert track[-1, 0, 0] > 200.0
    assert air.min() > 20.0


def test_six_that_meet_in_one_point_all_pass():
    angles = [k * pi / 3 + 0.05 * k for k in range(6)]
    places = [(-600.0 * cos(a), -600.0 * sin(a), 150.0) for a in angles]
    aims = [(40.0 * cos(a), 40.0 * sin(a), 0.0) for a in angles]
    track, _ = flown(places, angles, lambda k, at: aims[k], OPEN, 30.0)
    assert least_gap(track) > 10.0


def test_a_flock_abreast_in_a_turn_is_left_alone():
    """Neighbours that turn together are not taken for intruders."""
    velocity = (50.0, 0.0, 0.0)
    mates = [Traffic(k, (0.0, 28.0 * k, 100.0), velocity) for k in (-1, 1)]
    safe = winged.constrain((49.5, 5.0, 0.0), (0, 0, 100), velocity, mates, OPEN)
    assert safe.limited_by == ()


@pytest.mark.parametrize("shift", [0.0, 120.0])
def test_a_hill_in_the_way_is_passed(shift):
    x = np.arange(-2000.0, 2001.0, 40.0)
    hill = 500.0 * np.exp(-(x[:, None] ** 2 + (x[None] - shift) ** 2) / (2 * 250.0**2))
    ground = Terrain(-2000.0, -2000.0, 40.0, hill)
    envelope = Envelope(
        -1e4, -1e4, 1e4, 1e4, 20.0, 400.0,
        speed_m_s=50.0, climb_m_s=8.0, sink_m_s=6.0, separation_m=15.0, slowest_m_s=22.0,
        terrain=ground,
    )  # fmt: skip
    track, air = flown(
        [(-1500.0, 0.0, 120.0)], [0.0], lambda k, at: (45.0, 0.0, 0.0), envelope, 75.0, 45.0
    )
    above = track[:, 0, 2] - ground.height_at(track[:, 0])
    assert above.min() > 10.0
    assert track[-1, 0, 0] > 800.0
    assert air.min() > 20.0


def test_the_fence_turns_it_back():
    envelope = Envelope(
        -800.0, -800.0, 800.0, 800.0, 20.0, 400.0,
        speed_m_s=50.0, climb_m_s=8.0, sink_m_s=6.0, separation_m=15.0, slowest_m_s=22.0,
    )  # fmt: skip
    track, _ = flown([(0.0, 0.0, 100.0)], [0.3], lambda k, at: (50.0, 10.0, 0.0), envelope, 60.0)
    assert np.abs(track[..., :2]).max() < 815.0


def test_it_comes_down_to_the_lowest_height_and_no_lower():
    track, _ = flown([(0, 0, 100)], [0.0], lambda k, at: (35.0, 0.0, -6.0), OPEN, 40.0)
    assert track[-1, 0, 2] == pytest.approx(23.0, abs=5.0)
    assert track[:, 0, 2].min() > 18.0


def test_it_climbs_to_the_ceiling_and_no_higher():
    track, _ = flown([(0, 0, 330)], [0.0], lambda k, at: (35.0, 0.0, 8.0), OPEN, 40.0)
    assert track[-1, 0, 2] == pytest.approx(390.0, abs=15.0)
    assert track[:, 0, 2].max() < 405.0
