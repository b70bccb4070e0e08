"""Setpoints of aircraft in the forms that PX4 and ArduPlane document."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.sim_vehicles.conftest import OFFBOARD

NAN = float("nan")
TAKE_OFF, LAND, LOITER, IDLE, GLIDE = 4096, 8192, 12288, 16384, 292
POSITION = 0b110111111000
GUIDED = 15


def quaternion(roll, pitch):
    """Degrees; heading north."""
    r, p = radians(roll) / 2, radians(pitch) / 2
    return [cos(r) * cos(p), sin(r) * cos(p), cos(r) * sin(p), -sin(r) * sin(p)]


def attitude(gcs, q, thrust, mask=0b111, rates=(0.0, 0.0, 0.0)):
    gcs.send(mavlink.MAVLink_set_attitude_target_message(0, gcs.system, 1, mask, q, *rates, thrust))


def position(gcs, north, east, up, mask):
    place = north, east, -up
    gcs.send(
        mavlink.MAVLink_set_position_target_local_ned_message(
            0, gcs.system, 1, mavlink.MAV_FRAME_LOCAL_NED, mask, *place, *[0.0] * 8
        )
    )


def in_offboard(station, stream, **options):
    gcs = station(kind="plane", **{"in_air_m": 150.0, **options})
    gcs.get_ready()
    gcs.stream = lambda: stream(gcs)
    gcs.fly(0.5)
    assert gcs.command(mavlink.MAV_CMD_DO_SET_MODE, 1, *OFFBOARD) == 0
    return gcs


def tail(gcs, name, field, count=30):
    return np.array([getattr(each, field) for each in gcs.all(name)[-count:]])


def test_an_attitude_and_a_thrust(station):
    gcs = in_offboard(station, lambda g: attitude(g, quaternion(20.0, 4.0), 0.55))
    gcs.fly(10)
    assert tail(gcs, "ATTITUDE", "roll") == pytest.approx(radians(20.0), abs=0.02)
    assert tail(gcs, "ATTITUDE", "pitch") == pytest.approx(radians(4.0), abs=0.02)
    assert tail(gcs, "ATTITUDE", "yawspeed").min() > 0.05  # to the right
    assert tail(gcs, "VFR_HUD", "throttle", 10) == pytest.approx(55, abs=1)


def test_body_rates_and_a_thrust(station):
    gcs = in_offboard(station, lambda g: attitude(g, quaternion(0, 0), 0.5, 128, (-0.1, 0.0, 0.0)))
    before = tail(gcs, "ATTITUDE", "roll", 1)[0]
    gcs.fly(3)
    assert tail(gcs, "ATTITUDE", "roll", 1)[0] - before == pytest.approx(-0.3, abs=0.1)
    gcs.fly(17)
    assert tail(gcs, "ATTITUDE", "roll").min() == pytest.approx(
        radians(-55.0), abs=0.02
    )  # FW_R_LIM


@pytest.mark.parametrize(("pitch", "thrust"), [(30.0, 0.0), (-30.0, 1.0)])
def test_no_attitude_takes_it_out_of_its_envelope(station, pitch, thrust):
    gcs = in_offboard(station, lambda g: attitude(g, quaternion(50.0, pitch), thrust), in_air_m=900)
    gcs.fly(15)
    speeds = tail(gcs, "VFR_HUD", "airspeed", 10_000)
    assert speeds.min() > 19.5
    assert speeds.max() < 70.5


def test_after_attitudes_a_position_and_without_either_hold(station):
    gcs = in_offboard(station, lambda g: attitude(g, quaternion(0.0, 0.0), 0.5))
    gcs.fly(5)
    gcs.stream = lambda: position(gcs, 300.0, 0.0, 150.0, LOITER)
    gcs.fly(20)
    assert np.abs(tail(gcs, "ATTITUDE", "roll")).max() > 0.2
    assert gcs.position[2] == pytest.approx(150.0, abs=5.0)
    gcs.stream = None
    gcs.fly(5, lambda: gcs.mode != "Offboard")


def test_a_take_off_setpoint_then_a_landing_setpoint(station):
    gcs = station(kind="plane")
    gcs.get_ready()
    gcs.stream = lambda: position(gcs, 600.0, 0.0, 60.0, TAKE_OFF)
    gcs.fly(0.5)
    assert gcs.command(mavlink.MAV_CMD_DO_SET_MODE, 1, *OFFBOARD) == 0
    assert gcs.arm() == 0
    gcs.fly(40, lambda: gcs.position[2] > 55.0)
    gcs.fly(15)
    assert gcs.position[2] == pytest.approx(60.0, abs=3.0)
    assert gcs.mode == "Offboard"
    gcs.stream = lambda: position(gcs, 0.0, 0.0, 0.0, LAND)
    gcs.fly(150, lambda: not gcs.armed)
    assert np.hypot(*gcs.position[:2]) < 150.0


def test_idle_is_wings_level_without_thrust(station):
    gcs = in_offboard(station, lambda g: position(g, 0.0, 0.0, 0.0, IDLE))
    gcs.fly(6)
    assert np.abs(tail(gcs, "ATTITUDE", "roll", 10)).max() < 0.03
    assert tail(gcs, "VFR_HUD", "throttle", 10).max() == 0
    assert gcs.velocity[2] < -0.5


def test_a_glide_keeps_its_airspeed_on_the_way_to_its_place(station):
    gcs = in_offboard(station, lambda g: position(g, 3000.0, 0.0, 0.0, GLIDE), in_air_m=600)
    gcs.fly(20)
    assert tail(gcs, "VFR_HUD", "throttle", 10).max() == 0
    assert tail(gcs, "VFR_HUD", "airspeed") == pytest.approx(33.0, abs=3.0)
    assert gcs.velocity[1] > 25.0


def guided(station):
    gcs = station(kind="plane", autopilot="ardupilot", in_air_m=150.0)
    gcs.get_ready()
    assert gcs.command(mavlink.MAV_CMD_DO_SET_MODE, 1, GUIDED) == 0
    gcs.fly(1)
    return gcs


def test_arduplane_takes_an_attitude_for_three_seconds(station):
    gcs = guided(station)
    gcs.stream = lambda: attitude(gcs, quaternion(-15.0, 0.0), 0.6)
    gcs.fly(6)
    assert gcs.fleet.states.roll[0] == pytest.approx(radians(-15.0), abs=0.03)
    gcs.stream = None
    gcs.fly(10)
    assert gcs.fleet.states.roll[0] > 0.1  # round its place, clockwise, again


def test_arduplane_takes_one_angle_alone(station):
    gcs = guided(station)
    gcs.stream = lambda: attitude(gcs, quaternion(-15.0, 9.0), 0.6, 0b11000110)
    before = gcs.position[2]
    gcs.fly(8)
    assert gcs.fleet.states.roll[0] == pytest.approx(radians(-15.0), abs=0.03)
    assert gcs.position[2] == pytest.approx(before, abs=3.0)


@pytest.mark.parametrize("kind", ["multirotor", "rover"])
def test_others_pass_attitudes_over(station, kind):
    gcs = station(kind=kind)
    gcs.get_ready()
    for q in ([0.0] * 4, [NAN] * 4, quaternion(1.0, 2.0)):
        attitude(gcs, q, 0.4)
    gcs.fly(0.5)


def test_attitudes_that_are_none(station):
    gcs = in_offboard(station, lambda g: position(g, 0.0, 0.0, 150.0, LOITER))
    gcs.fly(2)
    for q, mask, rates in (
        ([0.0] * 4, 0, (0, 0, 0)),
        ([NAN] * 4, 0, (0, 0, 0)),
        ([9.0, 0, 0, 0], 0, (0, 0, 0)),
        (quaternion(0, 0), 255, (0, 0, 0)),
        (quaternion(0, 0), 128, (NAN, 0.0, 0.0)),
        (quaternion(0, 0), 128, (1e9, 0.0, 0.0)),
        (quaternion(0, 0), 131, (0.1, 0.0, 0.0)),
    ):
        attitude(gcs, q, NAN, mask, rates)
    gcs.fly(10)
    assert gcs.position[2] == pytest.approx(150.0, abs=3.0)
