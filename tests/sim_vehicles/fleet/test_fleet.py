from __future__ import annotations

import hashlib
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from sim_vehicles.command_line import _MODELS
from sim_vehicles.crafts import CRAFTS, MODEL_NAMES
from sim_vehicles.dynamics import WindSpec
from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic

ORIGIN = Geodetic(47.397742, 8.545594, 489.4)
GCS = mavlink.MAVLink(None, 255, 190)


def fleet_of(count, *, first=1, **options):
    specs = [VehicleSpec(first + i, (10.0 * i, 5.0 * i, 0.0)) for i in range(count)]
    return Fleet(specs, origin=ORIGIN, **options)


def script(system, t_us):
    """What a vehicle is told at a time."""

    def command(number, *params):
        seven = [*params, *[0.0] * (7 - len(params))]
        return mavlink.MAVLink_command_long_message(system, 1, number, 0, *map(float, seven))

    def setpoint(vx, vy, vz):
        return mavlink.MAVLink_set_position_target_local_ned_message(
            0, system, 1, 1, 0xDC7, 0, 0, 0, vx, vy, vz, 0, 0, 0, 0, 0
        )

    t = t_us // 100_000
    if t == 50:
        return [command(400, 1), command(22, *[float("nan")] * 7)]
    if t == 120:
        return [setpoint(1.0 * system, 2.0, -1.0), command(176, 1, 6)]
    if 120 < t < 160:
        return [setpoint(1.0 * system, 2.0, -1.0)]
    if t == 165:
        return [command(20)]
    return []


def play(fleet, seconds, indices=None):
    """Fly the script; every datagram out, in order."""
    sent = []
    for _ in range(round(seconds * 10)):
        for i in range(len(fleet.systems)):
            for message in script(fleet.systems[i], fleet.now_us):
                GCS.seq = 0
                fleet.receive(i, message.pack(GCS))
        fleet.advance(fleet.now_us + 100_000)
        sent.extend((fleet.now_us, *each) for each in fleet.transmit())
    return sent


def digest(sent):
    return hashlib.sha256(repr(sent).encode()).hexdigest()


def test_same_seed_same_bytes():
    wind = WindSpec(mean_m_s=(1.0, 0.0, 0.0), gust_m_s=1.0)
    runs = [digest(play(fleet_of(3, seed=seed, wind=wind), 22)) for seed in (5, 5, 6)]
    assert runs[0] == runs[1] != runs[2]


@pytest.mark.parametrize("model", ["multirotor", "perfect"])
def test_a_batch_flies_as_its_vehicles_alone(model):
    together = fleet_of(3, model=model)
    sent = play(together, 25)
    for i in range(3):
        alone = Fleet([together.specs[i]], origin=ORIGIN, model=model)
        own = play(alone, 25)
        np.testing.assert_allclose(alone.states.position[0], together.states.position[i], atol=1e-6)
        texts = [
            [m.text for m in parse(each for _, _, each in stream) if m.get_type() == "STATUSTEXT"]
            for stream in (own, [each for each in sent if each[1] == i])
        ]
        assert texts[0] == texts[1]
        assert "Failsafe activated" not in texts[0]


def parse(datagrams):
    messages = []
    for datagram in datagrams:
        messages.extend(mavlink.MAVLink(None).parse_buffer(datagram) or [])
    return messages


def test_the_size_of_the_steps_asked_for_changes_nothing():
    fine, coarse = fleet_of(2), fleet_of(2)
    for t_us in range(0, 5_000_001, 7_000):
        fine.advance(t_us)
    coarse.advance(5_000_000)
    assert fine.now_us == 4_980_000 or fine.now_us == coarse.now_us
    fine.advance(5_000_000)
    assert fine.now_us == coarse.now_us == 5_000_000
    assert [parse([each])[0].get_srcSystem() for _, each in fine.transmit()]
    assert (fine.states.position == coarse.states.position).all()


def test_time_does_not_go_back():
    fleet = fleet_of(1)
    fleet.advance(1_000_000)
    fleet.advance(500_000)
    assert fleet.now_us == 1_000_000


def test_sequence_numbers_have_no_gaps():
    fleet = fleet_of(2)
    sent = play(fleet, 20)
    for i in range(2):
        numbers = [m.get_seq() for m in parse(each for _, index, each in sent if index == i)]
        assert all((a + 1) % 256 == b for a, b in pairwise(numbers))
        assert numbers[0] == 0


def test_datagrams_are_short_and_hold_whole_frames():
    fleet = fleet_of(1)
    fleet.receive(0, mavlink.MAVLink_param_request_list_message(1, 1).pack(GCS))
    fleet.advance(20_000_000)
    sent = fleet.transmit()
    assert max(len(each) for _, each in sent) <= 1400
    total = sum(len(each) for _, each in sent)
    assert sum(len(m.get_msgbuf()) for m in parse(each for _, each in sent)) == total
    assert len(sent) <= total / 1000 + 1
    assert fleet.transmit() == []


def test_local_frame_is_each_vehicles_own():
    fleet = Fleet([VehicleSpec(7, (100.0, 50.0, 0.0))], origin=ORIGIN, model="perfect")
    fleet.advance(200_000)
    messages = parse(each for _, each in fleet.transmit())
    local = next(m for m in messages if m.get_type() == "LOCAL_POSITION_NED")
    assert (local.x, local.y, local.z) == pytest.approx((0, 0, 0), abs=1e-6)
    assert all(m.get_srcSystem() == 7 for m in messages)


def test_truth_is_a_copy():
    fleet = fleet_of(2)
    truth = fleet.truth()
    truth.position[:] = 99.0
    assert fleet.states.position.max() < 99.0
    assert truth.modes == ("Hold", "Hold")
    assert not truth.in_air.any()
    assert not truth.armed.any()


def test_bad_fleets_are_refused():
    spec = VehicleSpec(1, (0.0, 0.0, 0.0))
    for specs, options, word in (
        ([spec], {"model": "balloon"}, "balloon"),
        ([spec], {"parameters": {"NOT_THERE": 1.0}}, "NOT_THERE"),
        ([spec], {"parameters": {"MPC_XY_CRUISE": -1.0}}, "MPC_XY_CRUISE"),
        ([], {}, "needs a vehicle"),
        ([VehicleSpec(1, (0, 0, 0), kind="boat")], {}, "boat"),
        ([VehicleSpec(1, (0, 0, 5.0))], {}, "above the ground"),
        ([VehicleSpec(1, (0, 0, 0), in_air_m=-1.0)], {}, "in_air_m"),
    ):
        with pytest.raises(ValueError, match=word):
            Fleet(specs, origin=ORIGIN, **options)


def sane(fleet):
    states, asked = fleet.states, fleet.pilot.setpoints
    for name in ("position", "velocity", "roll", "pitch", "yaw", "battery", "voltage"):
        assert np.isfinite(getattr(states, name)).all(), name
    for name in ("max_speed", "max_up", "max_down"):
        assert not np.isnan(getattr(asked, name)).any(), name
    assert np.abs(states.velocity).max() < 60.0


@given(st.lists(st.binary(max_size=300), max_size=20))
@settings(max_examples=30)
def test_random_bytes_do_nothing(datagrams):
    fleet = fleet_of(1, model="perfect")
    for datagram in datagrams:
        fleet.receive(0, datagram)
        fleet.receive(0, b"\xfd" + datagram)
    fleet.advance(200_000)
    sane(fleet)
    assert fleet.counts[0].packets == 0


NAMES = (
    "HEARTBEAT",
    "PING",
    "TIMESYNC",
    "COMMAND_LONG",
    "COMMAND_INT",
    "SET_MODE",
    "REQUEST_DATA_STREAM",
    "SET_POSITION_TARGET_LOCAL_NED",
    "SET_POSITION_TARGET_GLOBAL_INT",
    "PARAM_REQUEST_READ",
    "PARAM_REQUEST_LIST",
    "PARAM_SET",
    "MISSION_COUNT",
    "MISSION_ITEM",
    "MISSION_ITEM_INT",
    "MISSION_REQUEST_LIST",
    "MISSION_REQUEST",
    "MISSION_REQUEST_INT",
    "MISSION_ACK",
    "MISSION_CLEAR_ALL",
    "MISSION_SET_CURRENT",
    "MISSION_REQUEST_PARTIAL_LIST",
    "MANUAL_CONTROL",
    "RC_CHANNELS_OVERRIDE",
    "FILE_TRANSFER_PROTOCOL",
    "SYSTEM_TIME",
    "STATUSTEXT",
    "GLOBAL_POSITION_INT",
)
COMMANDS = (17, 20, 21, 22, 176, 178, 179, 192, 193, 224, 246, 300, 400, 511, 512)
RANGES = {
    "int8_t": 8, "uint8_t": 8, "int16_t": 16, "uint16_t": 16, "int32_t": 32, "uint32_t": 32,
    "int64_t": 64, "uint64_t": 64,
}  # fmt: skip
PARAMETERS = (
    *("MPC_XY_CRUISE", "COM_LOW_BAT_ACT", "RTL_CONE_ANG", "x", "WPNAV_SPEED", "RTL_ALT"),
    *("SR0_EXTRA1", "FENCE_ENABLE", "FENCE_RADIUS", "WP_LOITER_RAD", "WP_SPEED", "FS_GCS_ENABLE"),
    *("AIRSPEED_CRUISE", "RTL_CONE_SLOPE", "RTL_LOIT_TIME", "GUID_TIMEOUT", "DISARM_DELAY"),
)
FLOATS = st.one_of(st.floats(width=32), st.sampled_from([0.0, 1.0, 4.0, 6.0, -20.0, float("nan")]))


@st.composite
def packets(draw):
    """A valid packet for vehicle 1 with any values in its fields."""
    name = draw(st.sampled_from(NAMES))
    cls = mavlink.mavlink_map[getattr(mavlink, f"MAVLINK_MSG_ID_{name}")]
    values = []
    kinds = dict(zip(cls.fieldnames, cls.fieldtypes, strict=True))
    for field, length in zip(cls.ordered_fieldnames, cls.array_lengths, strict=True):
        kind = kinds[field]
        if field in ("target_system", "target_component"):
            value = draw(st.sampled_from([0, 1]))
        elif field == "command":
            value = draw(st.sampled_from(COMMANDS))
        elif field in ("mission_type", "seq", "count", "frame", "coordinate_frame"):
            value = draw(st.integers(0, 7))
        elif field == "param_id":
            value = draw(st.sampled_from(PARAMETERS))
            value = value.encode()
        elif kind == "char":
            value = draw(st.binary(max_size=length))
        elif kind in ("float", "double"):
            value = draw(FLOATS)
        else:
            size = RANGES[kind]
            low, high = (
                (-(2 ** (size - 1)), 2 ** (size - 1) - 1) if kind[0] == "i" else (0, 2**size - 1)
            )
            value = draw(st.integers(low, high))
        if length and kind != "char":
            value = [value] * length
        values.append(value)
    fields = dict(zip(cls.ordered_fieldnames, values, strict=True))
    return cls(**fields).pack(GCS)


@given(
    st.lists(packets(), max_size=25),
    st.booleans(),
    st.sampled_from(["perfect", "multirotor"]),
    st.sampled_from(sorted(CRAFTS)),
)
@settings(max_examples=90)
def test_any_valid_packets_keep_it_sane(datagrams, flying, model, craft):
    autopilot, kind = craft
    height_m = 20.0 if flying and kind != "rover" else None
    spec = VehicleSpec(1, (0.0, 0.0, 0.0), kind=kind, in_air_m=height_m, autopilot=autopilot)
    fleet = Fleet([spec], origin=ORIGIN, model=model)
    if flying:
        fleet.pilot.arm(0, force=True)
    for datagram in datagrams:
        fleet.receive(0, datagram)
        fleet.advance(fleet.now_us + 100_000)
        parse(each for _, each in fleet.transmit())
        sane(fleet)
    assert fleet.counts[0].packets == len(datagrams)


def test_the_command_line_names_the_models_there_are():
    assert {*_MODELS, "rover"} == set(MODEL_NAMES)


def drawn(kind, model, endurance):
    """What a minute in the air, or on the road, takes of a battery."""
    spec = VehicleSpec(1, (0.0, 0.0, 0.0), kind=kind, in_air_m=None if kind == "rover" else 50.0)
    fleet = Fleet([spec], origin=ORIGIN, model=model, endurance=endurance)
    fleet.advance(60_000_000)
    return 1.0 - fleet.squads[0].states.battery[0]


@pytest.mark.parametrize(
    ("kind", "model"),
    [
        (kind, model)
        for (make, kind), craft in CRAFTS.items()
        if make == "px4"
        for model in craft.models
    ],
)
def test_endurance_is_the_batterys_capacity(kind, model):
    once = drawn(kind, model, 1.0)
    assert once > 0.0
    assert drawn(kind, model, 3.0) == pytest.approx(once / 3.0, rel=1e-6)


def test_a_multirotors_battery_lasts_twenty_minutes():
    assert 1.0 / drawn("multirotor", "multirotor", 1.0) == pytest.approx(20.0, abs=1.0)


@pytest.mark.parametrize("endurance", [0.0, -1.0, np.nan, np.inf])
def test_batteries_of_no_capacity_are_refused(endurance):
    with pytest.raises(ValueError, match="endurance must be a positive number"):
        fleet_of(1, endurance=endurance)
