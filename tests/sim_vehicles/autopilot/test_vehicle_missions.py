"""Missions flown, given through MAVLink."""

from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

NAN = float("nan")
LAT, LON = 47.397742, 8.545594
M_PER_DEGREE_N = 111_191.0
M_PER_DEGREE_E = 111_319.5 * np.cos(np.radians(LAT))
ABOVE_HOME, ORDER = 6, 2


def item(seq, command, *params, east=0.0, north=0.0, up=0.0, frame=ABOVE_HOME):
    four = [*params, *[0.0] * (4 - len(params))]
    x = round((LAT + north / M_PER_DEGREE_N) * 1e7) if frame == ABOVE_HOME else 0
    y = round((LON + east / M_PER_DEGREE_E) * 1e7) if frame == ABOVE_HOME else 0
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, seq, frame, command, int(seq == 0), 1, *map(float, four), x, y, up
    )


def upload(gcs, items, kind=0):
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, len(items), kind))
    for each in items:
        each.mission_type = kind
    for _ in range(len(items) + 1):
        for message in gcs.collect():
            if message.get_type() == "MISSION_REQUEST_INT":
                gcs.send(items[message.seq])
            elif message.get_type() == "MISSION_ACK":
                return message.type
    raise AssertionError("no MISSION_ACK")


def reached(gcs):
    return [each.seq for each in gcs.all("MISSION_ITEM_REACHED")]


def test_takeoff_waypoints_return(station):
    gcs = station(model="multirotor")
    gcs.get_ready()
    items = [
        item(0, 22, up=12.0),
        item(1, 16, 2.0, 1.0, 0, NAN, north=20.0, up=15.0),
        item(2, 16, 0, 0, 0, NAN, north=20.0, east=20.0, up=15.0),
        item(3, 20, frame=ORDER),
    ]
    assert upload(gcs, items) == 0
    assert gcs.mode_to(4, 4) == 0
    assert gcs.arm() == 0
    near = {}

    def watch():
        for name, place in (("a", (0, 20, 15)), ("b", (20, 20, 15))):
            distance = np.linalg.norm(gcs.position - place)
            near[name] = min(near.get(name, 99.0), distance)

    gcs.stream = watch
    gcs.fly(120, lambda: not gcs.armed)
    assert reached(gcs) == [0, 1, 2]
    assert near["a"] < 0.6  # waited there
    assert near["b"] < 2.1
    assert np.hypot(*gcs.position[:2]) < 0.5
    assert "RTL: land at destination" in gcs.texts


def test_speed_pause_jump_and_land(station):
    gcs = station(in_air_m=10.0)
    items = [
        item(0, 178, 1, 10.0, frame=ORDER),
        item(1, 16, north=30.0, up=10.0),
        item(2, 16, north=0.0, up=10.0),
        item(3, 177, 1, 1, frame=ORDER),  # once more from item 1
        item(4, 93, 3.0, frame=ORDER),
        item(5, 19, 2.0, north=10.0, up=10.0),
        item(6, 21, north=5.0, up=0.0),
    ]
    assert upload(gcs, items) == 0
    assert gcs.command(300, 0) == 0
    speeds = []
    gcs.stream = lambda: speeds.append(np.hypot(*gcs.velocity[:2]))
    took = gcs.fly(80, lambda: not gcs.armed)
    assert reached(gcs) == [0, 1, 2, 1, 2, 4, 5, 6]
    assert max(speeds) == pytest.approx(10.0, abs=0.2)
    assert took > 5.0
    assert gcs.position == pytest.approx([0, 5, 0], abs=0.5)
    assert "Mission finished, landed" in gcs.texts
    assert gcs.fleet.pilot.plans[0].current == 0  # ready to be flown again


def test_a_mission_without_takeoff_climbs_first(station):
    gcs = station()
    gcs.get_ready()
    assert upload(gcs, [item(0, 16, north=10.0, up=4.0)]) == 0
    gcs.mode_to(4, 4)
    gcs.arm()
    gcs.fly(5, lambda: gcs.position[2] > 1.0)
    assert np.hypot(*gcs.position[:2]) == 0.0
    gcs.fly(15)
    assert gcs.position == pytest.approx([0, 10, 4], abs=0.1)
    assert "Mission finished, loitering" in gcs.texts
    assert gcs.mode == "Mission"


def test_loops_of_jumps_do_not_hang(station):
    gcs = station(in_air_m=10.0)
    items = [
        item(0, 177, 1, -1, frame=ORDER),
        item(1, 177, 0, -1, frame=ORDER),
    ]
    assert upload(gcs, items) == 0
    gcs.mode_to(4, 4)
    gcs.fly(2)
    assert gcs.position[2] == pytest.approx(10.0)


def test_loiter_unlimited_and_pause_and_continue(station):
    gcs = station(in_air_m=10.0)
    items = [item(0, 16, north=40.0, up=10.0), item(1, 17, north=40.0, east=20.0, up=20.0)]
    assert upload(gcs, items) == 0
    gcs.command(300)
    gcs.fly(4)
    assert gcs.command(193, 0) == 0
    assert gcs.mode == "Hold"
    where = gcs.position.copy()
    gcs.fly(3)
    assert gcs.position == pytest.approx(where, abs=5.0)
    assert gcs.command(193, 1) == 0
    gcs.fly(30)
    assert gcs.position == pytest.approx([20, 40, 20], abs=0.2)
    assert gcs.mode == "Mission"
    assert reached(gcs) == [0]


def test_set_current_item(station):
    gcs = station(in_air_m=10.0)
    items = [item(k, 16, north=10.0 * k, up=10.0) for k in range(4)]
    assert upload(gcs, items) == 0
    gcs.send(mavlink.MAVLink_mission_set_current_message(1, 1, 3))
    gcs.collect()
    current = gcs.newest("MISSION_CURRENT")
    assert (current.seq, current.total) == (3, 4)
    gcs.mode_to(4, 4)
    gcs.fly(15)
    assert reached(gcs) == [3]
    gcs.send(mavlink.MAVLink_mission_set_current_message(1, 1, 9))
    gcs.collect()
    assert gcs.texts[-1] == "Mission has no item 9"
    assert gcs.command(224, 2) == 0
    assert gcs.command(224, 7) == 2
    assert gcs.command(512, 42) == 0
    assert gcs.newest("MISSION_CURRENT").seq == 2
    assert gcs.command(300, 1) == 0
    assert gcs.command(512, 42) == 0
    assert gcs.newest("MISSION_CURRENT").seq == 1


def test_mission_mode_without_a_mission_is_refused(station):
    gcs = station(in_air_m=10.0)
    assert gcs.mode_to(4, 4) == 1
    assert gcs.command(300) == 1
    assert "no valid mission" in gcs.texts[-1]


def test_clearing_the_mission_that_is_flown_holds(station):
    gcs = station(in_air_m=10.0)
    upload(gcs, [item(0, 16, north=100.0, up=10.0)])
    gcs.mode_to(4, 4)
    gcs.fly(2)
    gcs.send(mavlink.MAVLink_mission_clear_all_message(1, 1, 0))
    gcs.fly(2)
    assert gcs.mode == "Hold"


def test_polygon_fence_holds_it_in(station):
    gcs = station(in_air_m=10.0)
    corners = [(-20, -20), (30, -20), (30, 30), (-20, 30)]
    fence = [item(k, 5001, 4, east=e, north=n) for k, (e, n) in enumerate(corners)]
    fence.append(item(4, 5004, 5.0, east=0.0, north=20.0))
    assert upload(gcs, fence, kind=1) == 0
    gcs.stream = lambda: gcs.setpoint(velocity=(0.0, 4.0, 0.0))
    gcs.fly(0.2)
    gcs.mode_to(6)
    gcs.fly(12, lambda: gcs.mode == "Hold")
    assert gcs.position[0] == pytest.approx(30.2, abs=0.5)


@pytest.mark.parametrize(
    "bad",
    [
        [(5001, 4), (5001, 4), (5001, 4)],  # a corner is missing
        [(5001, 3), (5002, 3), (5001, 3)],
        [(5003, -1.0)],
        [(5001, NAN)],
    ],
)
def test_fences_that_make_no_area_are_refused(station, bad):
    gcs = station(in_air_m=10.0)
    items = [item(k, command, size, north=k) for k, (command, size) in enumerate(bad)]
    assert upload(gcs, items, kind=1) != 0
    gcs.fly(1)
    assert gcs.mode == "Hold"
