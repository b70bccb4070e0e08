"""The safety filter: rules hold for any input, and for fleets that want to meet."""

from math import hypot, inf, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uavbridge.safety.envelope import DRIFT_M, Braking, Envelope
from uavbridge.safety.filter import Traffic, constrain

BOX = Envelope(0, 0, 1000, 1000, 15, 120)
INSIDE = (500.0, 500.0, 40.0)
REST = (0.0, 0.0, 0.0)

speeds = st.floats(-30, 30)
velocities = st.tuples(speeds, speeds, speeds)
inside = st.tuples(st.floats(0, 1000), st.floats(0, 1000), st.floats(15, 120))


def others(*positions):
    return [Traffic(i + 1, p, (0.0, 0.0, 0.0)) for i, p in enumerate(positions)]


def test_a_free_velocity_within_limits_passes_unchanged():
    safe = constrain((3.0, -4.0, 1.0), INSIDE, REST, [], BOX)
    assert safe.velocity == (3.0, -4.0, 1.0)
    assert safe.limited_by == ()


@given(velocities, inside)
def test_speed_climb_and_sink_are_limited(wanted, position):
    x, y, z = constrain(wanted, position, REST, [], BOX).velocity
    assert hypot(x, y) <= BOX.speed_m_s + 1e-6
    assert -BOX.sink_m_s - 1e-6 <= z <= BOX.climb_m_s + 1e-6


@given(velocities, inside)
def test_nothing_flies_at_the_fence_faster_than_it_can_stop(wanted, position):
    x, _, z = constrain(wanted, position, REST, [], BOX).velocity
    speed = BOX.braking.approach_speed
    assert x <= speed(1000 - DRIFT_M - position[0], 0.0) + 1e-6
    assert -x <= speed(position[0] - DRIFT_M, 0.0) + 1e-6
    assert z <= speed(120 - position[2], 0.0) + 1e-6
    assert -z <= speed(position[2] - 15, 0.0) + 1e-6


def test_outside_the_fence_it_comes_back():
    x, _, _ = constrain((5.0, 0.0, 0.0), (1010.0, 500.0, 40.0), REST, [], BOX).velocity
    assert x < 0


def test_below_the_band_only_the_way_up_and_down_is_free():
    low = (500.0, 500.0, 5.0)
    assert constrain((0, 0, -1.0), low, REST, [], BOX).velocity[2] > 0
    assert constrain((0, 0, -1.0), low, REST, [], BOX, keep_band=False).velocity[2] == -1.0


@given(
    velocities,
    st.lists(st.tuples(st.floats(10.1, 80), st.floats(0, 6.28), st.floats(-1, 1)), max_size=8),
)
def test_each_keeps_its_share_towards_every_other(wanted, around):
    traffic = []
    for i, (distance, angle, lift) in enumerate(around):
        flat = sqrt(1 - lift * lift)
        traffic.append(
            Traffic(
                i,
                (
                    500 + distance * flat * np.cos(angle),
                    500 + distance * flat * np.sin(angle),
                    60 + distance * lift,
                ),
                (0.0, 0.0, 0.0),
            )
        )
    v = constrain(wanted, (500.0, 500.0, 60.0), REST, traffic, BOX).velocity
    for other in traffic:
        gap = np.array(other.position) - (500.0, 500.0, 60.0)
        d = float(np.linalg.norm(gap))
        assert float(np.dot(v, gap / d)) <= BOX.braking.share_speed(d - 10.0, 0.0) + 1e-6


def test_two_too_close_move_apart():
    v = constrain((0.0, 0.0, 0.0), INSIDE, REST, others((504.0, 500.0, 40.0)), BOX).velocity
    assert v[0] < -0.5


def test_at_the_same_point_there_is_a_way_out():
    v = constrain((0.0, 0.0, 0.0), INSIDE, REST, others(INSIDE), BOX).velocity
    assert hypot(*v) > 0.1


def test_head_on_each_passes_on_its_right():
    v = constrain((8.0, 0.0, 0.0), INSIDE, REST, others((520.0, 500.0, 40.0)), BOX).velocity
    assert v[1] < -0.1


def test_filter_off_lets_them_meet():
    off = Envelope(0, 0, 1000, 1000, 15, 120, separation_m=0)
    v = constrain((8.0, 0.0, 0.0), INSIDE, REST, others((505.0, 500.0, 40.0)), off).velocity
    assert v == (8.0, 0.0, 0.0)


@given(st.floats(0, 500), st.floats(0, 12))
def test_braking_speed_stops_in_the_room_that_the_latency_leaves(room, closing):
    braking = Braking()
    v = braking.approach_speed(room, closing)
    left = room - closing * braking.latency_s
    assert v * v / (2 * braking.brake_m_s2) == pytest.approx(left) if left > 0 else v <= 0


def fly(envelope, wanted, position, *, steps=1200, dt=0.1, lag_s=1.2, delay_steps=3, push_m_s2=3.0):
    """Vehicles with a lagging velocity loop; beacons are two control steps old. Closest pair."""
    n = len(position)
    position = position.copy()
    velocity = np.zeros((n, 3))
    past = [(position.copy(), velocity.copy())] * (delay_steps + 1)
    closest = inf
    for _ in range(steps):
        heard, moved = past[-delay_steps - 1]
        age = delay_steps * dt
        commanded = np.empty((n, 3))
        for i in range(n):
            traffic = [
                Traffic(j, tuple(heard[j] + moved[j] * age), tuple(moved[j]))
                for j in range(n)
                if j != i
            ]
            commanded[i] = constrain(
                tuple(wanted(i, position[i])),
                tuple(position[i]),
                tuple(velocity[i]),
                traffic,
                envelope,
            ).velocity
        push = np.clip((commanded - velocity) / lag_s, -push_m_s2, push_m_s2)
        velocity = velocity + push * dt
        position = position + velocity * dt
        past.append((position.copy(), velocity.copy()))
        gap = np.linalg.norm(position[:, None] - position[None], axis=-1)
        closest = min(closest, float(gap[~np.eye(n, dtype=bool)].min()))
    return closest, position


def to_one_point(i, here):
    gap = np.array([500.0, 500.0, 40.0]) - here
    return gap / max(np.linalg.norm(gap), 1e-9) * min(10.0, np.linalg.norm(gap))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_everybody_to_one_point_stays_apart(seed):
    rng = np.random.default_rng(seed)
    corner = rng.permutation(100)[:10]
    start = np.stack([corner // 10 * 100 + 50.0, corner % 10 * 100 + 50.0, np.full(10, 40.0)], 1)
    closest, _ = fly(BOX, to_one_point, start, steps=900)
    assert closest > 7.0
    off = Envelope(0, 0, 1000, 1000, 15, 120, separation_m=0)
    touched, _ = fly(off, to_one_point, start, steps=900)
    assert touched < 2.0


def test_a_circle_that_swaps_places_gets_through():
    angle = np.arange(8) * 2 * np.pi / 8
    start = np.stack([500 + 150 * np.cos(angle), 500 + 150 * np.sin(angle), np.full(8, 40.0)], 1)
    goal = np.stack([500 - 150 * np.cos(angle), 500 - 150 * np.sin(angle), np.full(8, 40.0)], 1)

    def across(i, here):
        gap = goal[i] - here
        return gap / max(np.linalg.norm(gap), 1e-9) * min(8.0, 0.7 * np.linalg.norm(gap))

    closest, end = fly(BOX, across, start, steps=1500)
    assert closest > 7.0
    assert np.linalg.norm(end - goal, axis=1).max() < 15.0
