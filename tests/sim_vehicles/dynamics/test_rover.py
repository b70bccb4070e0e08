"""Rovers: on the ground, along their heading, no steeper than they can climb."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.terrain import Terrain, mountains
from sim_vehicles.dynamics import Setpoints
from sim_vehicles.dynamics.rover import GroundRover, RoverParams

STEP_S = 0.02
PARAMS = RoverParams()


def incline(slope_rad):
    heights = np.repeat(np.tan(slope_rad) * 10.0 * np.arange(101)[:, None], 101, axis=1)
    return Terrain(0.0, 0.0, 10.0, heights)


def rover(terrain=None, place=(200.0, 200.0, 0.0), yaw=0.0):
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    return GroundRover(np.array([place]), np.array([yaw]), terrain=terrain), setpoints


def drive(model, setpoints, seconds):
    for _ in range(round(seconds / STEP_S)):
        model.step(setpoints, np.zeros_like(setpoints.position), STEP_S)
    return model.states


def test_a_velocity_on_level_ground():
    model, setpoints = rover()
    setpoints.velocity[:] = 0.0, 8.0, 3.0
    states = drive(model, setpoints, 5.0)
    assert states.velocity[0] == pytest.approx((0.0, 8.0, 0.0), abs=1e-3)
    assert states.yaw[0] == pytest.approx(math.pi / 2, abs=1e-3)
    assert states.position[0, 2] == 0.0
    assert states.on_ground.all()
    assert 0.99 < states.battery[0] < 1.0


def test_a_point_is_reached_and_kept():
    model, setpoints = rover()
    setpoints.position[:] = 240.0, 230.0, np.nan
    states = drive(model, setpoints, 15.0)
    assert states.position[0] == pytest.approx((240.0, 230.0, 0.0), abs=0.2)
    assert np.linalg.norm(states.velocity) < 0.2


def test_the_speed_along_the_ground_is_limited():
    model, setpoints = rover(incline(math.radians(20.0)))
    setpoints.velocity[:] = -40.0, 0.0, np.nan
    states = drive(model, setpoints, 8.0)
    assert np.linalg.norm(states.velocity) == pytest.approx(PARAMS.speed_m_s, rel=1e-3)


def test_uphill_it_is_slower_and_at_the_steepest_it_stands():
    speeds = []
    for slope_deg in (0.0, 10.0, 20.0, 30.0, 36.0, 60.0):
        model, setpoints = rover(incline(math.radians(slope_deg)))
        setpoints.velocity[:] = 12.0, 0.0, np.nan
        speeds.append(np.linalg.norm(drive(model, setpoints, 6.0).velocity))
    assert speeds[:4] == sorted(speeds[:4], reverse=True)
    assert speeds[3] > 1.0
    assert speeds[4:] == [0.0, 0.0]


def test_it_leans_with_the_ground():
    up, _ = rover(incline(0.3), yaw=0.0)
    assert (up.states.pitch[0], up.states.roll[0]) == pytest.approx((0.3, 0.0), abs=1e-9)
    left_is_high, _ = rover(incline(0.3), yaw=-math.pi / 2)
    assert left_is_high.states.roll[0] == pytest.approx(0.3), "right side down"


def test_motors_off_it_rolls_out_and_stands():
    model, setpoints = rover()
    setpoints.velocity[:] = 8.0, 0.0, np.nan
    drive(model, setpoints, 3.0)
    setpoints.motors[:] = False
    assert np.linalg.norm(drive(model, setpoints, 4.0).velocity) == 0.0


def test_a_yaw_asked_for_is_turned_to_on_the_spot():
    model, setpoints = rover()
    setpoints.velocity[:] = 0.0
    setpoints.yaw[:] = -2.0
    states = drive(model, setpoints, 3.0)
    assert states.yaw[0] == pytest.approx(-2.0)
    assert states.position[0] == pytest.approx((200.0, 200.0, 0.0))


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10**6))
def test_anywhere_it_stays_on_the_ground_and_climbs_no_more_than_it_can(seed):
    draw = np.random.default_rng(seed)
    terrain = mountains(draw, (0.0, 0.0, 300.0, 300.0), math.radians(55.0))
    n = 20
    model = GroundRover(
        np.concatenate((draw.uniform(50, 250, (n, 2)), np.zeros((n, 1))), -1),
        draw.uniform(-3, 3, n), terrain=terrain,
    )  # fmt: skip
    setpoints = Setpoints.idle(n)
    setpoints.motors[:] = True
    for _ in range(6):
        setpoints.velocity[:] = draw.normal(0.0, 8.0, (n, 3))
        for _ in range(20):
            model.step(setpoints, np.zeros((n, 3)), STEP_S)
            states = model.states
            assert states.position[:, 2] == pytest.approx(terrain.height_at(states.position))
            level = np.hypot(*states.velocity[:, :2].T)
            fast = level > 0.5
            climb = states.velocity[fast, 2] / level[fast]
            assert (climb <= np.tan(PARAMS.climb_rad) + 1e-6).all()
            assert (np.linalg.norm(states.velocity, axis=1) <= 1.2 * PARAMS.speed_m_s).all()
