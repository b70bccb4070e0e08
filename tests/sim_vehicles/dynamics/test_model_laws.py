"""Laws that every vehicle model keeps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim_vehicles.dynamics import MODELS, Setpoints

STEP_S = 0.02
FIELDS = (
    *("position", "velocity", "roll", "pitch", "yaw", "rates"),
    *("thrust", "battery", "current", "voltage", "on_ground"),
)


def random_setpoints(rng: np.random.Generator, n: int) -> Setpoints:
    """Any mixture of asked, missing and infinite parts."""
    setpoints = Setpoints.idle(n)
    setpoints.position[:] = rng.normal(0.0, 60.0, (n, 3))
    setpoints.velocity[:] = rng.normal(0.0, 8.0, (n, 3))
    setpoints.yaw[:] = rng.uniform(-7.0, 7.0, n)
    setpoints.yaw_rate[:] = rng.normal(0.0, 2.0, n)
    for part in (setpoints.position, setpoints.velocity, setpoints.yaw, setpoints.yaw_rate):
        part[rng.random(part.shape) < 0.4] = np.nan
        part[rng.random(part.shape) < 0.05] = np.inf
    for bound in (setpoints.max_speed, setpoints.max_up, setpoints.max_down):
        bound[:] = rng.choice([0.0, 0.7, 5.0, np.inf], n)
    setpoints.motors[:] = rng.random(n) < 0.9
    return setpoints


def pick(setpoints: Setpoints, k: int) -> Setpoints:
    return Setpoints(*(getattr(setpoints, name)[k : k + 1].copy() for name in Setpoints.__slots__))


def start(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    position = rng.normal(0.0, 20.0, (n, 3))
    position[:, 2] = rng.choice([0.0, 0.5, 20.0, -3.0], n)
    return position, rng.uniform(-np.pi, np.pi, n)


@pytest.mark.parametrize("name", MODELS)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_any_setpoints_give_finite_states(name, seed):
    rng = np.random.default_rng(seed)
    model = MODELS[name](*start(rng, 8))
    battery = model.states.battery.copy()
    for _ in range(8):
        setpoints, wind = random_setpoints(rng, 8), rng.normal(0.0, 6.0, (8, 3))
        for _ in range(10):
            model.step(setpoints, wind, STEP_S)
            assert np.all(model.states.battery <= battery)
            battery = model.states.battery.copy()
        for field in FIELDS:
            assert np.all(np.isfinite(getattr(model.states, field))), field
        assert np.all(np.abs(model.states.yaw) <= np.pi + 1e-12)
        assert np.all(model.states.position[:, 2] >= -3.0)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("n", [2, 7, 16])
def test_a_batch_is_exactly_its_vehicles_one_by_one(name, n):
    rng = np.random.default_rng(n)
    position, yaw = start(rng, n)
    batch = MODELS[name](position, yaw)
    singles = [MODELS[name](position[k : k + 1], yaw[k : k + 1]) for k in range(n)]
    for _ in range(12):
        setpoints, wind = random_setpoints(rng, n), rng.normal(0.0, 4.0, (n, 3))
        for _ in range(15):
            batch.step(setpoints, wind, STEP_S)
        for k, single in enumerate(singles):
            for _ in range(15):
                single.step(pick(setpoints, k), wind[k : k + 1], STEP_S)
    for k, single in enumerate(singles):
        for field in FIELDS:
            ours, alone = getattr(batch.states, field)[k], getattr(single.states, field)[0]
            assert np.array_equal(ours, alone), (k, field)


@pytest.mark.parametrize("name", MODELS)
def test_the_same_inputs_give_the_same_bytes(name):
    def flown() -> bytes:
        rng = np.random.default_rng(5)
        model = MODELS[name](*start(rng, 6))
        for _ in range(100):
            model.step(random_setpoints(rng, 6), rng.normal(0.0, 4.0, (6, 3)), STEP_S)
        return b"".join(getattr(model.states, field).tobytes() for field in FIELDS)

    assert flown() == flown()


@pytest.mark.parametrize("name", MODELS)
def test_setpoints_and_wind_are_left_as_they_were(name):
    rng = np.random.default_rng(1)
    model = MODELS[name](*start(rng, 6))
    setpoints, wind = random_setpoints(rng, 6), np.ones((6, 3))
    before = [getattr(setpoints, part).copy() for part in Setpoints.__slots__]
    for part in Setpoints.__slots__:
        getattr(setpoints, part).flags.writeable = False
    wind.flags.writeable = False
    model.step(setpoints, wind, STEP_S)
    for part, old in zip(Setpoints.__slots__, before, strict=True):
        assert np.array_equal(getattr(setpoints, part), old, equal_nan=part != "motors")


@pytest.mark.parametrize("name", MODELS)
def test_states_stay_the_same_object_and_arrays(name):
    model = MODELS[name](np.zeros((3, 3)), np.zeros(3))
    states = model.states
    arrays = [getattr(states, field) for field in FIELDS]
    setpoints = Setpoints.idle(3)
    setpoints.motors[:] = True
    setpoints.position[:] = 4.0, 3.0, 5.0
    for _ in range(200):
        model.step(setpoints, np.zeros((3, 3)), STEP_S)
    assert model.states is states
    assert all(getattr(states, f) is a for f, a in zip(FIELDS, arrays, strict=True))
    assert np.all(states.position[:, 2] > 1.0)


@pytest.mark.parametrize("name", MODELS)
def test_states_can_be_moved_in_place(name):
    model = MODELS[name](np.array([[0.0, 0.0, 30.0]] * 2), np.zeros(2))
    setpoints = Setpoints.idle(2)
    setpoints.motors[:] = True
    setpoints.velocity[:] = 0.0
    model.states.position[1] = 7.0, 8.0, 40.0
    for _ in range(20):
        model.step(setpoints, np.zeros((2, 3)), STEP_S)
    assert np.allclose(model.states.position, [[0, 0, 30], [7, 8, 40]], atol=0.01)


@pytest.mark.parametrize("name", MODELS)
def test_position_and_velocity_together_follow_a_moving_target(name):
    model = MODELS[name](np.array([[0.0, 0.0, 30.0]]), np.zeros(1))
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    setpoints.velocity[:] = 6.0, 0.0, 0.0
    for k in range(600):
        setpoints.position[:] = 6.0 * k * STEP_S, 0.0, 30.0
        model.step(setpoints, np.zeros((1, 3)), STEP_S)
    behind = 6.0 * 600 * STEP_S - model.states.position[0, 0]
    assert abs(behind) < 0.25
    assert model.states.velocity[0, 0] == pytest.approx(6.0, abs=0.1)


@pytest.mark.parametrize("name", MODELS)
def test_velocity_and_height_can_be_asked_for_on_different_axes(name):
    model = MODELS[name](np.array([[0.0, 0.0, 30.0]]), np.zeros(1))
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    setpoints.velocity[:] = 3.0, -2.0, np.nan
    setpoints.position[:] = np.nan, np.nan, 34.0
    for _ in range(500):
        model.step(setpoints, np.zeros((1, 3)), STEP_S)
    assert model.states.velocity[0] == pytest.approx([3.0, -2.0, 0.0], abs=0.1)
    assert model.states.position[0, 2] == pytest.approx(34.0, abs=0.1)


@pytest.mark.parametrize("name", MODELS)
def test_max_speed_bounds_what_a_position_error_asks_for(name):
    model = MODELS[name](np.array([[0.0, 0.0, 30.0]]), np.zeros(1))
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    setpoints.position[:] = 300.0, 400.0, 90.0
    setpoints.max_speed[:], setpoints.max_up[:] = 5.0, 0.8
    for _ in range(400):
        model.step(setpoints, np.zeros((1, 3)), STEP_S)
    assert model.states.velocity[0] == pytest.approx([3.0, 4.0, 0.8], abs=0.06)


@pytest.mark.parametrize("name", MODELS)
def test_motors_off_means_falling_and_then_rest(name):
    model = MODELS[name](np.array([[0.0, 0.0, 50.0], [0.0, 0.0, 0.0]]), np.zeros(2))
    setpoints = Setpoints.idle(2)
    setpoints.position[:] = 0.0, 0.0, 60.0
    for _ in range(50):
        model.step(setpoints, np.zeros((2, 3)), STEP_S)
    assert -10.0 < model.states.velocity[0, 2] < -7.0
    assert list(model.states.on_ground) == [False, True]
    for _ in range(500):
        model.step(setpoints, np.zeros((2, 3)), STEP_S)
    assert model.states.on_ground.all()
    assert not model.states.position.any()
    assert not model.states.velocity.any()


@pytest.mark.parametrize("name", MODELS)
def test_a_full_battery_hovers_about_twenty_minutes_and_then_falls(name):
    model = MODELS[name](np.array([[0.0, 0.0, 30.0]]), np.zeros(1))
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    setpoints.position[:] = 0.0, 0.0, 30.0
    full = model.states.voltage[0]
    for _ in range(50 * 60):
        model.step(setpoints, np.zeros((1, 3)), STEP_S)
    minutes = 1.0 / (1.0 - model.states.battery[0])
    assert minutes == pytest.approx(20.0, abs=1.0)
    assert model.states.voltage[0] < full
    model.states.battery[:] = 1e-7
    for _ in range(500):
        model.step(setpoints, np.zeros((1, 3)), STEP_S)
    assert model.states.battery[0] == 0.0
    assert model.states.on_ground[0]
