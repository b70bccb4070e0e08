from __future__ import annotations

import numpy as np
import pytest

from sim_vehicles.dynamics import PerfectTracking, Setpoints

STEP_S = 0.02
CALM = np.zeros((1, 3))


def hovering() -> tuple[PerfectTracking, Setpoints]:
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    return PerfectTracking(np.array([[0.0, 0.0, 30.0]]), np.zeros(1)), setpoints


def test_a_velocity_is_flown_at_once():
    model, setpoints = hovering()
    setpoints.velocity[:] = 3.0, 4.0, 1.0
    model.step(setpoints, CALM, STEP_S)
    assert list(model.states.velocity[0]) == [3.0, 4.0, 1.0]
    assert model.states.position[0] == pytest.approx([0.06, 0.08, 30.02])


def test_a_position_is_reached_as_fast_as_limits_allow_and_kept():
    model, setpoints = hovering()
    setpoints.position[:] = 24.0, 0.0, 30.0
    for _ in range(100):
        model.step(setpoints, CALM, STEP_S)
    assert model.states.position[0] == pytest.approx([24.0, 0.0, 30.0])
    model.step(setpoints, CALM, STEP_S)
    assert model.states.velocity[0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


def test_speeds_are_limited():
    model, setpoints = hovering()
    setpoints.velocity[:] = 30.0, 40.0, -9.0
    model.step(setpoints, CALM, STEP_S)
    assert model.states.velocity[0] == pytest.approx([7.2, 9.6, -1.5])


def test_yaw_is_taken_at_once():
    model, setpoints = hovering()
    setpoints.yaw[:] = 4.0
    model.step(setpoints, CALM, STEP_S)
    assert model.states.yaw[0] == pytest.approx(4.0 - 2.0 * np.pi)


def test_it_takes_off_and_lands():
    model = PerfectTracking(np.zeros((1, 3)), np.zeros(1))
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    setpoints.velocity[:] = 0.0, 0.0, 1.0
    model.step(setpoints, CALM, STEP_S)
    assert not model.states.on_ground[0]
    setpoints.velocity[:] = 0.0, 0.0, -1.0
    for _ in range(3):
        model.step(setpoints, CALM, STEP_S)
    assert model.states.on_ground[0]
    assert not model.states.position.any()
