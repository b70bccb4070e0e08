"""ArduCopter's modes, Guided, missions and nets."""

from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sim_vehicles.ardupilot.crafts import (
    COPTER,
    COPTER_MODES,
    PLANE,
    PLANE_MODES,
    ROVER,
    ROVER_MODES,
)
from sim_vehicles.modes import Mode

FAILED, DENIED, UNSUPPORTED = 4, 2, 3
STABILIZE, AUTO, GUIDED, LOITER, RTL, LAND, BRAKE = 0, 3, 4, 5, 6, 9, 17
HOME = round(47.397742e7), round(8.545594e7)


@pytest.fixture
def gcs(station):
    made = station(autopilot="ardupilot")
    made.get_ready()
    return made


def up(gcs, height_m=10.0):
    assert gcs.mode_to(GUIDED) == gcs.arm() == 0
    gcs.fly(0.5)
    assert gcs.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, height_m) == 0
    gcs.fly(20, until=lambda: gcs.position[2] > height_m - 0.2)
    gcs.fly(1)


@pytest.mark.parametrize(
    ("craft", "modes"), [(COPTER, COPTER_MODES), (ROVER, ROVER_MODES), (PLANE, PLANE_MODES)]
)
def test_modes_have_numbers_both_ways(craft, modes):
    assert set(craft.modes) == set(modes)
    for mode in modes:
        assert craft.flavour.mode_of(craft.flavour.custom_mode(mode)) is mode
        assert craft.flavour.base_mode(mode, armed=True) & 128
    assert set(craft.modes) - {Mode.OFFBOARD} <= set(craft.routines)


def test_streams_begin_when_asked_for(gcs):
    gcs.fly(2)
    assert {each.get_type() for each in gcs.received} <= {
        *("HEARTBEAT", "STATUSTEXT", "HOME_POSITION", "GPS_GLOBAL_ORIGIN"),
    }
    gcs.send(
        mavlink.MAVLink_request_data_stream_message(1, 1, mavlink.MAV_DATA_STREAM_EXTRA1, 5, 1)
    )
    gcs.fly(2)
    assert len(gcs.all("ATTITUDE")) in (10, 11)
    assert not gcs.all("VFR_HUD")
    gcs.send(mavlink.MAVLink_param_request_read_message(1, 1, b"SR0_EXTRA1", -1))
    gcs.fly(0.1)
    assert gcs.newest("PARAM_VALUE").param_value == 5.0
    gcs.send(mavlink.MAVLink_param_set_message(1, 1, b"SR0_EXTRA2", 2.0, 4))
    gcs.fly(2)
    assert len(gcs.all("VFR_HUD")) in (4, 5)
    gcs.send(mavlink.MAVLink_request_data_stream_message(1, 1, mavlink.MAV_DATA_STREAM_ALL, 0, 0))
    gcs.received.clear()
    gcs.fly(2)
    assert {each.get_type() for each in gcs.received} == {"HEARTBEAT"}


def test_parameters_travel_as_plain_numbers(gcs):
    gcs.send(mavlink.MAVLink_param_request_list_message(1, 1))
    gcs.fly(30)
    values = {each.param_id: each for each in gcs.all("PARAM_VALUE")}
    assert len(values) == gcs.newest("PARAM_VALUE").param_count
    assert (values["SYSID_THISMAV"].param_value, values["SYSID_THISMAV"].param_type) == (1.0, 4)
    assert values["WPNAV_SPEED"].param_value == 1000.0
    assert not [name for name in values if name.startswith(("MPC_", "COM_", "NAV_"))]
    assert "ArduCopter V4.6.3 (simulated)" in gcs.texts
    gcs.send(mavlink.MAVLink_param_set_message(1, 1, b"RTL_ALT", 3000.4, 9))  # any type goes
    gcs.fly(0.1)
    assert gcs.newest("PARAM_VALUE").param_value == pytest.approx(
        values["RTL_ALT"].param_value + 1500
    )


def test_what_guided_refuses(gcs):
    assert gcs.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 10) == FAILED  # not armed
    assert gcs.arm() == 0  # in Stabilize
    assert gcs.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 10) == FAILED
    assert gcs.mode_to(AUTO) == FAILED
    assert gcs.texts[-1] == "Mode change to AUTO failed: init failed"
    assert gcs.mode_to(99) == FAILED
    assert gcs.command(400, 0.5) == UNSUPPORTED
    gcs.fly(12)
    assert not gcs.armed  # DISARM_DELAY
    assert gcs.mode_to(RTL) == 0
    assert gcs.arm() == FAILED
    assert gcs.texts[-1] == "Arm: Mode not armable"


def test_setpoints_on_the_ground_do_nothing(gcs):
    assert gcs.mode_to(GUIDED) == gcs.arm() == 0
    gcs.stream = lambda: gcs.setpoint(velocity=(0.0, 0.0, -2.0))
    gcs.fly(5)
    assert gcs.position[2] == 0.0


def test_a_velocity_lasts_three_seconds(gcs):
    up(gcs)
    gcs.setpoint(velocity=(4.0, 0.0, 0.0))
    gcs.fly(2.8)
    assert gcs.velocity[1] == pytest.approx(4.0, abs=0.1)
    gcs.fly(1.5)
    assert np.abs(gcs.velocity).max() < 0.1
    assert gcs.mode == "GUIDED"
    there = gcs.position[1]
    gcs.param("GUID_TIMEOUT", 1.0)
    gcs.setpoint(velocity=(4.0, 0.0, 0.0))
    gcs.fly(4)
    assert gcs.position[1] - there == pytest.approx(4.0, abs=1.5)


def test_setpoints_count_in_guided_only(gcs):
    up(gcs)
    assert gcs.mode_to(LOITER) == 0
    gcs.setpoint(position=(50.0, 0.0, -10.0))
    gcs.fly(5)
    assert np.abs(gcs.position[:2]).max() < 0.5
    assert gcs.mode_to(GUIDED) == 0
    gcs.fly(5)
    assert np.abs(gcs.position[:2]).max() < 0.5  # the early one is forgotten


def test_a_part_ignored_takes_the_vector_along(gcs):
    up(gcs)
    gcs.send(
        mavlink.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, 1, 0xDC7 | 32, 0, 0, 0, 3.0, 0.0, 0.0, 0, 0, 0, 0, 0
        )
    )
    gcs.fly(2)
    assert np.abs(gcs.velocity).max() < 0.1


def test_reposition_and_global_targets(gcs):
    up(gcs)
    there = {"x": HOME[0] + 2000, "y": HOME[1], "z": 12.0}
    assert gcs.command_int(192, -1, 1, frame=6, **there) == 0
    gcs.fly(15)
    assert gcs.position == pytest.approx([0.0, 22.2, 12.0], abs=0.5)
    gcs.send(
        mavlink.MAVLink_set_position_target_global_int_message(
            0, 1, 1, 6, 0xDF8, *HOME, 15.0, 0, 0, 0, 0, 0, 0, 0, 0
        )
    )
    gcs.fly(15)
    assert gcs.position == pytest.approx([0.0, 0.0, 15.0], abs=0.5)
    assert gcs.mode_to(LOITER) == 0
    assert gcs.command_int(192, -1, 0, frame=6, **there) == DENIED  # may not change the mode
    assert gcs.mode == "LOITER"


def test_brake_and_land(gcs):
    up(gcs)
    gcs.setpoint(velocity=(6.0, 0.0, 0.0))
    gcs.fly(2)
    assert gcs.mode_to(BRAKE) == 0
    gcs.fly(4)
    assert np.abs(gcs.velocity).max() < 0.1
    assert gcs.command(mavlink.MAV_CMD_NAV_LAND) == 0
    assert gcs.mode == "LAND"
    assert gcs.disarm() == FAILED  # in the air
    gcs.fly(60, until=lambda: not gcs.armed)
    assert gcs.texts[-1] == "Disarming motors"


def items(*rows):
    """Items as ArduPilot has them: the first one is home."""
    home = (16, 0, (0, 0, 0, 0), (*HOME, 489.0))
    return [
        mavlink.MAVLink_mission_item_int_message(
            1, 1, seq, frame, command, 0, 1, *map(float, params), *place
        )
        for seq, (command, frame, params, place) in enumerate((home, *rows))
    ]


def upload(gcs, messages, kind=0):
    gcs.received.clear()
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, len(messages), kind))
    for each in messages:
        gcs.fly(0.1)
        assert gcs.newest("MISSION_REQUEST").seq == each.seq
        each.mission_type = kind
        gcs.send(each)
    gcs.fly(0.1)
    return gcs.newest("MISSION_ACK").type


def test_missions_with_home_first(gcs):
    north = (HOME[0] + 3000, HOME[1], 12.0)
    rows = items(
        (22, 6, (0, 0, 0, 0), (0, 0, 10.0)),
        (178, 6, (1, 8, -1, 0), (0, 0, 0.0)),
        (16, 6, (2, 0, 0, 0), north),
        (177, 6, (3, 1, 0, 0), (0, 0, 0.0)),
        (20, 6, (0, 0, 0, 0), (0, 0, 0.0)),
    )
    assert upload(gcs, rows) == 0
    gcs.send(mavlink.MAVLink_mission_request_list_message(1, 1, 0))
    gcs.fly(0.1)
    assert gcs.newest("MISSION_COUNT").count == 6
    gcs.send(mavlink.MAVLink_mission_request_int_message(1, 1, 0, 0))
    gcs.fly(0.1)
    first = gcs.newest("MISSION_ITEM_INT")
    assert (first.command, first.x, first.y) == (16, *HOME)
    assert first.z == pytest.approx(489.4, abs=0.1)

    assert gcs.mode_to(GUIDED) == gcs.arm() == gcs.mode_to(AUTO) == 0
    gcs.fly(3)
    assert gcs.position[2] == 0.0  # it waits for the throttle, or for the word
    assert gcs.command(mavlink.MAV_CMD_MISSION_START) == 0
    gcs.fly(90, until=lambda: not gcs.armed)
    assert [each.seq for each in gcs.all("MISSION_ITEM_REACHED")] == [1, 2, 3, 3, 5]
    assert [text for text in gcs.texts if text.startswith("Mission: ")] == [
        *("Mission: 1 Takeoff", "Mission: 2 ChangeSpeed", "Mission: 3 WP"),
        *("Mission: 3 WP", "Mission: 5 RTL"),
    ]
    assert np.abs(gcs.position).max() < 0.5
    assert gcs.mode == "AUTO"


@pytest.mark.parametrize(
    ("row", "result"),
    [
        ((42000, 6, (0, 0, 0, 0), (*HOME, 10.0)), 3),
        ((16, 2, (0, 0, 0, 0), (*HOME, 10.0)), 2),  # a place without a frame
        ((16, 6, (np.nan, 0, 0, 0), (*HOME, 10.0)), 6),
        ((16, 6, (0, 0, 0, np.nan), (*HOME, 10.0)), 0),  # yaw may be NaN
        ((112, 6, (3, 0, 0, 0), (0, 0, 0.0)), 0),
    ],
)
def test_items_that_are_taken_or_not(gcs, row, result):
    messages = items((22, 6, (0, 0, 0, 0), (0, 0, 10.0)), row)
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, 3, 0))
    for each in messages:
        gcs.fly(0.1)
        gcs.send(each)
    gcs.fly(0.1)
    assert gcs.newest("MISSION_ACK").type == result


def test_missions_without_takeoff_do_not_start_on_the_ground(gcs):
    assert upload(gcs, items((16, 6, (0, 0, 0, 0), (*HOME, 12.0)))) == 0
    assert gcs.mode_to(GUIDED) == gcs.arm() == 0
    assert gcs.mode_to(AUTO) == FAILED
    assert "Auto: Missing Takeoff Cmd" in gcs.texts


def test_the_ground_station_is_missed(gcs):
    heartbeat = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
    up(gcs, 5.0)
    gcs.send(heartbeat)
    gcs.fly(8)
    assert gcs.mode == "GUIDED"  # FS_GCS_ENABLE is 0
    gcs.send(heartbeat)
    gcs.param("FS_GCS_ENABLE", 1)
    gcs.fly(6, until=lambda: gcs.mode == "RTL")
    assert "GCS Failsafe" in gcs.texts


def test_fences_by_parameters(gcs):
    gcs.param("FENCE_ENABLE", 1)
    gcs.param("FENCE_RADIUS", 30)
    up(gcs)
    gcs.setpoint(position=(60.0, 0.0, -10.0))
    gcs.fly(20, until=lambda: gcs.mode == "RTL")
    assert gcs.position[1] == pytest.approx(30.0, abs=3.0)
    assert "Fence Breached" in gcs.texts


def test_uploaded_fences_count_when_enabled(gcs):
    corners = [(-3000, -3000), (3000, -3000), (3000, 3000), (-3000, 3000)]
    rows = [
        mavlink.MAVLink_mission_item_int_message(
            1, 1, seq, 0, 5001, 0, 1, 4.0, 0, 0, 0, HOME[0] + x, HOME[1] + y, 0.0
        )
        for seq, (x, y) in enumerate(corners)
    ]
    assert upload(gcs, rows, kind=1) == 0
    gcs.send(mavlink.MAVLink_param_request_read_message(1, 1, b"FENCE_TOTAL", -1))
    gcs.fly(0.1)
    assert gcs.newest("PARAM_VALUE").param_value == 4
    up(gcs)
    gcs.setpoint(position=(60.0, 0.0, -10.0))
    gcs.fly(12)
    assert gcs.mode == "GUIDED"
    assert gcs.position[1] > 50.0
    assert gcs.command(mavlink.MAV_CMD_DO_FENCE_ENABLE, 1) == 0
    gcs.fly(2, until=lambda: gcs.mode == "RTL")


def test_a_rally_point_is_nearer(gcs):
    point = mavlink.MAVLink_mission_item_int_message(
        1, 1, 0, 3, 5100, 0, 1, 0, 0, 0, 0, HOME[0] + 4000, HOME[1], 20.0
    )
    assert upload(gcs, [point], kind=2) == 0
    up(gcs)
    gcs.setpoint(position=(60.0, 0.0, -10.0))
    gcs.fly(12)
    assert gcs.mode_to(RTL) == 0
    gcs.fly(60, until=lambda: not gcs.armed)
    assert gcs.position == pytest.approx([0.0, 44.5, 0.0], abs=0.5)


def test_a_lost_gps_ends_in_a_landing(gcs):
    up(gcs)
    gcs.param("SIM_GPS_DISABLE", 1)
    gcs.fly(2, until=lambda: gcs.mode == "LAND")
    assert "EKF variance" in gcs.texts
    assert gcs.mode_to(LOITER) == FAILED
    assert gcs.texts[-1] == "Mode change to LOITER failed: requires position"
    gcs.param("SIM_GPS_DISABLE", 0)
    gcs.fly(0.2)
    assert gcs.mode_to(LOITER) == 0
