"""Flights end where they should; timings against recorded flights of real autopilots."""

from __future__ import annotations

import numpy as np
import pytest

NAN = float("nan")
HOLD, MISSION, RETURN, LAND = (4, 3), (4, 4), (4, 5), (4, 6)


def up(gcs, height=10.0):
    gcs.get_ready()
    gcs.param("MIS_TAKEOFF_ALT", height)
    assert gcs.mode_to(4, 2) == 0
    assert gcs.arm() == 0
    return gcs.fly(30, lambda: gcs.position[2] > 0.9 * height)


def test_takeoff_climbs_and_holds(station):
    gcs = station(model="multirotor")
    took = up(gcs)
    # PX4 12.0 s from arming to 90 %, ArduCopter 1 s + 7.0 s
    assert 7.0 < took < 13.0
    gcs.fly(8)
    assert gcs.mode == "Hold"
    assert gcs.position == pytest.approx([0, 0, 10], abs=0.3)
    assert gcs.texts.index("Using default takeoff altitude: 10.0 m") < gcs.texts.index(
        "Takeoff detected"
    )
    assert max(each.relative_alt for each in gcs.all("GLOBAL_POSITION_INT")) < 10_700
    states = [each.landed_state for each in gcs.all("EXTENDED_SYS_STATE")]
    assert [state for state, before in zip(states, [0, *states], strict=False) if state != before]
    assert {1, 2, 3} == set(states)


def test_takeoff_command_takes_a_height(station):
    gcs = station()
    gcs.get_ready()
    assert gcs.arm() == 0
    assert gcs.command(22, NAN, NAN, NAN, NAN, NAN, NAN, 489.4 + 25) == 0
    gcs.fly(25)
    assert gcs.position[2] == pytest.approx(25.0, abs=0.1)
    assert gcs.mode == "Hold"


def test_takeoff_command_with_nans_or_zeros_uses_the_parameter(station):
    for height in (NAN, 0.0):
        gcs = station()
        gcs.get_ready()
        assert gcs.command(22, NAN, NAN, NAN, NAN, NAN, NAN, height) == 0
        assert gcs.arm() == 0
        gcs.fly(10)
        assert gcs.position[2] == pytest.approx(2.5, abs=0.1)


@pytest.mark.parametrize("model", ["multirotor", "perfect"])
def test_offboard_from_the_ground(station, model):
    gcs = station(model=model)
    gcs.get_ready()
    gcs.stream = lambda: gcs.setpoint((5.0, 3.0, -8.0))  # north, east, down
    gcs.fly(0.3)
    assert gcs.mode_to(6) == 0
    assert gcs.arm() == 0
    gcs.fly(20)
    assert gcs.position == pytest.approx([3.0, 5.0, 8.0], abs=0.2)
    assert gcs.mode == "Offboard"


def test_offboard_position_step_like_a_real_one(station):
    gcs = station(model="multirotor", in_air_m=10.0)
    gcs.stream = lambda: gcs.setpoint((30.0, 0.0, -10.0))
    gcs.fly(0.2)
    assert gcs.mode_to(6) == 0
    took = gcs.fly(20, lambda: gcs.position[1] > 27.0)
    assert 4.0 < took < 8.0  # PX4 4.4 s, ArduCopter 6.2 s
    gcs.fly(8)
    assert gcs.position == pytest.approx([0, 30, 10], abs=0.5)


def test_offboard_velocity_and_stop(station):
    gcs = station(model="multirotor", in_air_m=20.0)
    gcs.stream = lambda: gcs.setpoint(velocity=(5.0, 0.0, 0.0))
    gcs.fly(0.2)
    assert gcs.mode_to(6) == 0
    took = gcs.fly(8, lambda: gcs.velocity[1] > 4.5)
    assert 1.5 < took < 4.0  # ArduCopter 2.3 s
    gcs.fly(5)
    assert gcs.velocity == pytest.approx([0, 5, 0], abs=0.25)
    gcs.stream = lambda: gcs.setpoint(velocity=(0.0, 0.0, 0.0))
    gcs.fly(5)
    assert np.abs(gcs.velocity).max() < 0.3
    assert gcs.position[2] == pytest.approx(20.0, abs=0.3)


def test_velocity_is_limited_by_parameters_as_they_change(station):
    gcs = station(in_air_m=50.0)
    gcs.stream = lambda: gcs.setpoint(velocity=(30.0, 40.0, -20.0))
    gcs.fly(0.2)
    assert gcs.mode_to(6) == 0
    gcs.fly(2)
    assert np.hypot(*gcs.velocity[:2]) == pytest.approx(12.0)
    assert gcs.velocity[0] / gcs.velocity[1] == pytest.approx(4 / 3)
    assert gcs.velocity[2] == pytest.approx(3.0)
    gcs.param("MPC_XY_VEL_MAX", 2.0)
    gcs.param("MPC_Z_VEL_MAX_UP", 1.0)
    gcs.fly(1)
    assert np.hypot(*gcs.velocity[:2]) == pytest.approx(2.0)
    assert gcs.velocity[2] == pytest.approx(1.0)


def test_hold_brakes_and_stays(station):
    gcs = station(model="multirotor", in_air_m=20.0)
    gcs.stream = lambda: gcs.setpoint(velocity=(0.0, 6.0, 0.0))
    gcs.fly(0.2)
    gcs.mode_to(6)
    gcs.fly(6)
    east = float(gcs.position[0])
    assert gcs.mode_to(*HOLD) == 0
    gcs.stream = None
    gcs.fly(6)
    where = gcs.position.copy()
    assert 2.0 < where[0] - east < 15.0
    gcs.fly(5)
    assert gcs.position == pytest.approx(where, abs=0.3)


@pytest.mark.parametrize("model", ["multirotor", "perfect"])
def test_land_slows_down_touches_and_disarms(station, model):
    gcs = station(model=model, in_air_m=20.0)
    gcs.fly(0.5)
    assert gcs.command(21, 0, 0, 0, NAN) == 0
    gcs.fly(30, lambda: gcs.position[2] < 15)
    assert gcs.velocity[2] == pytest.approx(-1.5, abs=0.1)
    gcs.fly(30, lambda: gcs.position[2] < 2)
    assert gcs.velocity[2] == pytest.approx(-0.7, abs=0.1)
    assert gcs.newest("EXTENDED_SYS_STATE").landed_state == 4
    gcs.fly(10, lambda: "Landing detected" in gcs.texts)
    took = gcs.fly(4, lambda: not gcs.armed)
    assert took == pytest.approx(2.0, abs=0.2)
    assert gcs.texts[-1] == "Disarmed by landing"
    gcs.fly(1)
    assert gcs.newest("EXTENDED_SYS_STATE").landed_state == 1
    assert gcs.mode == "Hold"  # not Land: the mode before comes back
    assert gcs.arm() == 0  # and up again


def test_return_like_px4(station):
    gcs = station(model="multirotor", in_air_m=15.0)
    gcs.fleet.states.position[0, :2] = 50.0, 55.0
    gcs.fly(0.5)
    assert gcs.command(20) == 0
    assert "RTL: start return at 519 m (30 m above destination)" in gcs.texts
    highest, fastest = 0.0, 0.0

    def watch():
        nonlocal highest, fastest
        highest = max(highest, gcs.position[2])
        fastest = max(fastest, np.hypot(*gcs.velocity[:2]))

    gcs.stream = watch
    home = gcs.fly(60, lambda: np.hypot(*gcs.position[:2]) < 1.5)
    assert 20.0 < home < 32.0  # PX4 27.4 s from as far
    assert highest == pytest.approx(30.0, abs=0.5)
    assert fastest == pytest.approx(5.0, abs=0.5)
    down = gcs.fly(60, lambda: gcs.position[2] < 0.15)
    assert 22.0 < down < 35.0  # PX4 28.9 s
    gcs.fly(8, lambda: not gcs.armed)
    assert np.hypot(*gcs.position[:2]) < 0.5
    assert "RTL: land at destination" in gcs.texts


def test_return_is_lower_close_to_home(station):
    gcs = station(in_air_m=12.0)
    gcs.fleet.states.position[0, 0] = 20.0
    gcs.param("RTL_CONE_ANG", 45)
    gcs.command(20)
    assert any("(20 m above destination" in text for text in gcs.texts)
    gcs.param("RTL_CONE_ANG", 0)
    gcs.mode_to(*HOLD)
    gcs.command(20)
    assert any("(30 m above destination" in text for text in gcs.texts)


def test_return_may_wait_before_landing(station):
    gcs = station(in_air_m=12.0)
    gcs.param("RTL_LAND_DELAY", -1)
    gcs.command(20)
    gcs.fly(20)
    assert gcs.position[2] == pytest.approx(10.0, abs=0.9)
    assert gcs.armed


def test_reposition_goes_there_and_holds(station):
    gcs = station(in_air_m=20.0)
    gcs.fly(0.5)
    north = 47.397742 + 30 / 111_200
    result = gcs.command_int(
        192, -1, 1, 0, NAN, x=round(north * 1e7), y=round(8.545594 * 1e7), z=489.4 + 25
    )
    assert result == 0
    gcs.fly(12)
    assert gcs.position == pytest.approx([0, 30, 25], abs=0.3)
    assert gcs.mode == "Hold"
    assert gcs.fleet.states.yaw[0] == pytest.approx(np.pi / 2, abs=0.1)  # towards it
    # relative height, keeping the place
    unset = 2**31 - 1
    assert gcs.command_int(192, 2.0, 1, 0, 0.0, frame=6, x=unset, y=unset, z=12.0) == 0
    gcs.fly(12)
    assert gcs.position == pytest.approx([0, 30, 12], abs=0.3)
    assert gcs.command_int(192, -1, 1, frame=10, x=0, y=0, z=5.0) == 9  # terrain: wrong frame
    assert gcs.command_int(192, -1, 1, x=950_000_000, y=0, z=5.0) == 2  # no such latitude


def test_change_speed_counts_until_the_mode_changes(station):
    gcs = station(in_air_m=20.0)
    north = round((47.397742 + 200 / 111_200) * 1e7)
    gcs.command_int(192, -1, 1, 0, NAN, x=north, y=round(8.545594 * 1e7), z=489.4 + 20)
    gcs.fly(2)
    assert gcs.velocity[1] == pytest.approx(5.0, abs=0.1)
    assert gcs.command(178, 1, 8) == 0
    gcs.fly(1)
    assert gcs.velocity[1] == pytest.approx(8.0, abs=0.1)
    assert gcs.command(178, 1, 0) == 2
    assert gcs.command(178, 1, -1) == 0
    assert gcs.command(178, 1, -2) == 0
    gcs.fly(1)
    assert gcs.velocity[1] == pytest.approx(5.0, abs=0.1)


def test_starting_in_the_air(station):
    gcs = station(model="multirotor", in_air_m=30.0, count=3)
    gcs.fly(5)
    truth = gcs.fleet.truth()
    assert truth.armed.all()
    assert truth.in_air.all()
    assert truth.modes == ("Hold",) * 3
    assert truth.position[:, 2] == pytest.approx([30.0] * 3, abs=0.3)


def test_wind_does_not_keep_it_from_landing_at_home(station):
    from sim_vehicles.dynamics import WindSpec

    wind = WindSpec(mean_m_s=(4.0, -2.0, 0.0), gust_m_s=1.0)
    gcs = station(model="multirotor", in_air_m=15.0, wind=wind, seed=3)
    gcs.fleet.states.position[0, :2] = 30.0, 0.0
    gcs.command(20)
    gcs.fly(90, lambda: not gcs.armed)
    assert np.hypot(*gcs.position[:2]) < 1.5
