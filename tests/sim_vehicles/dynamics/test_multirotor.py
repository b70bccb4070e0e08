from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim_vehicles.dynamics import GRAVITY, Multirotor, MultirotorParams, Setpoints, Wind, WindSpec

STEP_S = 0.02
CALM = np.zeros((1, 3))
PARAMS = MultirotorParams()


def hovering(height: float = 30.0, yaw: float = 0.0) -> tuple[Multirotor, Setpoints]:
    model = Multirotor(np.array([[0.0, 0.0, height]]), np.array([yaw]))
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    return model, setpoints


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10, deadline=None)
def test_limits_hold_whatever_is_asked(seed):
    rng = np.random.default_rng(seed)
    n = 16
    model = Multirotor(np.full((n, 3), 2000.0), np.zeros(n))
    setpoints = Setpoints.idle(n)
    setpoints.motors[:] = True
    states, old = model.states, np.zeros((n, 3))
    turn = np.zeros(n)
    for _ in range(6):
        if rng.random() < 0.5:
            setpoints.velocity[:] = np.nan
            setpoints.position[:] = states.position + rng.normal(0.0, 100.0, (n, 3))
        else:
            setpoints.velocity[:] = rng.normal(0.0, 15.0, (n, 3))
            setpoints.position[:] = np.nan
        setpoints.yaw[:] = rng.uniform(-np.pi, np.pi, n)
        for _ in range(rng.integers(10, 200)):
            model.step(setpoints, np.zeros((n, 3)), STEP_S)
            acceleration = (states.velocity - old) / STEP_S
            old = states.velocity.copy()
            tilt = np.arccos(np.cos(states.roll) * np.cos(states.pitch))
            assert np.all(tilt <= PARAMS.tilt_rad + 1e-9)
            assert np.all(np.hypot(*old.T[:2]) <= 1.03 * PARAMS.speed_m_s)
            assert np.all(old[:, 2] <= 1.05 * PARAMS.climb_m_s)
            assert np.all(old[:, 2] >= -1.1 * PARAMS.sink_m_s)
            assert np.all(np.hypot(*acceleration.T[:2]) <= 2.0 * PARAMS.acceleration_m_s2)
            assert np.all(np.abs(acceleration[:, 2]) <= 2.0 * PARAMS.lift_m_s2)
            assert np.all(np.abs(states.rates[:, 2]) <= PARAMS.yaw_rate_rad_s + 1e-9)
            change = np.abs(states.rates[:, 2] - turn) / STEP_S
            assert np.all(change <= PARAMS.yaw_acceleration_rad_s2 + 1e-9)
            turn = states.rates[:, 2].copy()
            assert np.all((states.thrust >= 0.0) & (states.thrust <= 1.0))


def test_acceleration_east_facing_east_is_nose_down():
    model, setpoints = hovering()
    setpoints.velocity[:] = 5.0, 0.0, 0.0
    for _ in range(25):
        model.step(setpoints, CALM, STEP_S)
    assert model.states.pitch[0] < -0.1
    assert abs(model.states.roll[0]) < 1e-9


def test_acceleration_south_facing_east_is_right_wing_down():
    model, setpoints = hovering()
    setpoints.velocity[:] = 0.0, -5.0, 0.0
    for _ in range(25):
        model.step(setpoints, CALM, STEP_S)
    assert model.states.roll[0] > 0.1
    assert abs(model.states.pitch[0]) < 1e-9


@given(yaw=st.floats(-3.1, 3.1), course=st.floats(-3.1, 3.1))
@settings(max_examples=20, deadline=None)
def test_roll_pitch_and_yaw_turn_up_into_the_thrust(yaw, course):
    model, setpoints = hovering(yaw=yaw)
    setpoints.velocity[:] = 5.0 * np.cos(course), 5.0 * np.sin(course), 0.0
    for _ in range(20):
        model.step(setpoints, CALM, STEP_S)
    states = model.states
    roll, pitch, heading = states.roll[0], states.pitch[0], states.yaw[0]
    forward, right = -np.cos(roll) * np.sin(pitch), np.sin(roll)
    east = forward * np.cos(heading) + right * np.sin(heading)
    north = forward * np.sin(heading) - right * np.cos(heading)
    assert np.arctan2(north, east) == pytest.approx(course, abs=1e-6)


def test_rates_are_the_change_of_the_angles():
    model, setpoints = hovering()
    setpoints.velocity[:] = 3.0, 4.0, 0.0
    setpoints.yaw[:] = 1.0
    for _ in range(20):
        before = model.states.roll[0], model.states.pitch[0], model.states.yaw[0]
        model.step(setpoints, CALM, STEP_S)
        after = model.states.roll[0], model.states.pitch[0], model.states.yaw[0]
        change = np.subtract(after, before) / STEP_S
        assert model.states.rates[0, :2] == pytest.approx(change[:2], abs=1e-9)
        assert model.states.rates[0, 2] == pytest.approx(change[2], abs=0.05)


def test_yaw_takes_the_short_way_round():
    model, setpoints = hovering(yaw=3.0)
    setpoints.yaw[:] = -3.0
    for _ in range(100):
        model.step(setpoints, CALM, STEP_S)
        assert abs(model.states.yaw[0]) > 2.9
    assert model.states.yaw[0] == pytest.approx(-3.0, abs=0.01)


def test_a_yaw_rate_alone_is_followed_and_no_yaw_at_all_is_held():
    model, setpoints = hovering(yaw=1.0)
    setpoints.velocity[:] = 5.0, 0.0, 0.0
    for _ in range(100):
        model.step(setpoints, CALM, STEP_S)
    assert model.states.yaw[0] == 1.0
    setpoints.yaw_rate[:] = -0.5
    for _ in range(100):
        model.step(setpoints, CALM, STEP_S)
    assert model.states.rates[0, 2] == pytest.approx(-0.5)


def test_it_stays_on_the_ground_under_a_hold_and_lifts_off_when_asked():
    model = Multirotor(np.zeros((1, 3)), np.zeros(1))
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    setpoints.position[:] = 5.0, 5.0, 0.0
    for _ in range(400):
        model.step(setpoints, np.array([[6.0, 2.0, 0.0]]), STEP_S)
        assert model.states.on_ground[0]
        assert not model.states.position.any()
        assert not model.states.roll.any()
    setpoints.position[:] = 0.0, 0.0, 5.0
    for _ in range(400):
        model.step(setpoints, CALM, STEP_S)
    assert not model.states.on_ground[0]
    assert model.states.position[0, 2] == pytest.approx(5.0, abs=0.1)


def test_it_touches_down_once():
    model, setpoints = hovering(height=3.0)
    setpoints.velocity[:] = 0.3, 0.0, -0.7
    heights, grounded = [], []
    for _ in range(600):
        model.step(setpoints, np.array([[3.0, 0.0, 0.0]]), STEP_S)
        heights.append(model.states.position[0, 2])
        grounded.append(bool(model.states.on_ground[0]))
    first = grounded.index(True)
    assert all(grounded[first:])
    assert not np.any(heights[first:])
    assert np.all(np.diff(heights[:first]) < 0.0)
    assert model.states.thrust[0] < 1.0 / PARAMS.thrust_to_weight


def test_a_vehicle_that_starts_below_the_ground_has_its_ground_there():
    model = Multirotor(np.array([[0.0, 0.0, -4.0]]), np.zeros(1))
    model.step(Setpoints.idle(1), CALM, STEP_S)
    assert model.states.on_ground[0]
    assert model.states.position[0, 2] == -4.0


def test_free_fall_ends_at_the_terminal_velocity():
    model, _ = hovering(height=2000.0)
    for _ in range(1500):
        model.step(Setpoints.idle(1), CALM, STEP_S)
    speed = -model.states.velocity[0, 2]
    drag = PARAMS.drag_linear_1_s * speed + PARAMS.drag_quadratic_1_m * speed**2
    assert drag == pytest.approx(GRAVITY, rel=0.01)


def test_motors_cut_and_restarted_in_the_air_recover():
    model, setpoints = hovering(height=100.0)
    for k in range(600):
        setpoints.motors[:] = k >= 50
        model.step(setpoints, CALM, STEP_S)
    assert np.abs(model.states.velocity).max() < 0.05
    assert model.states.position[0, 2] > 50.0


def test_it_holds_its_place_in_wind_leaning_into_it():
    model, setpoints = hovering()
    setpoints.position[:] = 0.0, 0.0, 30.0
    wind = np.array([[8.0, 0.0, 0.0]])
    for _ in range(1000):
        model.step(setpoints, wind, STEP_S)
    assert np.abs(model.states.position[0] - [0.0, 0.0, 30.0]).max() < 0.05
    push = PARAMS.drag_linear_1_s * 8.0 + PARAMS.drag_quadratic_1_m * 64.0
    assert np.tan(model.states.pitch[0]) == pytest.approx(push / GRAVITY, rel=0.01)


def test_it_holds_its_place_in_gusts():
    n = 20
    model = Multirotor(np.tile([0.0, 0.0, 30.0], (n, 1)), np.zeros(n))
    setpoints = Setpoints.idle(n)
    setpoints.motors[:] = True
    setpoints.position[:] = 0.0, 0.0, 30.0
    wind = Wind(WindSpec((5.0, 0.0, 0.0), gust_m_s=2.0, gust_up_m_s=0.7), n, 3)
    errors = []
    for k in range(2000):
        model.step(setpoints, wind.step(STEP_S), STEP_S)
        if k > 500:
            errors.append(model.states.position - [0.0, 0.0, 30.0])
    spread = np.std(errors, axis=(0, 1))
    assert np.all(spread > 0.01)
    assert np.all(spread < 0.5)


def test_wind_stronger_than_it_can_fly_blows_it_away():
    model, setpoints = hovering()
    setpoints.position[:] = 0.0, 0.0, 30.0
    for _ in range(500):
        model.step(setpoints, np.array([[25.0, 0.0, 0.0]]), STEP_S)
    assert model.states.velocity[0, 0] > 3.0
    assert model.states.position[0, 2] == pytest.approx(30.0, abs=0.5)


def test_climbing_draws_more_current_and_sags_the_voltage():
    model, setpoints = hovering()
    setpoints.velocity[:] = 0.0
    for _ in range(100):
        model.step(setpoints, CALM, STEP_S)
    hover_a, hover_v = model.states.current[0], model.states.voltage[0]
    assert hover_a == pytest.approx(PARAMS.battery.hover_a + PARAMS.battery.avionics_a, rel=0.01)
    setpoints.velocity[:] = 0.0, 0.0, 3.0
    for _ in range(25):
        model.step(setpoints, CALM, STEP_S)
    assert model.states.current[0] > 1.1 * hover_a
    assert model.states.voltage[0] < hover_v


@pytest.mark.parametrize("name", ["speed_m_s", "motor_lag_s", "drag_linear_1_s", "yaw_gain_1_s"])
@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf])
def test_parameters_that_make_no_sense_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        MultirotorParams(**{name: value})


def test_a_lag_of_nothing_is_refused():
    with pytest.raises(ValueError, match="motor_lag_s"):
        MultirotorParams(motor_lag_s=0.0)
