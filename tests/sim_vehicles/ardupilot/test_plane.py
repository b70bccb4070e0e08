"""ArduPlane: the recorded flight, missions, and what it does not do."""

from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

FAILED = 4
AUTO, RTL, LOITER, TAKEOFF, GUIDED = 10, 11, 12, 13, 15
HOME = round(47.397742e7), round(8.545594e7)


@pytest.fixture
def gcs(station):
    made = station(kind="plane", autopilot="ardupilot")
    made.get_ready()
    return made


def at(gcs, time_s):
    gcs.fly(time_s - gcs.fleet.now_us / 1e6)


def away(gcs, east, north):
    return float(np.hypot(gcs.position[0] - east, gcs.position[1] - north))


def north(metres):
    """Of home, as the wire has latitudes."""
    return HOME[0] + round(metres / 0.0111186)


def test_the_recorded_flight(station):
    """Times and answers as recorded; places with the tolerance of another airframe."""
    gcs = station(kind="plane", autopilot="ardupilot")
    at(gcs, 4.3)
    assert gcs.arm() == FAILED
    at(gcs, 20.5)
    assert gcs.mode_to(TAKEOFF) == 0
    at(gcs, 23.54)
    assert gcs.arm() == 0
    assert "Throttle armed" in gcs.texts
    at(gcs, 27.0)
    heartbeat = gcs.newest("HEARTBEAT")
    assert (heartbeat.type, heartbeat.base_mode, heartbeat.custom_mode) == (1, 217, 13)
    assert "Takeoff to 50m for 200.0m heading 0.0 deg" in gcs.texts
    at(gcs, 35.2)
    assert gcs.position[2] == pytest.approx(50.0, abs=7.0)
    assert gcs.mode_to(GUIDED) == 0
    there = {"x": north(510.0), "y": HOME[1] - 10200, "z": 50.0}
    assert gcs.command_int(192, -1, 1, frame=6, **there) == 0
    at(gcs, 75.0)
    assert away(gcs, -77.0, 510.0) == pytest.approx(90.0, abs=12.0)
    assert gcs.position[2] == pytest.approx(50.0, abs=2.0)
    assert np.hypot(*gcs.velocity[:2]) == pytest.approx(22.5, abs=1.5)
    assert [each.seq for each in gcs.all("MISSION_ITEM_REACHED")] == [0]
    at(gcs, 113.9)
    assert gcs.mode_to(RTL) == 0
    at(gcs, 170.0)
    assert away(gcs, 0.0, 0.0) == pytest.approx(90.0, abs=12.0)
    assert gcs.position[2] == pytest.approx(100.0, abs=1.5)
    assert gcs.disarm() == FAILED  # in the air


def test_what_it_does_not_do(gcs):
    assert gcs.mode_to(TAKEOFF) == gcs.arm() == 0
    assert gcs.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 50) == FAILED
    gcs.fly(20)
    assert gcs.mode_to(GUIDED) == 0
    gcs.fly(5)
    here = gcs.position.copy()
    gcs.setpoint(position=(2000.0, 0.0, -50.0))  # local setpoints are passed over
    gcs.fly(20)
    assert away(gcs, *here[:2]) < 250.0
    assert gcs.mode_to(3) == FAILED  # Circle and others are not simulated
    assert gcs.mode_to(AUTO) == FAILED  # without a mission


def test_guided_by_an_item(gcs):
    """As old ground stations do: a mission item whose "current" is 2."""
    assert gcs.mode_to(TAKEOFF) == gcs.arm() == 0
    gcs.fly(25)
    assert gcs.mode_to(GUIDED) == 0
    gcs.send(
        mavlink.MAVLink_mission_item_int_message(
            1, 1, 0, 6, 16, 2, 0, 0, 0, 0, 0, north(400.0), HOME[1], 60.0
        )
    )
    gcs.fly(40)
    assert gcs.newest("MISSION_ACK").type == 0
    assert away(gcs, 0.0, 400.0) == pytest.approx(80.0, abs=10.0)
    assert gcs.position[2] == pytest.approx(60.0, abs=2.0)


def upload(gcs, *rows):
    """Items as (command, frame, latitude, height)."""
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, len(rows), 0))
    for seq, (command, frame, x, z) in enumerate(rows):
        gcs.fly(0.1)
        gcs.send(
            mavlink.MAVLink_mission_item_int_message(
                1, 1, seq, frame, command, 0, 1, 0, 0, 0, 0, x, HOME[1], z
            )
        )
    gcs.fly(0.1)
    assert gcs.newest("MISSION_ACK").type == 0


def test_a_mission_ends_in_return(gcs):
    upload(gcs, (16, 0, HOME[0], 0.0), (22, 6, north(200.0), 40.0), (16, 6, north(500.0), 60.0))
    assert gcs.mode_to(AUTO) == gcs.arm() == 0
    gcs.fly(90, until=lambda: gcs.mode == "RTL")
    assert [each.seq for each in gcs.all("MISSION_ITEM_REACHED")] == [1, 2]
    assert "Mission complete, changing mode to RTL" in gcs.texts
    gcs.fly(60)
    assert away(gcs, 0.0, 0.0) == pytest.approx(80.0, abs=10.0)


def test_guided_takes_another_speed_height_and_heading(station):
    gcs = station(kind="plane", autopilot="ardupilot", in_air_m=100.0)
    gcs.get_ready()
    assert gcs.command_int(43001, frame=3, x=0, y=0, z=140.0) == 4  # not in Guided
    assert gcs.mode_to(15) == 0
    assert gcs.command(43000, 0, 27) == 0
    assert gcs.command(43002, 0, 90, 5) == 0
    assert gcs.command_int(43001, frame=3, x=0, y=0, z=140.0) == 0
    gcs.fly(25)
    assert gcs.velocity == pytest.approx([27.0, 0.0, 0.0], abs=0.7)
    assert gcs.position[2] == pytest.approx(140.0, abs=1.0)
    assert gcs.command(43002, 0, 400) == 2
    assert gcs.command(43000, 1, 27) == 2  # over ground


def test_a_setpoint_of_a_height_alone(station):
    gcs = station(kind="plane", autopilot="ardupilot", in_air_m=100.0)
    gcs.get_ready()
    assert gcs.mode_to(15) == 0
    gcs.fly(1)
    gcs.send(
        mavlink.MAVLink_set_position_target_global_int_message(
            0, 1, 1, 6, 0xDFB, 0, 0, 70.0, 0, 0, 0, 0, 0, 0, 0, 0
        )
    )
    gcs.fly(25)
    assert gcs.position[2] == pytest.approx(70.0, abs=1.0)


LANDING = ((16, 0, HOME[0], 0.0), (189, 3, 0, 0.0), (31, 3, north(-400.0), 35.0),
           (21, 3, HOME[0], 0.0))  # fmt: skip


def test_a_landing_sequence_is_flown_after_the_return(gcs):
    assert gcs.command(189) == FAILED
    assert "Unable to start landing sequence" in gcs.texts
    upload(gcs, *LANDING)
    assert gcs.mode_to(TAKEOFF) == 0
    assert gcs.arm() == FAILED
    assert "DO_LAND_START set and RTL_AUTOLAND disabled" in " ".join(gcs.texts)
    gcs.param("RTL_AUTOLAND", 1)
    assert gcs.arm() == 0
    gcs.fly(10)
    assert gcs.mode_to(GUIDED) == gcs.command(189) == 0
    gcs.fly(0.5)
    assert gcs.mode == "AUTO"
    assert gcs.mode_to(RTL) == 0
    gcs.fly(200, until=lambda: not gcs.armed)
    assert not gcs.armed
    assert away(gcs, 0.0, 0.0) < 120.0
    assert gcs.texts.count("Landing sequence start") == 2
