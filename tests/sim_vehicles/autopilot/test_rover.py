"""A rover under PX4."""

from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from planners.terrain import Terrain
from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic

ORIGIN = Geodetic(47.397742, 8.545594, 489.4)


@pytest.fixture
def gcs(station):
    made = station(kind="rover")
    made.get_ready()
    return made


def offboard(gcs, **asked):
    gcs.stream = lambda: gcs.setpoint(**asked)
    gcs.fly(0.5)
    assert gcs.mode_to(6) == 0


def test_it_says_what_it_is(gcs):
    gcs.fly(3)
    heartbeat = gcs.newest("HEARTBEAT")
    assert heartbeat.type == mavlink.MAV_TYPE_GROUND_ROVER
    assert heartbeat.autopilot == mavlink.MAV_AUTOPILOT_PX4
    assert gcs.newest("EXTENDED_SYS_STATE").landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND
    gcs.send(mavlink.MAVLink_param_request_list_message(1, 1))
    gcs.fly(20)
    names = {each.param_id for each in gcs.all("PARAM_VALUE")}
    assert {"RO_SPEED_LIM", "RO_YAW_RATE_LIM", "NAV_ACC_RAD", "COM_OF_LOSS_T"} <= names
    assert not [name for name in names if name.startswith(("MPC_", "LNDMC_"))]


def test_velocity_setpoints(gcs):
    assert gcs.arm() == 0
    offboard(gcs, velocity=(3.0, 0.0, -2.0))  # up is nothing that it can do
    gcs.fly(5)
    assert gcs.velocity == pytest.approx([0.0, 3.0, 0.0], abs=0.05)
    assert gcs.position[2] == 0.0
    gcs.stream = lambda: gcs.setpoint(velocity=(0.0, -2.0, 0.0))
    gcs.fly(6)
    assert gcs.velocity == pytest.approx([-2.0, 0.0, 0.0], abs=0.05)
    assert gcs.fleet.states.yaw[0] % (2 * np.pi) == pytest.approx(np.pi, abs=0.02)


def test_position_setpoints(gcs):
    assert gcs.arm() == 0
    offboard(gcs, position=(30.0, 20.0, -5.0))
    gcs.fly(20)
    assert gcs.position == pytest.approx([20.0, 30.0, 0.0], abs=0.3)


def test_setpoints_that_end_bring_it_home(gcs):
    assert gcs.arm() == 0
    offboard(gcs, velocity=(3.0, 0.0, 0.0))
    gcs.fly(10)
    gcs.stream = None
    gcs.fly(3)
    assert gcs.mode == "Return"
    gcs.fly(60, until=lambda: not gcs.armed)
    assert np.hypot(*gcs.position[:2]) < 2.5


def test_hold_stops_it(gcs):
    assert gcs.arm() == 0
    offboard(gcs, velocity=(5.0, 0.0, 0.0))
    gcs.fly(5)
    assert gcs.mode_to(4, 3) == 0
    gcs.stream = None
    gcs.fly(4)
    assert np.abs(gcs.velocity).max() < 0.05
    assert gcs.armed
    assert gcs.disarm() == 1  # an armed rover is not "landed" for PX4


def test_take_off_does_nothing_and_land_disarms(gcs):
    assert gcs.arm() == 0
    gcs.fly(1)
    assert gcs.command(mavlink.MAV_CMD_NAV_TAKEOFF, *[float("nan")] * 6, 500) == 0
    gcs.fly(0.5)
    assert gcs.mode == "Hold"
    assert gcs.position == pytest.approx([0.0, 0.0, 0.0], abs=0.01)
    assert gcs.command(mavlink.MAV_CMD_NAV_LAND) == 0
    gcs.fly(5, until=lambda: not gcs.armed)
    assert gcs.texts[-2:] == ["Landing detected", "Disarmed by landing"]


def test_modes_without_sticks_and_such_as_it_has_not(gcs):
    assert gcs.mode_to(2) == 2  # altitude
    assert gcs.arm() == 0
    assert gcs.mode_to(1) == 1  # manual: nobody holds the sticks


def item(seq, command, x=0, y=0, z=0.0, frame=6, params=(0, 0, 0, 0)):
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, seq, frame, command, int(seq == 0), 1, *map(float, params), x, y, z
    )


def test_missions(gcs):
    lat, lon = round(ORIGIN.latitude_deg * 1e7), round(ORIGIN.longitude_deg * 1e7)
    items = [
        item(0, 22, lat, lon, 10.0),
        item(1, 16, lat + 2000, lon, 10.0),
        item(2, 178, frame=2, params=(1, 6.0, 0, 0)),
        item(3, 16, lat + 2000, lon + 3000, 10.0),
        item(4, 20, frame=2),
    ]
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, len(items), 0))
    for each in items:
        gcs.fly(0.1)
        gcs.send(each)
    gcs.fly(0.1)
    assert gcs.newest("MISSION_ACK").type == 0
    assert gcs.mode_to(4, 4) == 0
    assert gcs.arm() == 0
    gcs.fly(20, until=lambda: gcs.mode == "Return")
    assert gcs.position == pytest.approx([22.6, 22.2, 0.0], abs=2.5)
    assert [each.seq for each in gcs.all("MISSION_ITEM_REACHED")] == [0, 1, 2, 3]
    gcs.fly(60, until=lambda: not gcs.armed)


def test_slopes_slow_it_and_stop_it(station):
    """East the ground rises by 0.3 m/m, at 100 m by more than a rover climbs."""
    x = np.arange(31.0) * 10.0
    heights = np.where(x < 100.0, 0.3 * x, 30.0 + 1.0 * (x - 100.0))
    terrain = Terrain(-50.0, -50.0, 10.0, np.add.outer(heights, np.zeros(11)))
    gcs = station(kind="rover", terrain=terrain)
    gcs.get_ready()
    assert gcs.position[2] == pytest.approx(15.0)
    assert gcs.arm() == 0
    offboard(gcs, velocity=(0.0, 12.0, 0.0))
    gcs.fly(5)
    most = 12.0 * (1.0 - 0.3 / np.tan(np.radians(35.0)))
    assert np.linalg.norm(gcs.velocity) == pytest.approx(most, rel=0.02)
    gcs.fly(15)
    assert gcs.position[0] < 50.5
    assert gcs.position[2] == pytest.approx(terrain.height_at(gcs.position), abs=1e-6)


def test_kinds_share_a_fleet():
    """Each as it does alone, by its own index."""
    specs = [
        VehicleSpec(1, (0.0, 0.0, 0.0), kind="rover"),
        VehicleSpec(2, (10.0, 0.0, 0.0)),
        VehicleSpec(3, (20.0, 0.0, 0.0), kind="rover"),
        VehicleSpec(4, (30.0, 0.0, 0.0), in_air_m=20.0),
    ]
    fleet = Fleet(specs, origin=ORIGIN, seed=3)
    link = mavlink.MAVLink(None, 255, 190)
    arm = [
        mavlink.MAVLink_command_long_message(i, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0).pack(link)
        for i in range(1, 5)
    ]
    sent = []
    for t in range(80):
        fleet.advance(fleet.now_us + 100_000)
        if t == 60:
            for i in (0, 1):
                fleet.receive(i, arm[i])
        if t > 60:
            velocity = mavlink.MAVLink_set_position_target_local_ned_message(
                0, 1, 1, 1, 0xDC7, 0, 0, 0, 2.0, 0, 0, 0, 0, 0, 0, 0
            )
            fleet.receive(0, velocity.pack(link))
            mode = mavlink.MAVLink_command_long_message(1, 1, 176, 0, 1, 6, 0, 0, 0, 0, 0)
            fleet.receive(0, mode.pack(link))
        sent.extend(fleet.transmit())
    kinds = {}
    for index, datagram in sent:
        for message in mavlink.MAVLink(None).parse_buffer(datagram) or []:
            assert message.get_srcSystem() == index + 1
            if message.get_type() == "HEARTBEAT":
                kinds[index] = message.type
    assert kinds == {0: 10, 1: 2, 2: 10, 3: 2}
    truth = fleet.truth()
    assert truth.modes == ("Offboard", "Hold", "Hold", "Hold")
    assert truth.armed.tolist() == [True, True, False, True]
    assert truth.in_air.tolist() == [False, False, False, True]
    assert truth.velocity[0] == pytest.approx([0.0, 2.0, 0.0], abs=0.1)
    with pytest.raises(ValueError, match="several"):
        fleet.pilot  # noqa: B018


def test_rovers_do_not_start_in_the_air():
    with pytest.raises(ValueError, match="vehicle 1: a rover"):
        Fleet([VehicleSpec(1, (0, 0, 0), kind="rover", in_air_m=5.0)], origin=ORIGIN)
