from __future__ import annotations

import pytest

REJECTED, DENIED, ACCEPTED = 1, 2, 0
HOLD, MISSION, RETURN, LAND = 3, 4, 5, 6


def test_arming_waits_for_a_position_and_says_so(station):
    gcs = station()
    gcs.fleet.advance(1_000_000)
    assert gcs.arm() == REJECTED
    assert "Arming denied: position estimate not ready" in gcs.texts
    assert not gcs.armed
    gcs.fly(0.5)
    assert not gcs.newest("SYS_STATUS").onboard_control_sensors_health & 1 << 28
    assert gcs.newest("HEARTBEAT").system_status in (0, 1)
    gcs.fly(5.0)
    assert gcs.newest("SYS_STATUS").onboard_control_sensors_health & 1 << 28
    assert gcs.newest("HEARTBEAT").system_status == 3
    assert gcs.arm() == ACCEPTED
    assert "Armed by external command" in gcs.texts
    assert gcs.arm() == ACCEPTED  # again changes nothing


def test_readiness_comes_after_some_seconds_of_simulated_time(station):
    gcs = station(count=20)
    ready = gcs.fleet.pilot.status.ready_us / 1e6
    assert ready.min() >= 2.0
    assert ready.max() <= 5.0
    assert len(set(ready.tolist())) == 20


@pytest.mark.parametrize("sub", [RETURN, LAND])
def test_some_modes_are_not_for_arming(station, sub):
    gcs = station()
    gcs.get_ready()
    assert gcs.mode_to(4, sub) == ACCEPTED
    assert gcs.arm() == REJECTED
    assert "mode is not for arming" in gcs.texts[-1]


def test_manual_modes_need_sticks(station):
    gcs = station()
    gcs.get_ready()
    assert gcs.mode_to(3) == ACCEPTED  # chosen on the ground
    assert gcs.arm() == REJECTED
    assert gcs.texts[-1] == "Arming denied: no remote control"


def test_arming_in_offboard_needs_setpoints(station):
    gcs = station()
    gcs.get_ready()
    assert gcs.mode_to(6) == ACCEPTED  # accepted while disarmed, as PX4 does
    assert gcs.arm() == REJECTED
    assert gcs.texts[-1] == "Arming denied: no offboard signal"
    gcs.setpoint((0, 0, -5))
    assert gcs.arm() == ACCEPTED


def test_a_low_battery_is_not_armed(station):
    gcs = station()
    gcs.get_ready()
    gcs.fleet.states.battery[0] = 0.1
    assert gcs.arm() == REJECTED
    assert gcs.texts[-1] == "Arming denied: low battery"


def test_ground_station_needed_when_its_loss_would_matter(station):
    gcs = station()
    gcs.get_ready()
    gcs.param("NAV_DLL_ACT", 2)
    assert gcs.arm() == REJECTED
    assert gcs.texts[-1] == "Arming denied: no connection to the ground station"


def test_force_arming_skips_the_checks(station):
    gcs = station()
    assert gcs.command(400, 1, 21196) == ACCEPTED
    assert gcs.armed


def test_nonsense_params_are_denied(station):
    gcs = station()
    gcs.get_ready()
    assert gcs.command(400, 2) == DENIED
    assert gcs.command(400, float("nan")) == DENIED


def test_disarms_on_the_ground_after_ten_seconds(station):
    gcs = station(model="multirotor")
    gcs.get_ready()
    gcs.arm()
    took = gcs.fly(12, lambda: not gcs.armed)
    assert took == pytest.approx(10.0, abs=0.2)
    assert "Disarmed by auto preflight" in gcs.texts


def test_disarming_in_the_air_needs_force(station):
    gcs = station(in_air_m=20.0)
    gcs.fly(1)
    assert gcs.disarm() == REJECTED
    assert gcs.texts[-1] == "Disarming denied: not landed"
    assert gcs.armed
    assert gcs.command(400, 0, 21196) == ACCEPTED
    assert not gcs.armed
    gcs.fly(4)
    assert gcs.position[2] == 0.0  # fell
