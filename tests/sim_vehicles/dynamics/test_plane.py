"""Fixed-wing aircraft: trim, steps, paths, the envelope, and the cheap model beside the other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from planners.paths.dubins import airplane
from planners.terrain import flat
from sim_vehicles.dynamics import F64, Setpoints
from sim_vehicles.dynamics.plane import GuidedPlane, PlaneParams, SixDof
from sim_vehicles.dynamics.plane.follow import Follower
from sim_vehicles.dynamics.plane.guide import Guide

STEP_S = 0.02
LIMITS = PlaneParams().limits
MODELS: tuple[type[SixDof] | type[GuidedPlane], ...] = (SixDof, GuidedPlane)


def flown(
    model: SixDof | GuidedPlane,
    ask: Callable[[Setpoints], None],
    seconds: float,
    wind: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> F64:
    """Rows of time, of (n, 11): position, velocity, roll, pitch, yaw, airspeed, battery."""
    n = len(model.states.yaw)
    setpoints = Setpoints.idle(n)
    setpoints.motors[:] = True
    ask(setpoints)
    air = np.tile(np.array(wind), (n, 1))
    rows = []
    for _ in range(round(seconds / STEP_S)):
        model.step(setpoints, air, STEP_S)
        now = model.states
        angles = (now.roll, now.pitch, now.yaw, now.airspeed, now.battery)
        rows.append(np.column_stack((now.position, now.velocity, *angles)))
    return np.array(rows)


def in_air(make: type[SixDof] | type[GuidedPlane], airspeed: list[float]) -> SixDof | GuidedPlane:
    n = len(airspeed)
    position = np.tile((0.0, 0.0, 200.0), (n, 1))
    return make(position, np.zeros(n), airspeed=np.array(airspeed))


@pytest.mark.parametrize("make", MODELS)
def test_trim_holds(make):
    speeds = [22.0, 35.0, 50.0, 65.0]

    def ask(setpoints: Setpoints) -> None:
        setpoints.velocity[:, 0] = speeds
        setpoints.velocity[:, 1] = 0.0
        setpoints.position[:, 2] = 200.0

    rows = flown(in_air(make, speeds), ask, 20.0)
    assert np.abs(rows[:, :, 2] - 200.0).max() < 0.2
    assert np.abs(rows[:, :, 9] - speeds).max() < 0.1
    assert np.abs(rows[:, :, 1]).max() < 0.1


def test_trim_of_the_book():
    """Level flight at 35 m/s: lift is weight, and no moment pitches it."""
    k = PlaneParams()
    attack, elevator, drag = k.trim(np.array([35.0]), np.array([9.80665]), np.zeros(1))
    pressure = 0.5 * k.air * 35.0**2 * k.area
    lift = pressure * (k.lift_0 + k.lift_a * attack + k.lift_e * elevator)
    assert lift == pytest.approx(k.mass * 9.80665, rel=1e-9)
    assert k.pitch_0 + k.pitch_a * attack + k.pitch_e * elevator == pytest.approx(0.0, abs=1e-12)
    assert drag == pytest.approx(19.7, abs=1.5)
    top = np.arange(60.0, 90.0)
    drags = k.trim(top, np.full(30, 9.80665), np.zeros(30))[2]
    sustained = top[k.thrust(np.ones(30), top) > drags][-1]
    assert sustained == pytest.approx(75.0, abs=1.5)


@pytest.mark.parametrize("make", MODELS)
def test_a_change_of_course_settles(make):
    speeds = [25.0, 50.0, 65.0]

    def ask(setpoints: Setpoints) -> None:
        setpoints.velocity[:, 0] = 0.0
        setpoints.velocity[:, 1] = speeds
        setpoints.position[:, 2] = 200.0

    rows = flown(in_air(make, speeds), ask, 20.0)
    course = np.arctan2(rows[..., 4], rows[..., 3])
    assert np.abs(course[-1] - np.pi / 2).max() < 0.01
    assert course.max() < np.pi / 2 + 0.06
    assert np.abs(rows[..., 2] - 200.0).max() < 3.0
    assert np.abs(rows[..., 6]).max() <= LIMITS.bank_rad + 0.05


@pytest.mark.parametrize("make", MODELS)
def test_a_change_of_height_settles(make):
    rise = np.array([-60.0, 5.0, 80.0])

    def ask(setpoints: Setpoints) -> None:
        setpoints.velocity[:, :2] = (40.0, 0.0)
        setpoints.position[:, 2] = 200.0 + rise

    rows = flown(in_air(make, [40.0] * 3), ask, 25.0)
    beyond = rows[..., 2] - 200.0 - rise
    assert np.abs(beyond[-1]).max() < 0.3
    assert ((np.sign(rise) * beyond).max(axis=0) < 0.05 * np.abs(rise) + 0.3).all()
    assert np.abs(rows[..., 9] - 40.0).max() < 3.0


@pytest.mark.parametrize("make", MODELS)
def test_an_orbit_in_the_wind(make):
    def ask(setpoints: Setpoints) -> None:
        setpoints.position[:] = (400.0, 100.0, 220.0)
        setpoints.radius[:] = (250.0, -250.0)

    rows = flown(in_air(make, [35.0, 35.0]), ask, 60.0, wind=(6.0, -3.0, 0.0))
    late = rows[1500:]
    away = np.hypot(late[..., 0] - 400.0, late[..., 1] - 100.0)
    assert np.abs(away - 250.0).max() < 6.0
    assert np.abs(late[..., 2] - 220.0).max() < 0.5
    spin = np.diff(
        np.unwrap(np.arctan2(late[..., 1] - 100.0, late[..., 0] - 400.0), axis=0), axis=0
    )
    assert (spin[:, 0] > 0.0).all()  # counter-clockwise where the radius is positive
    assert (spin[:, 1] < 0.0).all()


@pytest.mark.parametrize("make", MODELS)
def test_a_line_is_joined_and_held_in_a_cross_wind(make):
    def ask(setpoints: Setpoints) -> None:
        setpoints.position[:] = (0.0, 120.0, 180.0)
        setpoints.velocity[:] = (35.0, 0.0, 0.0)

    rows = flown(in_air(make, [35.0]), ask, 60.0, wind=(0.0, 8.0, 0.0))[:, 0]
    assert abs(rows[-1, 1] - 120.0) < 1.0
    assert rows[:, 1].max() < 125.0
    assert abs(rows[-1, 3] - 35.0) < 0.5


@pytest.mark.parametrize("make", MODELS)
def test_nothing_asked_is_a_circle_not_a_stop(make):
    rows = flown(in_air(make, [30.0]), lambda setpoints: None, 40.0)[:, 0]
    assert rows[:, 9].min() > LIMITS.slowest_m_s
    assert np.abs(rows[1000:, :2] - rows[1000:, :2].mean(axis=0)).max() < 200.0


@pytest.mark.parametrize("make", MODELS)
def test_it_takes_off_and_stops_after_landing(make):
    model = make(np.zeros((1, 3)), np.zeros(1), terrain=flat((-1e4, -1e4, 1e4, 1e4)))

    def climb(setpoints: Setpoints) -> None:
        setpoints.velocity[:, :2] = (35.0, 0.0)
        setpoints.position[:, 2] = 30.0

    rows = flown(model, climb, 20.0)[:, 0]
    assert rows[-1, 2] == pytest.approx(30.0, abs=0.5)
    run = rows[rows[:, 2] > 0.5][0, 0]
    assert 10.0 < run < 300.0

    def sink(setpoints: Setpoints) -> None:
        setpoints.velocity[:] = (25.0, 0.0, -3.0)

    rows = flown(model, sink, 28.0)[:, 0]
    assert rows[-1, 2] == 0.0
    assert np.abs(rows[-1, 3:6]).max() < 1e-9


@pytest.mark.parametrize("make", MODELS)
def test_without_power_it_glides(make):
    model = in_air(make, [35.0])
    model.states.battery[:] = 0.0

    def ask(setpoints: Setpoints) -> None:
        setpoints.velocity[:, :2] = (35.0, 0.0)

    rows = flown(model, ask, 30.0)[:, 0]
    assert rows[:, 9].min() > 16.0  # above the stall
    assert 0.0 < rows[-1, 2] < 196.0


@pytest.mark.parametrize("make", MODELS)
def test_any_setpoints_stay_inside_the_envelope(make):
    n, rng = 60, np.random.default_rng(7)
    position = np.tile((0.0, 0.0, 5000.0), (n, 1))
    model = make(position, rng.uniform(-3.0, 3.0, n), airspeed=rng.uniform(22.0, 65.0, n))
    for _ in range(6):
        setpoints = Setpoints.idle(n)
        setpoints.motors[:] = True
        setpoints.position[:] = model.states.position + rng.normal(0.0, 300.0, (n, 3))
        setpoints.velocity[:] = rng.normal(0.0, 40.0, (n, 3))
        setpoints.yaw_rate[:] = rng.normal(0.0, 1.0, n)
        setpoints.max_speed[:] = rng.choice([0.0, 5.0, 40.0, np.inf], n)
        setpoints.position[rng.random((n, 3)) < 0.5] = np.nan
        setpoints.velocity[rng.random((n, 3)) < 0.5] = np.inf
        setpoints.yaw_rate[rng.random(n) < 0.5] = np.nan
        for _ in range(150):
            model.step(setpoints, np.zeros((n, 3)), STEP_S)
            now = model.states
            assert now.airspeed.min() > 0.85 * LIMITS.slowest_m_s
            assert now.airspeed.max() < 1.1 * LIMITS.fastest_m_s
            assert np.abs(now.roll).max() < LIMITS.bank_rad + 0.2
            assert np.abs(now.pitch).max() < 0.9
            assert (np.abs(now.yaw) <= np.pi).all()


@pytest.mark.parametrize("make", MODELS)
def test_an_attitude_is_flown(make):
    roll, pitch, throttle = [0.0, 0.4, -0.4, 0.0], [0.0, 0.05, 0.05, 0.1], [0.5, 0.6, 0.6, np.nan]

    def ask(setpoints: Setpoints) -> None:
        setpoints.attitude[:] = np.column_stack((roll, pitch, throttle))

    rows = flown(in_air(make, [35.0] * 4), ask, 20.0)[500:]
    assert np.abs(rows[:, :, 6] - roll).max() < 0.02
    assert np.abs(rows[:, :, 7] - pitch).max() < 0.02
    turned = np.sin(rows[-1, 1:3, 8] - rows[0, 1:3, 8])
    assert turned[0] == pytest.approx(-turned[1], abs=0.01)  # right wing down: clockwise
    assert rows[:, 3, 9] == pytest.approx(LIMITS.trim_m_s, abs=0.5)  # the throttle's business


@pytest.mark.parametrize("make", MODELS)
def test_no_attitude_stalls_or_overspeeds(make):
    angles = np.array([-0.9, 0.0, 0.9]), np.array([-0.5, 0.0, 0.5, np.nan]), np.array([0.0, 1.0])
    asked = np.stack([part.ravel() for part in np.meshgrid(*angles)], axis=1)

    def ask(setpoints: Setpoints) -> None:
        setpoints.attitude[:] = asked

    n = len(asked)
    high = np.tile((0.0, 0.0, 5000.0), (n, 1))
    rows = flown(make(high, np.zeros(n), airspeed=np.linspace(21.0, 66.0, n)), ask, 25.0)
    assert rows[:, :, 9].min() > LIMITS.slowest_m_s - 0.5
    assert rows[:, :, 9].max() < LIMITS.fastest_m_s
    assert np.abs(rows[:, :, 6]).max() < LIMITS.bank_rad + 0.1


@pytest.mark.parametrize("make", MODELS)
def test_a_batch_is_exactly_its_aircraft_one_by_one(make):
    n, rng = 5, np.random.default_rng(3)
    position = rng.normal(0.0, 20.0, (n, 3))
    position[:, 2] = (0.0, 20.0, 300.0, -3.0, 80.0)
    yaw = rng.uniform(-3.0, 3.0, n)
    batch = make(position, yaw)
    singles = [make(position[k : k + 1], yaw[k : k + 1]) for k in range(n)]
    setpoints = Setpoints.idle(n)
    setpoints.motors[:] = True
    setpoints.velocity[:] = rng.normal(0.0, 30.0, (n, 3))
    setpoints.position[:3] = rng.normal(0.0, 200.0, (3, 3))
    wind = rng.normal(0.0, 4.0, (n, 3))
    for _ in range(100):
        batch.step(setpoints, wind, STEP_S)
    for k, single in enumerate(singles):
        alone = [getattr(setpoints, name)[k : k + 1] for name in Setpoints.__slots__]
        for _ in range(100):
            single.step(Setpoints(*alone), wind[k : k + 1], STEP_S)
        for field in ("position", "velocity", "roll", "pitch", "yaw", "battery", "airspeed"):
            ours = getattr(batch.states, field)[k]
            assert np.array_equal(ours, getattr(single.states, field)[0]), field


def test_the_guidance_model_flies_about_as_the_other():
    """Forty changes of course, height and speed at once; 12 s apart by 1.5 s of flight at most."""
    n, rng = 40, np.random.default_rng(11)
    course, rise = rng.uniform(-3.0, 3.0, n), rng.uniform(-40.0, 40.0, n)
    speed = rng.uniform(28.0, 60.0, n)

    def ask(setpoints: Setpoints) -> None:
        setpoints.velocity[:, 0] = speed * np.cos(course)
        setpoints.velocity[:, 1] = speed * np.sin(course)
        setpoints.position[:, 2] = 200.0 + rise

    one, other = (flown(in_air(make, [40.0] * n), ask, 12.0) for make in MODELS)
    apart = np.linalg.norm(one[..., :3] - other[..., :3], axis=-1)
    assert (apart.max(axis=0) < 1.5 * speed).all()


def test_wants_are_finite_far_from_anything():
    guide = Guide(LIMITS)
    setpoints = Setpoints.idle(1)
    setpoints.position[:] = 1e7
    zero = np.zeros((3, 1))
    wanted = guide.wanted(setpoints, zero, zero, np.zeros(1), zero)
    assert all(np.isfinite(part).all() for part in (wanted.roll, wanted.climb, wanted.airspeed))


@pytest.mark.parametrize("make", MODELS)
@pytest.mark.parametrize("rise", [60.0, 500.0])
def test_a_dubins_path_is_followed_to_its_end(make, rise):
    start = np.array((0.0, 0.0, 200.0, 0.0))
    path = airplane(start, (600.0, 500.0, 200.0 + rise, 2.5), 150.0, 0.25)
    assert path.case == ("low" if rise < 100.0 else "high")
    model = make(start[None, :3], start[3:], airspeed=np.array([30.0]))
    follower = Follower(path, 30.0)
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    points, off = path.points(2.0)[:, :3], []
    for step in range(round(1.2 * path.length / 30.0 / STEP_S)):
        place = model.states.position[0]
        if step % 5 == 0:
            target = follower.target(place)
            setpoints.position[0], setpoints.velocity[0] = target.position, target.velocity
            setpoints.yaw_rate[0] = target.turn
            off.append(float(np.linalg.norm(points - place, axis=1).min()))
        if target.done:
            break
        model.step(setpoints, np.zeros((1, 3)), STEP_S)
    assert target.done
    assert max(off) < 8.0
    assert np.linalg.norm(model.states.position[0] - points[-1]) < 8.0
