"""Fixed-wing aircraft over MAVLink: they take off, loiter, fly lines, come back and land."""

from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sim_vehicles.geodesy import to_geodetic
from tests.sim_vehicles.conftest import ORIGIN

NAN = float("nan")
HOLD, MISSION, RETURN, LAND = (4, 3), (4, 4), (4, 5), (4, 6)


def airborne(station, **options):
    gcs = station(kind="plane", in_air_m=100.0, **options)
    gcs.get_ready()
    return gcs


def away(gcs, east, north):
    return float(np.hypot(gcs.position[0] - east, gcs.position[1] - north))


def latlon(east, north):
    latitude, longitude, _ = to_geodetic(np.array((east, north, 0.0)), ORIGIN)
    return round(latitude * 1e7), round(longitude * 1e7)


def circled(gcs, seconds=25.0):
    """Middle and radii of a loiter, and its sense: 1 is counter-clockwise."""
    track = []
    gcs.fly(seconds, lambda: track.append(gcs.position[:2].copy()) or len(track) * 0.1 >= seconds)
    places = np.array(track)
    first, second = np.diff(places, axis=0)[:-1], np.diff(places, axis=0)[1:]
    sense = np.sign(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    return places, int(np.median(sense))


def test_takeoff_from_the_runway_then_a_loiter(station):
    gcs = station(kind="plane")
    gcs.get_ready()
    assert gcs.command(mavlink.MAV_CMD_NAV_TAKEOFF, NAN, NAN, NAN, NAN, NAN, NAN, 489.4 + 60) == 0
    assert gcs.arm() == 0
    gcs.fly(40, lambda: gcs.mode == "Hold")
    assert gcs.position[2] == pytest.approx(60.0, abs=10.5)
    gcs.fly(20)
    assert gcs.position[2] == pytest.approx(60.0, abs=1.0)
    assert "Takeoff detected" in gcs.texts
    assert gcs.newest("HEARTBEAT").type == mavlink.MAV_TYPE_FIXED_WING
    speeds = [each.airspeed for each in gcs.all("VFR_HUD")[-50:]]
    assert min(speeds) > 30.0


def test_armed_in_hold_on_the_ground_it_stands(station):
    gcs = station(kind="plane")
    gcs.get_ready()
    assert gcs.arm() == 0
    gcs.fly(5)
    assert np.abs(gcs.velocity).max() < 1e-6
    assert gcs.position[2] == 0.0


def test_hold_is_a_loiter(station):
    gcs = airborne(station, model="multirotor")
    gcs.fly(20)
    centre = np.zeros(2)
    places, sense = circled(gcs)
    assert np.abs(np.linalg.norm(places - centre, axis=1) - 150.0).max() < 6.0
    assert sense == -1  # clockwise, as NAV_LOITER_RAD is positive
    assert gcs.position[2] == pytest.approx(100.0, abs=0.5)


@pytest.mark.parametrize("counter", [False, True])
def test_reposition_with_a_radius(station, counter):
    gcs = airborne(station)
    lat, lon = latlon(400.0, 300.0)
    taken = gcs.command_int(
        mavlink.MAV_CMD_DO_REPOSITION, -1, 1, 200, float(counter),
        frame=mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, x=lat, y=lon, z=140.0,
    )  # fmt: skip
    assert taken == 0
    gcs.fly(50)
    places, sense = circled(gcs, 10.0)
    assert np.abs(np.linalg.norm(places - (400.0, 300.0), axis=1) - 200.0).max() < 6.0
    assert sense == (1 if counter else -1)
    assert gcs.position[2] == pytest.approx(140.0, abs=0.5)


def test_offboard_position_is_a_loiter(station):
    gcs = airborne(station)
    gcs.stream = lambda: gcs.setpoint((500.0, 100.0, -80.0))  # north, east, down
    gcs.fly(0.2)
    assert gcs.mode_to(6) == 0
    gcs.fly(45)
    assert away(gcs, 100.0, 500.0) == pytest.approx(150.0, abs=6.0)
    assert gcs.position[2] == pytest.approx(80.0, abs=0.5)


def test_offboard_velocity_is_a_course_and_a_climb(station):
    gcs = airborne(station)
    gcs.stream = lambda: gcs.setpoint(velocity=(0.0, 40.0, -3.0))
    gcs.fly(0.2)
    assert gcs.mode_to(6) == 0
    gcs.fly(20)
    assert gcs.velocity == pytest.approx([40.0, 0.0, 3.0], abs=0.5)


def test_offboard_position_with_velocity_is_a_line(station):
    gcs = airborne(station)
    gcs.stream = lambda: gcs.setpoint((200.0, 0.0, -100.0), (0.0, 35.0, 0.0))
    gcs.fly(0.2)
    assert gcs.mode_to(6) == 0
    gcs.fly(30)
    assert gcs.position[1] == pytest.approx(200.0, abs=1.5)
    assert gcs.velocity[0] == pytest.approx(35.0, abs=0.5)


def test_no_setpoint_stops_it_or_leaves_the_envelope(station):
    gcs = airborne(station)
    gcs.stream = lambda: gcs.setpoint(velocity=(0.0, 0.0, 0.0))
    gcs.fly(0.2)
    assert gcs.mode_to(6) == 0
    slowest = []
    for velocity in ((0.0, 0.0, 0.0), (3.0, 1.0, -30.0), (0.0, -300.0, 40.0)):
        gcs.stream = lambda velocity=velocity: gcs.setpoint(velocity=velocity)
        gcs.fly(8, lambda: slowest.append(gcs.fleet.states.airspeed[0]) or len(slowest) % 80 == 0)
    assert min(slowest) > 19.0
    assert max(slowest) < 72.0


def test_a_mission_passes_its_waypoints(station):
    gcs = airborne(station)
    corners = [(0.0, 600.0, 100.0), (600.0, 600.0, 130.0), (600.0, 0.0, 100.0)]
    upload(gcs, [(mavlink.MAV_CMD_NAV_WAYPOINT, corner, (0, 0, 0, NAN)) for corner in corners])
    assert gcs.mode_to(*MISSION) == 0
    near = [1e9] * 3

    def look():
        for k, (x, y, z) in enumerate(corners):
            near[k] = min(near[k], float(np.linalg.norm(gcs.position - (x, y, z))))
        return "Mission finished, loitering" in gcs.texts

    gcs.fly(120, look)
    assert max(near) < 45.0  # a second before the corner it turns
    assert [each.seq for each in gcs.all("MISSION_ITEM_REACHED")] == [0, 1, 2]
    gcs.fly(30)
    assert away(gcs, 600.0, 0.0) == pytest.approx(150.0, abs=6.0)


def test_a_loiter_of_a_mission_has_a_radius_and_a_time(station):
    gcs = airborne(station)
    upload(
        gcs,
        [
            (mavlink.MAV_CMD_NAV_LOITER_TIME, (300.0, 300.0, 100.0), (40, 0, -180, 0)),
            (mavlink.MAV_CMD_NAV_WAYPOINT, (900.0, 300.0, 100.0), (0, 0, 0, NAN)),
        ],
    )
    assert gcs.mode_to(*MISSION) == 0
    gcs.fly(40)
    places, sense = circled(gcs, 8.0)
    assert np.abs(np.linalg.norm(places - (300.0, 300.0), axis=1) - 180.0).max() < 6.0
    assert sense == 1
    gcs.fly(60, lambda: "Mission finished, loitering" in gcs.texts)


def test_return_loiters_at_home_and_lands_when_told_to(station):
    gcs = airborne(station)
    gcs.stream = None
    lat, lon = latlon(800.0, 0.0)
    gcs.command_int(
        mavlink.MAV_CMD_DO_REPOSITION, -1, 1, 0, 0,
        frame=mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, x=lat, y=lon, z=100.0,
    )  # fmt: skip
    gcs.fly(20)
    assert gcs.mode_to(*RETURN) == 0
    gcs.fly(70)
    assert away(gcs, 0.0, 0.0) == pytest.approx(150.0, abs=6.0)
    assert gcs.position[2] == pytest.approx(60.0, abs=10.0)
    gcs.param("RTL_LAND_DELAY", 0.0)
    assert gcs.mode_to(*HOLD) == 0
    assert gcs.mode_to(*RETURN) == 0
    gcs.fly(240, lambda: not gcs.armed)
    assert gcs.position[2] == 0.0
    assert away(gcs, 0.0, 0.0) < 250.0
    assert "Landing detected" in gcs.texts


LANDING = [
    (mavlink.MAV_CMD_NAV_WAYPOINT, (900.0, 0.0, 100.0), (0, 0, 0, NAN)),
    (mavlink.MAV_CMD_DO_LAND_START, (0.0, 0.0, 0.0), (0, 0, 0, 0)),
    (mavlink.MAV_CMD_NAV_WAYPOINT, (0.0, -600.0, 40.0), (0, 0, 0, NAN)),
    (mavlink.MAV_CMD_NAV_LAND, (0.0, 0.0, 0.0), (0, 0, 0, NAN)),
]


@pytest.mark.parametrize("how", ["return", "command"])
def test_it_lands_where_the_mission_says(station, how):
    gcs = airborne(station)
    assert gcs.command(mavlink.MAV_CMD_DO_LAND_START) == 1  # for now
    upload(gcs, LANDING)
    gcs.param("RTL_TYPE", 1)
    if how == "return":
        assert gcs.mode_to(*RETURN) == 0
    else:
        assert gcs.command(mavlink.MAV_CMD_DO_LAND_START) == 0
        gcs.fly(0.5)
        assert gcs.mode == "Mission"
    heights = []
    gcs.fly(150, lambda: heights.append(gcs.position[2]) or not gcs.armed)
    assert away(gcs, 0.0, 0.0) < 150.0
    assert max(heights) < 110.0


def test_it_goes_around(station):
    gcs = airborne(station)
    upload(gcs, LANDING)
    assert gcs.command(mavlink.MAV_CMD_DO_LAND_START) == 0
    gcs.fly(150, lambda: gcs.position[2] < 8.0)
    assert gcs.command(mavlink.MAV_CMD_DO_GO_AROUND) == 0
    gcs.fly(40, lambda: gcs.position[2] > 25.0)
    gcs.fly(15)
    assert gcs.position[2] == pytest.approx(30.0, abs=4.0)  # MIS_LND_ABRT_ALT
    assert away(gcs, 0.0, 0.0) < 700.0


def test_an_orbit_then_another_altitude(station):
    gcs = airborne(station)
    lat, lon = latlon(200.0, 0.0)
    taken = gcs.command_int(
        mavlink.MAV_CMD_DO_ORBIT, -180, frame=mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT,
        x=lat, y=lon, z=100.0,
    )  # fmt: skip
    assert taken == 0
    gcs.fly(30)
    assert gcs.command(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, 489.4 + 130.0) == 0
    gcs.fly(20)
    places, sense = circled(gcs, 5.0)
    assert sense == 1
    assert np.abs(np.linalg.norm(places - (200.0, 0.0), axis=1) - 180.0).max() < 8.0
    assert gcs.position[2] == pytest.approx(130.0, abs=1.0)


def test_land_touches_down_softly(station):
    gcs = airborne(station)
    assert gcs.mode_to(*LAND) == 0
    sinks = []

    def low():
        if gcs.position[2] < 0.6:
            sinks.append(gcs.velocity[2])
        return not gcs.armed

    aim = gcs.position[:2].copy()
    touched = []
    gcs.fly(
        240, lambda: low() or (gcs.position[2] < 0.01 and touched.append(gcs.position[:2].copy()))
    )
    assert gcs.position[2] == 0.0
    assert min(sinks) > -2.0
    assert np.hypot(*(touched[0] - aim)) < 60.0


def test_it_shows_a_planes_parameters(station):
    gcs = station(kind="plane")
    parameters = gcs.fleet.pilot.parameters
    shown = {each.name for each in parameters.table}
    assert {"FW_AIRSPD_TRIM", "NAV_LOITER_RAD", "MAV_TYPE", "RTL_RETURN_ALT"} <= shown
    assert not {name for name in shown if name.startswith("MPC_")}
    gcs.param("FW_AIRSPD_TRIM", 28.0)
    assert parameters.get(0, "MPC_XY_CRUISE") == 28.0


def upload(gcs, items):
    """Send a mission: (command, (east, north, height), params 1 to 4)."""
    gcs.send(mavlink.MAVLink_mission_count_message(gcs.system, 1, len(items)))
    for seq, (command, (east, north, height), params) in enumerate(items):
        gcs.collect()
        lat, lon = latlon(east, north)
        order = command == mavlink.MAV_CMD_DO_LAND_START
        frame = mavlink.MAV_FRAME_MISSION if order else mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
        gcs.send(
            mavlink.MAVLink_mission_item_int_message(
                gcs.system, 1, seq, frame, command,
                0, 1, *params, lat, lon, height,
            )
        )  # fmt: skip
    gcs.collect()
    assert gcs.newest("MISSION_ACK").type == 0
