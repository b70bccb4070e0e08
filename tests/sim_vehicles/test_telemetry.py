"""What is sent when, and that it says what the vehicles do."""

from collections import Counter
from math import pi

import numpy as np
import pytest

from sim_vehicles.codec import Counts, Packet, decode, mav
from sim_vehicles.dynamics.model import Setpoints, States
from sim_vehicles.geodesy import Geodetic, to_enu
from sim_vehicles.streams import FILLS, SENSORS
from sim_vehicles.telemetry import DEFAULT_INTERVALS_US, Telemetry, TelemetrySnapshot

ORIGIN = Geodetic(47.397742, 8.545594, 488.0)
ATTITUDE = mav.MAVLINK_MSG_ID_ATTITUDE
QUATERNION = mav.MAVLINK_MSG_ID_ATTITUDE_QUATERNION
SECOND = 1_000_000


def snapshot_of(n: int, seed: int = 3) -> TelemetrySnapshot:
    rng = np.random.default_rng(seed)
    states = States.at(rng.normal(size=(n, 3)) * 200, rng.uniform(-pi, pi, n))
    states.velocity[:] = rng.normal(size=(n, 3)) * 5
    states.roll[:] = rng.normal(size=n) * 0.2
    states.pitch[:] = rng.normal(size=n) * 0.2
    states.rates[:] = rng.normal(size=(n, 3))
    states.voltage[:] = 15.2
    states.current[:] = 12.34
    states.battery[:] = 0.8

    def whole(value: int) -> np.ndarray:
        return np.full(n, value, dtype=np.int64)

    return TelemetrySnapshot(
        states=states,
        setpoints=Setpoints.idle(n),
        armed=np.arange(n) % 2 == 0,
        base_mode=whole(1),
        custom_mode=whole(6 << 16),
        system_status=whole(4),
        landed_state=whole(2),
        sensors_present=whole(SENSORS),
        sensors_health=whole(SENSORS),
        autopilot=whole(12),
        vehicle_type=whole(2),
        mission_item=whole(1),
        mission_count=whole(4),
    )


def fly(telemetry: Telemetry, snapshot: TelemetrySnapshot, steps) -> dict[int, list[Packet]]:
    """All packets of each vehicle, built at the given times; every byte must decode."""
    heard: dict[int, list[Packet]] = {}
    counts = Counts()
    for t_us in steps:
        datagrams = telemetry.build(t_us, snapshot)
        indices = [index for index, _ in datagrams]
        assert indices == sorted(set(indices))
        for index, datagram in datagrams:
            assert len(datagram) <= 1400
            heard.setdefault(index, []).extend(decode(datagram, counts))
    assert counts.garbage == 0
    return heard


def names(packets: list[Packet]) -> Counter[str]:
    return Counter(packet.message.msgname for packet in packets)


@pytest.mark.parametrize("n", [1, 2, 30])
def test_default_streams_come_unasked_at_their_rates(n):
    telemetry = Telemetry(range(1, n + 1), ORIGIN, np.zeros((n, 3)))
    heard = fly(telemetry, snapshot_of(n), range(0, 10 * SECOND, 20_000))
    assert sorted(heard) == list(range(n))
    expected = {name: 10 * SECOND // us for name, us in DEFAULT_INTERVALS_US.items()}
    for index, packets in heard.items():
        assert names(packets) == expected
        assert {packet.system for packet in packets} == {index + 1}
        numbers = [packet.sequence for packet in packets]
        assert numbers == [i % 256 for i in range(len(numbers))]


def test_rates_asked_for_are_kept_for_that_vehicle_alone():
    telemetry = Telemetry([1, 2, 3], ORIGIN, np.zeros((3, 3)))
    assert telemetry.set_interval(1, ATTITUDE, 40_000)
    assert telemetry.set_interval(1, QUATERNION, 200_000)
    assert telemetry.set_interval(2, ATTITUDE, -1)
    assert telemetry.interval(1, ATTITUDE) == 40_000
    assert telemetry.interval(2, ATTITUDE) == -1
    assert telemetry.interval(0, QUATERNION) == -1
    heard = fly(telemetry, snapshot_of(3), range(0, 4 * SECOND, 20_000))
    assert [names(heard[i])["ATTITUDE"] for i in range(3)] == [40, 100, 0]
    assert [names(heard[i])["ATTITUDE_QUATERNION"] for i in range(3)] == [0, 20, 0]
    assert [names(heard[i])["LOCAL_POSITION_NED"] for i in range(3)] == [40, 40, 40]
    for packets in heard.values():
        assert [p.sequence for p in packets] == [i % 256 for i in range(len(packets))]


def test_the_default_rate_can_be_asked_back():
    telemetry = Telemetry([1], ORIGIN, np.zeros((1, 3)))
    telemetry.set_interval(0, ATTITUDE, -1)
    telemetry.set_interval(0, ATTITUDE, 0)
    telemetry.set_interval(0, QUATERNION, 50_000)
    telemetry.set_interval(0, QUATERNION, 0)
    heard = fly(telemetry, snapshot_of(1), range(0, SECOND, 20_000))
    assert names(heard[0])["ATTITUDE"] == 10
    assert names(heard[0])["ATTITUDE_QUATERNION"] == 0


def test_messages_that_are_not_streamed_are_refused():
    telemetry = Telemetry([1], ORIGIN, np.zeros((1, 3)))
    assert not telemetry.set_interval(0, mav.MAVLINK_MSG_ID_COMMAND_LONG, 1000)
    assert telemetry.interval(0, mav.MAVLINK_MSG_ID_COMMAND_LONG) == 0
    assert telemetry.one(0, "COMMAND_LONG", 0, snapshot_of(1)) is None


def test_large_steps_send_each_stream_once():
    telemetry = Telemetry([1], ORIGIN, np.zeros((1, 3)))
    heard = fly(telemetry, snapshot_of(1), range(0, 60 * SECOND, 5 * SECOND))
    assert set(names(heard[0]).values()) == {12}


@pytest.mark.parametrize("name", sorted(FILLS))
def test_one_message_is_the_one_that_streams(name):
    n, index = 4, 2
    snapshot = snapshot_of(n)
    one = Telemetry([7, 8, 9, 10], ORIGIN, np.ones((n, 3)))
    all_of_it = Telemetry([7, 8, 9, 10], ORIGIN, np.ones((n, 3)))
    for msgid in [getattr(mav, f"MAVLINK_MSG_ID_{other}") for other in FILLS]:
        for vehicle in range(n):
            all_of_it.set_interval(vehicle, msgid, -1)
    for vehicle in range(n):
        all_of_it.set_interval(vehicle, getattr(mav, f"MAVLINK_MSG_ID_{name}"), 1000)
    assert dict(all_of_it.build(SECOND, snapshot))[index] == one.one(index, name, SECOND, snapshot)


def test_replies_and_streams_count_together():
    telemetry = Telemetry([5], ORIGIN, np.zeros((1, 3)))
    encoder = telemetry.encoders[0]
    encoder.sequence = 254
    reply = encoder.pack("COMMAND_ACK", command=400)
    (stream,) = telemetry.build(0, snapshot_of(1))
    after = encoder.pack("COMMAND_ACK", command=400)
    packets = decode(reply + stream[1] + after, Counts())
    frames = 2 + len(DEFAULT_INTERVALS_US)
    assert [packet.sequence for packet in packets] == [i % 256 for i in range(254, 254 + frames)]


def messages(snapshot: TelemetrySnapshot, starts, index: int, t_us: int = 5_250_000):
    telemetry = Telemetry(range(1, len(starts) + 1), ORIGIN, np.array(starts, dtype=float))
    found = {}
    for name in FILLS:
        data = telemetry.one(index, name, t_us, snapshot)
        assert data is not None
        found[name] = decode(data, Counts())[0].message
    return found


def test_the_wire_says_where_the_vehicle_is():
    starts = [[0.0, 0.0, 0.0], [30.0, -20.0, 4.0]]
    snapshot = snapshot_of(2)
    position, velocity = snapshot.states.position[1], snapshot.states.velocity[1]
    said = messages(snapshot, starts, 1)

    local = said["LOCAL_POSITION_NED"]
    np.testing.assert_allclose(
        [local.y, local.x, -local.z], position - starts[1], rtol=0, atol=1e-4
    )
    np.testing.assert_allclose([local.vy, local.vx, -local.vz], velocity, atol=1e-5)
    assert local.time_boot_ms == 5250

    whole = said["GLOBAL_POSITION_INT"]
    enu = to_enu(whole.lat / 1e7, whole.lon / 1e7, whole.alt / 1e3, ORIGIN)
    np.testing.assert_allclose(enu, position, atol=0.012)
    assert whole.relative_alt == pytest.approx((position[2] - 4.0) * 1e3, abs=1)
    np.testing.assert_allclose([whole.vy, whole.vx, -whole.vz], velocity * 100, atol=0.51)
    assert 0 <= whole.hdg < 36000

    home = said["HOME_POSITION"]
    enu = to_enu(home.latitude / 1e7, home.longitude / 1e7, home.altitude / 1e3, ORIGIN)
    np.testing.assert_allclose(enu, starts[1], atol=0.012)
    assert (home.x, home.y, home.z) == (0.0, 0.0, 0.0)
    gps = said["GPS_RAW_INT"]
    assert (gps.lat, gps.lon, gps.alt) == (whole.lat, whole.lon, whole.alt)
    assert gps.fix_type >= 3
    assert gps.vel == pytest.approx(np.hypot(*velocity[:2]) * 100, abs=0.51)
    assert said["VFR_HUD"].climb == pytest.approx(velocity[2], abs=1e-5)
    assert said["ALTITUDE"].altitude_relative == pytest.approx(position[2] - 4.0, abs=1e-4)


def test_the_wire_says_how_it_is_turned():
    snapshot = snapshot_of(1)
    states = snapshot.states
    states.yaw[:] = pi / 4  # north-east
    states.rates[:] = (0.1, 0.2, 0.3)
    said = messages(snapshot, [[0.0, 0.0, 0.0]], 0)
    attitude, turned = said["ATTITUDE"], said["ATTITUDE_QUATERNION"]
    assert attitude.yaw == pytest.approx(pi / 4)
    assert (attitude.roll, attitude.pitch) == pytest.approx((states.roll[0], states.pitch[0]))
    assert (attitude.rollspeed, attitude.pitchspeed, attitude.yawspeed) == pytest.approx(
        (0.1, 0.2, -0.3)
    )
    w, x, y, z = turned.q1, turned.q2, turned.q3, turned.q4
    assert np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)) == pytest.approx(attitude.roll)
    assert np.arcsin(2 * (w * y - z * x)) == pytest.approx(attitude.pitch, abs=1e-6)
    assert np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) == pytest.approx(attitude.yaw)
    assert said["GLOBAL_POSITION_INT"].hdg == 4500
    assert said["VFR_HUD"].heading == 45


def test_the_wire_says_how_the_vehicle_is():
    said = messages(snapshot_of(2), np.zeros((2, 3)), 0)
    beat = said["HEARTBEAT"]
    assert (beat.type, beat.autopilot, beat.base_mode, beat.custom_mode) == (2, 12, 129, 6 << 16)
    assert messages(snapshot_of(2), np.zeros((2, 3)), 1)["HEARTBEAT"].base_mode == 1
    status, battery = said["SYS_STATUS"], said["BATTERY_STATUS"]
    assert status.onboard_control_sensors_health == SENSORS
    assert (status.voltage_battery, status.current_battery) == (15200, 1234)
    assert status.battery_remaining == battery.battery_remaining == 80
    assert battery.voltages[0] == 15200
    assert set(battery.voltages[1:]) == {0xFFFF}
    assert said["EXTENDED_SYS_STATE"].landed_state == 2
    assert (said["MISSION_CURRENT"].seq, said["MISSION_CURRENT"].total) == (1, 4)
    assert said["SYSTEM_TIME"].time_boot_ms == 5250


def test_the_wire_says_what_is_asked_for():
    snapshot = snapshot_of(1)
    snapshot.setpoints.position[0] = (1.0, 2.0, 3.0)
    snapshot.setpoints.yaw[0] = pi / 2
    target = messages(snapshot, [[1.0, 0.0, 0.0]], 0)["POSITION_TARGET_LOCAL_NED"]
    assert (target.x, target.y, target.z, target.yaw) == (2.0, 0.0, -3.0, 0.0)
    assert np.isnan(target.vx)
    assert target.type_mask == 8 + 16 + 32 + 64 + 128 + 256 + 2048


def test_home_may_move():
    telemetry = Telemetry([1], ORIGIN, np.zeros((1, 3)))
    telemetry.homes[0] = (10.0, 20.0, 5.0)
    snapshot = snapshot_of(1)
    snapshot.states.position[0] = (0.0, 0.0, 25.0)
    data = telemetry.one(0, "HOME_POSITION", 0, snapshot)
    home = decode(data, Counts())[0].message
    assert (home.x, home.y, home.z) == (20.0, 10.0, -5.0)
    data = telemetry.one(0, "GLOBAL_POSITION_INT", 0, snapshot)
    assert decode(data, Counts())[0].message.relative_alt == 20_000
