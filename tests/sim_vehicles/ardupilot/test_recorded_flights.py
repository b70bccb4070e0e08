"""The ground station's side of recorded flights of ArduPilot 4.6.3, played to our vehicles.

Times, acknowledgements, heartbeats and positions are those of the recordings.
"""

from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

FAILED = 4
GUIDED_COPTER, RTL_COPTER = 4, 6
GUIDED_ROVER, RTL_ROVER = 15, 11


def at(gcs, time_s):
    """Let it be ``time_s`` after the start."""
    gcs.fly(time_s - gcs.fleet.now_us / 1e6)


def local(gcs):
    position = gcs.position - gcs.fleet.pilot.status.origin[0]
    return position[[1, 0, 2]] * (1.0, 1.0, -1.0)


def heartbeat(gcs):
    newest = gcs.newest("HEARTBEAT")
    return newest.base_mode, newest.custom_mode, newest.system_status


def follow(gcs, until_s, **asked):
    """Setpoints five times a second."""
    while gcs.fleet.now_us < until_s * 1e6:
        gcs.setpoint(**asked)
        gcs.fly(0.2)


def test_copter(station):
    gcs = station(model="multirotor", autopilot="ardupilot")
    at(gcs, 3.05)
    assert heartbeat(gcs) == (81, 0, 3)
    assert {each.get_type() for each in gcs.received} == {"HEARTBEAT"}
    assert gcs.command(512, 148) == 0
    assert gcs.newest("AUTOPILOT_VERSION").capabilities == 64495 - 32  # no files
    assert gcs.newest("AUTOPILOT_VERSION").flight_sw_version == 67503103
    gcs.send(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 2, 1))
    for message in (30, 32, 33):
        assert gcs.command(511, message, 100_000) == 0
    at(gcs, 4.0)
    assert gcs.arm() == FAILED
    assert gcs.texts[-1].startswith("Arm: ")
    assert gcs.mode_to(GUIDED_COPTER) == 0
    at(gcs, 6.0)
    assert heartbeat(gcs) == (89, 4, 3)
    assert gcs.command(512, 242) == FAILED  # home is not known yet
    at(gcs, 43.1)
    assert "EKF3 IMU0 is using GPS" in gcs.texts
    assert gcs.arm() == 0
    assert "Arming motors" in gcs.texts
    at(gcs, 45.0)
    assert heartbeat(gcs) == (217, 4, 3)  # on the ground it stays in standby
    assert gcs.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 10) == 0
    at(gcs, 58.6)
    assert heartbeat(gcs) == (217, 4, 4)
    assert local(gcs) == pytest.approx([0.0, 0.0, -10.0], abs=0.2)
    gcs.setpoint(position=(30.0, 0.0, -10.0))  # once
    at(gcs, 64.0)
    assert local(gcs)[0] == pytest.approx(23.4, abs=2.5)
    at(gcs, 78.6)
    assert local(gcs) == pytest.approx([30.0, 0.0, -10.0], abs=0.3)
    gcs.setpoint(position=(30.0, 30.0, -10.0))
    at(gcs, 98.6)
    assert local(gcs) == pytest.approx([30.0, 30.0, -10.0], abs=0.3)
    assert gcs.fleet.states.yaw[0] == pytest.approx(0.0, abs=0.05)  # towards the target: east
    follow(gcs, 106.6, velocity=(5.0, 0.0, 0.0))
    assert local(gcs)[0] == pytest.approx(63.4, abs=2.0)
    follow(gcs, 111.6, velocity=(0.0, 0.0, 0.0))
    assert local(gcs)[0] == pytest.approx(70.2, abs=2.0)
    at(gcs, 117.0)
    gcs.setpoint(position=(70.2, 30.0, -20.0))
    at(gcs, 132.0)
    gcs.setpoint(position=(70.2, 30.0, -15.0))
    at(gcs, 152.7)
    assert local(gcs) == pytest.approx([70.2, 30.0, -15.0], abs=0.5)
    assert gcs.mode_to(RTL_COPTER) == 0
    gcs.fly(60, until=lambda: not gcs.armed)
    assert gcs.fleet.now_us / 1e6 == pytest.approx(200.5, abs=9.0)
    assert local(gcs) == pytest.approx([0.0, 0.0, 0.0], abs=0.3)
    assert gcs.texts[-1] == "Disarming motors"
    gcs.fly(1)
    assert heartbeat(gcs)[1:] == (6, 3)


def test_rover(station):
    gcs = station(kind="rover", autopilot="ardupilot")
    at(gcs, 3.0)
    assert heartbeat(gcs) == (65, 0, 4)
    assert gcs.newest("HEARTBEAT").type == mavlink.MAV_TYPE_GROUND_ROVER
    gcs.send(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 2, 1))
    at(gcs, 4.1)
    assert gcs.arm() == FAILED
    assert gcs.mode_to(GUIDED_ROVER) == 0
    at(gcs, 42.1)
    assert heartbeat(gcs) == (9, 15, 4)
    assert gcs.arm() == 0
    assert gcs.texts[-1] == "Throttle armed"
    at(gcs, 45.06)
    assert heartbeat(gcs) == (137, 15, 4)
    gcs.setpoint(position=(30.0, 0.0, 0.0))
    at(gcs, 52.0)
    assert local(gcs)[0] == pytest.approx(18.4, abs=3.0)
    at(gcs, 70.06)
    assert local(gcs)[:2] == pytest.approx([30.4, 0.0], abs=0.6)
    assert [each.seq for each in gcs.all("MISSION_ITEM_REACHED")] == [0]
    gcs.setpoint(position=(30.0, 30.0, 0.0))
    at(gcs, 100.1)
    assert local(gcs)[:2] == pytest.approx([30.0, 30.3], abs=0.6)
    follow(gcs, 112.0, velocity=(3.0, 0.0, 0.0))
    assert local(gcs)[0] == pytest.approx(61.2, abs=3.0)
    follow(gcs, 117.0, velocity=(0.0, 0.0, 0.0))
    assert local(gcs)[0] == pytest.approx(65.9, abs=3.0)
    follow(gcs, 127.0, velocity=(0.0, 3.0, 0.0))
    follow(gcs, 132.0, velocity=(0.0, 0.0, 0.0))
    assert gcs.mode_to(RTL_ROVER) == 0
    gcs.fly(40, until=lambda: gcs.texts[-1] == "Reached destination")
    assert gcs.fleet.now_us / 1e6 == pytest.approx(159.7, abs=6.0)
    gcs.fly(4)
    assert np.hypot(*local(gcs)[:2]) < 0.6
    assert gcs.armed
    assert gcs.disarm() == 0
    assert gcs.texts[-1] == "Throttle disarmed"
