from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sim_vehicles.failsafe import FENCE, LINK_LOSS, OFFBOARD_LOSS, Action

NAN = float("nan")


def offboard(gcs):
    gcs.stream = lambda: gcs.setpoint(velocity=(1.0, 0.0, 0.0))
    gcs.fly(0.3)
    assert gcs.mode_to(6) == 0
    gcs.fly(1.0)
    gcs.stream = None


def heartbeat(gcs):
    gcs.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))


def test_offboard_without_setpoints_returns(station):
    gcs = station(in_air_m=20.0)
    offboard(gcs)
    took = gcs.fly(3, lambda: gcs.mode == "Return")
    assert took == pytest.approx(1.0, abs=0.2)  # COM_OF_LOSS_T
    assert "Failsafe activated" in gcs.texts
    gcs.fly(1.1)
    assert gcs.newest("HEARTBEAT").system_status == 5
    gcs.fly(90, lambda: not gcs.armed)
    gcs.fly(1.0)
    assert gcs.mode == "Offboard"  # shown again after landing, as PX4 does
    assert gcs.position == pytest.approx([0, 0, 0], abs=0.1)


@pytest.mark.parametrize(
    ("act", "mode"), [(0, "Return"), (1, "Return"), (3, "Return"), (4, "Land"), (5, "Hold")]
)
def test_offboard_loss_action(station, act, mode):
    gcs = station(in_air_m=20.0)
    gcs.param("COM_OBL_RC_ACT", act)
    offboard(gcs)
    gcs.fly(1.5)
    assert gcs.mode == mode


def test_offboard_loss_time_is_a_parameter(station):
    gcs = station(in_air_m=20.0)
    gcs.param("COM_OF_LOSS_T", 3.0)
    offboard(gcs)
    assert gcs.fly(5, lambda: gcs.mode != "Offboard") == pytest.approx(3.0, abs=0.2)


def test_switching_to_offboard_in_the_air_needs_setpoints(station):
    gcs = station(in_air_m=20.0)
    gcs.fly(1)
    assert gcs.mode_to(6) == 1
    assert gcs.texts[-1] == "Switching to Offboard denied: no offboard signal"
    assert gcs.mode == "Hold"


def test_someone_may_take_over_from_a_failsafe(station):
    gcs = station(in_air_m=20.0)
    offboard(gcs)
    gcs.fly(2)
    assert gcs.mode == "Return"
    assert gcs.mode_to(4, 3) == 0
    gcs.fly(5)
    assert gcs.mode == "Hold"
    assert gcs.newest("HEARTBEAT").system_status == 4


def test_link_loss_is_off_by_default(station):
    gcs = station(in_air_m=20.0)
    heartbeat(gcs)
    gcs.fly(15)
    assert gcs.mode == "Hold"
    assert "Connection to ground station lost" in gcs.texts
    heartbeat(gcs)
    gcs.fly(0.2)
    assert gcs.texts[-1] == "GCS connection regained"


@pytest.mark.parametrize(("act", "mode"), [(1, "Hold"), (2, "Return"), (3, "Land")])
def test_link_loss_action_after_a_hold(station, act, mode):
    gcs = station(in_air_m=20.0)
    gcs.param("NAV_DLL_ACT", act)
    gcs.stream = lambda: (heartbeat(gcs), gcs.setpoint(velocity=(0.0, 0.0, 0.0)))
    gcs.fly(1)
    gcs.mode_to(6)
    gcs.fly(12)
    assert gcs.mode == "Offboard"
    gcs.stream = lambda: gcs.setpoint(velocity=(0.0, 0.0, 0.0))  # setpoints alone are no link
    assert gcs.fly(14, lambda: gcs.mode == "Hold") == pytest.approx(10.0, abs=0.3)
    if act != 1:
        assert "Failsafe activated, entering Hold for 5 seconds" in gcs.texts
        assert gcs.fly(8, lambda: gcs.mode != "Hold") == pytest.approx(5.0, abs=0.2)
    assert gcs.mode == mode


def test_only_ground_stations_keep_the_link(station):
    gcs = station(in_air_m=20.0)
    heartbeat(gcs)
    gcs.stream = lambda: gcs.send(mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3))
    gcs.fly(12)
    assert "Connection to ground station lost" in gcs.texts


def test_low_battery_warns_then_returns_then_lands(station):
    gcs = station(in_air_m=20.0)
    gcs.fleet.states.position[0, 0] = 300.0
    battery = gcs.fleet.states.battery
    battery[0] = 0.14
    gcs.fly(1)
    assert gcs.texts[-1] == "Low battery level, return advised"
    assert gcs.mode == "Hold"
    battery[0] = 0.06
    gcs.fly(1)
    assert "Critical battery level, land now" in gcs.texts
    assert gcs.mode == "Hold"  # for five seconds
    gcs.fly(5)
    assert gcs.mode == "Return"
    battery[0] = 0.045
    gcs.fly(1)
    assert gcs.mode == "Land"
    gcs.fly(60, lambda: not gcs.armed)
    assert gcs.position[0] > 250.0
    assert gcs.arm() == 1


def test_low_battery_only_warns_if_told(station):
    gcs = station(in_air_m=20.0)
    gcs.param("COM_LOW_BAT_ACT", 0)
    gcs.fleet.states.battery[0] = 0.04
    gcs.fly(10)
    assert gcs.mode == "Hold"
    assert gcs.texts == ["Armed by external command"] or gcs.texts[-1].startswith("Emergency")


def test_an_empty_battery_falls(station):
    gcs = station(model="multirotor", in_air_m=20.0)
    gcs.fleet.states.battery[0] = 1e-5
    gcs.fly(20)
    assert gcs.position[2] == 0.0
    assert not gcs.armed


@pytest.mark.parametrize(("action", "mode"), [(2, "Hold"), (3, "Return"), (5, "Land")])
@pytest.mark.parametrize("limit", ["GF_MAX_HOR_DIST", "GF_MAX_VER_DIST"])
def test_geofence(station, action, mode, limit):
    gcs = station(in_air_m=20.0)
    gcs.param("GF_ACTION", action)
    gcs.param(limit, 30.0)
    gcs.stream = lambda: gcs.setpoint(velocity=(0.0, 3.0, -3.0))
    gcs.fly(0.2)
    gcs.mode_to(6)
    gcs.fly(12, lambda: gcs.mode == mode)
    away = gcs.position[0] if limit == "GF_MAX_HOR_DIST" else gcs.position[2]
    assert away == pytest.approx(30.3, abs=0.5)
    assert "Geofence exceeded" in gcs.texts


def test_geofence_warning_changes_nothing(station):
    gcs = station(in_air_m=20.0)
    gcs.param("GF_ACTION", 1)
    gcs.param("GF_MAX_VER_DIST", 10.0)
    gcs.fly(2)
    assert gcs.texts.count("Geofence exceeded") == 1
    assert gcs.mode == "Hold"


def test_action_tables_have_every_value():
    for table, values in ((OFFBOARD_LOSS, 8), (LINK_LOSS, 7), (FENCE, 6)):
        assert len(table) == values
        assert all(isinstance(each, Action) for each in table)


@pytest.mark.parametrize("model", ["multirotor", "perfect"])
def test_termination_stops_the_motors(station, model):
    gcs = station(model=model, in_air_m=20.0)
    gcs.fly(0.5)
    assert gcs.command(185, 1) == 0
    assert not gcs.armed
    gcs.fly(5)
    assert gcs.position[2] == 0.0
    assert np.abs(gcs.velocity).max() == 0.0


@pytest.mark.parametrize("model", ["perfect", "multirotor"])
def test_a_lost_gps_ends_in_a_landing(station, model):
    gps, off, well = 4, 1, 0
    gcs = station(model=model, in_air_m=20.0)
    assert gcs.command(mavlink.MAV_CMD_INJECT_FAILURE, gps, off) == 2  # SYS_FAILURE_EN is 0
    gcs.param("SYS_FAILURE_EN", 1)
    assert gcs.command(mavlink.MAV_CMD_INJECT_FAILURE, 101, off) == 3  # motors do not fail
    gcs.fly(3)
    assert gcs.newest("GPS_RAW_INT").fix_type == 3
    assert gcs.command(mavlink.MAV_CMD_INJECT_FAILURE, gps, off) == 0
    gcs.fly(2, until=lambda: gcs.mode == "Land")
    assert "Position estimate lost" in gcs.texts
    assert gcs.mode_to(4, 3) == 1  # no Hold without a position
    gcs.fly(1)
    assert gcs.newest("GPS_RAW_INT").fix_type == 1
    assert gcs.command(mavlink.MAV_CMD_INJECT_FAILURE, gps, well) == 0
    assert gcs.mode_to(4, 3) == 0
    gcs.fly(3)
    assert gcs.mode == "Hold"
