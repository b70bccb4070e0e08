from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sim_vehicles.protocol.commands import COMMANDS

ACCEPTED, LATER, DENIED, UNSUPPORTED = 0, 1, 2, 3
NAN = float("nan")


@pytest.mark.parametrize(
    ("command", "params", "grounded", "flying"),
    [
        (17, (), ACCEPTED, ACCEPTED),  # NAV_LOITER_UNLIM
        (20, (), ACCEPTED, ACCEPTED),  # NAV_RETURN_TO_LAUNCH
        (21, (0, 0, 0, NAN, NAN, NAN, NAN), ACCEPTED, ACCEPTED),  # NAV_LAND
        (22, (NAN,) * 7, ACCEPTED, ACCEPTED),  # NAV_TAKEOFF
        (22, (0, 0, 0, 0, 120.0, 0, 10.0), DENIED, DENIED),  # no such latitude
        (176, (1, 4, 3), ACCEPTED, ACCEPTED),  # DO_SET_MODE Hold
        (176, (1, 4, 99), DENIED, DENIED),
        (176, (0, 4, 3), DENIED, DENIED),
        (176, (NAN, NAN, NAN), DENIED, DENIED),
        (178, (1, 5, -1), ACCEPTED, ACCEPTED),  # DO_CHANGE_SPEED
        (179, (1,), ACCEPTED, ACCEPTED),  # DO_SET_HOME here
        (179, (0, 0, 0, 0, 47.4, 8.5, 500.0), ACCEPTED, ACCEPTED),
        (179, (0, 0, 0, 0, NAN, NAN, NAN), DENIED, DENIED),
        (185, (0,), ACCEPTED, ACCEPTED),  # DO_FLIGHTTERMINATION, no
        (192, (-1, 1, 0, NAN, 47.398, 8.545, 500.0), LATER, ACCEPTED),  # DO_REPOSITION
        (192, (-1, 1, 0, NAN, NAN, NAN, 500.0), LATER, ACCEPTED),
        (192, (-1, 1, 0, NAN, 0.0, 0.0, 500.0), DENIED, DENIED),  # thousands of km away
        (193, (0,), ACCEPTED, ACCEPTED),  # DO_PAUSE_CONTINUE
        (193, (1,), LATER, LATER),  # there is no mission
        (193, (NAN,), DENIED, DENIED),
        (224, (0,), DENIED, DENIED),  # DO_SET_MISSION_CURRENT
        (224, (-1,), ACCEPTED, ACCEPTED),
        (245, (1,), ACCEPTED, ACCEPTED),  # PREFLIGHT_STORAGE
        (246, (1,), ACCEPTED, LATER),  # PREFLIGHT_REBOOT_SHUTDOWN
        (246, (3,), DENIED, DENIED),
        (300, (), LATER, LATER),  # MISSION_START
        (400, (1,), ACCEPTED, ACCEPTED),  # COMPONENT_ARM_DISARM
        (400, (0,), ACCEPTED, LATER),
        (400, (7,), DENIED, DENIED),
        (410, (), ACCEPTED, ACCEPTED),  # GET_HOME_POSITION
        (510, (30,), ACCEPTED, ACCEPTED),  # GET_MESSAGE_INTERVAL
        (510, (-1,), DENIED, DENIED),
        (511, (30, 50_000), ACCEPTED, ACCEPTED),  # SET_MESSAGE_INTERVAL
        (511, (30, NAN), ACCEPTED, ACCEPTED),
        (511, (99_999, 50_000), DENIED, DENIED),
        (512, (148,), ACCEPTED, ACCEPTED),  # REQUEST_MESSAGE
        (512, (395,), DENIED, DENIED),  # COMPONENT_INFORMATION
        (512, (397,), DENIED, DENIED),  # COMPONENT_METADATA
        (512, (NAN,), DENIED, DENIED),
        (520, (1,), ACCEPTED, ACCEPTED),  # REQUEST_AUTOPILOT_CAPABILITIES
        (519, (1,), UNSUPPORTED, UNSUPPORTED),
        (16, (), UNSUPPORTED, UNSUPPORTED),
        (31000, (), UNSUPPORTED, UNSUPPORTED),
    ],
)
def test_results(station, command, params, grounded, flying):
    gcs = station()
    gcs.get_ready()
    assert gcs.command(command, *params) == grounded
    gcs = station(in_air_m=20.0)
    gcs.fly(0.1)
    assert gcs.command(command, *params) == flying
    gcs.fly(0.5)


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_nan_everywhere_is_no_trouble(station, command):
    for gcs in (station(), station(in_air_m=20.0)):
        gcs.fly(0.2)
        for value in (NAN, float("inf"), -float("inf"), 3e38, -3e38):
            assert gcs.command(command, *[value] * 7) in range(10)
            assert gcs.command_int(command, *[value] * 4, x=2**31 - 1, y=-(2**31), z=value) >= 0
        gcs.fly(0.3)


def test_acknowledgement_goes_to_the_sender_and_strangers_are_not_served(station):
    gcs = station(count=2)
    gcs.get_ready()
    message = mavlink.MAVLink_command_long_message(1, 1, 520, 0, *[0.0] * 7)

    def acks():
        return [each for each in gcs.collect() if each.get_type() == "COMMAND_ACK"]

    for system, component, answered in (
        (1, 1, True), (0, 0, True), (1, 0, True), (0, 1, True), (2, 1, False), (1, 42, False),
    ):  # fmt: skip
        message.target_system, message.target_component = system, component
        gcs.send(message)
        assert len(acks()) == answered, (system, component)
    gcs.mav.srcSystem, gcs.mav.srcComponent = 33, 7
    message.target_system, message.target_component = 1, 1
    gcs.send(message)
    (ack,) = acks()
    assert (ack.target_system, ack.target_component) == (33, 7)
    gcs.mav.srcSystem, gcs.mav.srcComponent = 1, 1  # itself
    gcs.send(message)
    assert not acks()
    gcs.mav.srcComponent = 191  # a computer on board
    gcs.send(message)
    assert len(acks()) == 1


def test_after_a_reboot_the_position_has_to_come_again(station):
    gcs = station()
    gcs.fly(6)
    assert gcs.command(246, 1) == 0
    gcs.fly(1)
    assert gcs.arm() == 1
    gcs.fly(5)
    assert gcs.arm() == 0


def test_set_mode_message(station):
    gcs = station(in_air_m=20.0)
    gcs.send(mavlink.MAVLink_set_mode_message(1, 1, 4 << 16 | 6 << 24))
    assert gcs.acknowledged(176) == 0
    assert gcs.mode == "Land"
    gcs.send(mavlink.MAVLink_set_mode_message(1, 1, 77 << 16))
    assert gcs.acknowledged(176) == 2


def test_message_intervals(station):
    gcs = station(in_air_m=20.0)
    gcs.fly(0.2)
    assert gcs.command(511, 30, 20_000) == 0
    gcs.received.clear()
    gcs.fly(2)
    assert len(gcs.all("ATTITUDE")) == pytest.approx(100, abs=2)
    assert gcs.command(510, 30) == 0
    assert gcs.newest("MESSAGE_INTERVAL").interval_us == 20_000
    gcs.command(511, 30, -1)
    gcs.received.clear()
    gcs.fly(1)
    assert not gcs.all("ATTITUDE")
    gcs.command(511, 30, 0)
    gcs.received.clear()
    gcs.fly(2)
    assert len(gcs.all("ATTITUDE")) == pytest.approx(20, abs=1)


def test_requested_messages_come(station):
    gcs = station(in_air_m=20.0)
    for msgid, name in (
        (148, "AUTOPILOT_VERSION"), (242, "HOME_POSITION"), (49, "GPS_GLOBAL_ORIGIN"),
        (42, "MISSION_CURRENT"), (0, "HEARTBEAT"), (1, "SYS_STATUS"), (147, "BATTERY_STATUS"),
    ):  # fmt: skip
        assert gcs.command(512, msgid) == 0
        assert gcs.newest(name) is not None, name
    version = gcs.newest("AUTOPILOT_VERSION")
    assert version.capabilities & 16  # parameters travel bytewise
    assert version.flight_sw_version >> 16 == 0x0111
    origin = gcs.newest("GPS_GLOBAL_ORIGIN")
    assert origin.latitude == pytest.approx(473977420, abs=2)


def test_home_moves(station):
    gcs = station(in_air_m=20.0)
    gcs.fleet.states.position[0, :2] = 30.0, 40.0
    assert gcs.command(179, 1) == 0
    gcs.command(410)
    home = gcs.newest("HOME_POSITION")
    assert (home.x, home.y, home.z) == pytest.approx((40.0, 30.0, -20.0), abs=0.1)
    gcs.fly(0.2)
    assert gcs.newest("GLOBAL_POSITION_INT").relative_alt == pytest.approx(0, abs=100)


def test_timesync_and_ping(station):
    gcs = station()
    gcs.fleet.advance(2_500_000)
    gcs.send(mavlink.MAVLink_timesync_message(0, 123_456))
    gcs.send(mavlink.MAVLink_timesync_message(55, 66))  # somebody's answer
    gcs.send(mavlink.MAVLink_ping_message(77, 5, 0, 0))
    gcs.send(mavlink.MAVLink_ping_message(77, 5, 1, 1))
    gcs.collect()
    (answer,) = gcs.all("TIMESYNC")
    assert (answer.tc1, answer.ts1) == (2_500_000_000, 123_456)
    (ping,) = gcs.all("PING")
    assert (ping.time_usec, ping.seq, ping.target_system, ping.target_component) == (
        77,
        5,
        255,
        190,
    )


def test_data_streams_are_passed_over_as_by_px4(station):
    gcs = station()
    gcs.send(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 1, 1))
    gcs.fly(2)
    assert len(gcs.all("ATTITUDE")) == pytest.approx(20, abs=1)


def test_long_texts_come_in_chunks(station):
    gcs = station(in_air_m=20.0)
    gcs.command(20)
    text = "RTL: start return at 509 m (20 m above destination)"
    chunks = [each for each in gcs.all("STATUSTEXT") if each.id]
    assert [each.chunk_seq for each in chunks] == [0, 1]
    assert "".join(each.text for each in chunks) == text
    assert {each.id for each in gcs.all("STATUSTEXT") if each.text != text[:50]} <= {0, 1}
