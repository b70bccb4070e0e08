"""One mission for every kind and face: take-off, waypoint, loiter, delay, speed, jump, land."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

HOME = round(47.397742e7), round(8.545594e7)
TAKEOFF, WAYPOINT, LOITER, DELAY, SPEED, JUMP, LAND = 22, 16, 19, 93, 178, 177, 21
TURNS, SPLINE, YAW = 18, 82, 115
HOME_ROW = (WAYPOINT, 0, (0, 0), 0, 489.0)


def rows_of(plane, first):
    """Command, frame, params, metres north, height; jumps count from ``first``."""
    near, far, speed = (150, 300, 12) if plane else (0, 25, 4)
    return [
        (TAKEOFF, 3, (0, 0), near, 30.0),
        (WAYPOINT, 3, (0, 0), far, 30.0),
        (LOITER, 3, (4, 0), far, 30.0),
        (DELAY, 2, (2, 0), 0, 0.0),
        (SPEED, 2, (1, speed), 0, 0.0),
        (JUMP, 2, (first + 2, 1), 0, 0.0),
        (LAND, 3, (0, 0), 10, 0.0),
    ]


@pytest.mark.parametrize(
    ("autopilot", "kind", "modes"),
    [
        ("px4", "multirotor", [(4, 4)]),
        ("px4", "rover", [(4, 4)]),
        ("ardupilot", "multirotor", [(4,), (3,)]),
        ("ardupilot", "rover", [(15,), (10,)]),
        ("ardupilot", "plane", [(10,)]),
    ],
)
def test_a_mission(station, autopilot, kind, modes):
    gcs = station(autopilot=autopilot, kind=kind)
    gcs.get_ready()
    first = int(autopilot == "ardupilot")  # home comes before
    upload(gcs, [HOME_ROW] * first + rows_of(kind == "plane", first))
    assert gcs.mode_to(*modes[0]) == gcs.arm() == gcs.mode_to(*modes[-1]) == 0
    if first:  # ArduCopter waits on the ground for it
        assert gcs.command(mavlink.MAV_CMD_MISSION_START) == 0
    last = first + len(rows_of(False, first)) - 1
    gcs.fly(220, until=lambda: last in {each.seq for each in gcs.all("MISSION_ITEM_REACHED")})
    reached = [each.seq - first for each in gcs.all("MISSION_ITEM_REACHED")]
    assert reached == [0, 1, 2, 3, 4, 2, 3, 4, 6]


def upload(gcs, rows):
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, len(rows), 0))
    for seq, (command, frame, params, north, height) in enumerate(rows):
        four = [*map(float, params), *[0.0] * (4 - len(params))]
        gcs.fly(0.1)
        latitude = HOME[0] + round(north / 0.0111186)
        gcs.send(
            mavlink.MAVLink_mission_item_int_message(
                1, 1, seq, frame, command, 0, 1, *four, latitude, HOME[1], height,
            )
        )  # fmt: skip
    gcs.fly(0.1)
    assert gcs.newest("MISSION_ACK").type == 0


@pytest.mark.parametrize(
    ("kind", "modes", "radius", "seconds"),
    [
        ("multirotor", [(4,), (3,)], 10.0, 36.0),  # at CIRCLE_RATE, 20 degrees a second
        ("rover", [(15,), (10,)], 20.0, 50.0),  # at WP_SPEED
        ("plane", [(10,)], 90.0, 51.0),  # at AIRSPEED_CRUISE
    ],
)
def test_ardupilot_loiters_so_many_turns(station, kind, modes, radius, seconds):
    gcs = station(autopilot="ardupilot", kind=kind)
    gcs.get_ready()
    far = 300 if kind == "plane" else 30
    upload(
        gcs,
        [
            HOME_ROW,
            (TAKEOFF, 3, (0, 0), far / 2, 30.0),
            (TURNS, 3, (2, 0, radius), far, 30.0),
            (WAYPOINT, 3, (0, 0), far, 30.0),
        ],
    )
    assert gcs.mode_to(*modes[0]) == gcs.arm() == gcs.mode_to(*modes[-1]) == 0
    assert gcs.command(mavlink.MAV_CMD_MISSION_START) == 0

    def away():
        return math.hypot(gcs.position[0], gcs.position[1] - far)

    gcs.fly(60, until=lambda: away() < 1.15 * radius and gcs.fleet.pilot.plans[0].current == 2)
    gcs.fly(3 if kind == "multirotor" else 8)
    distances = []

    def done():
        distances.append(away())
        return 2 in {each.seq for each in gcs.all("MISSION_ITEM_REACHED")}

    took = gcs.fly(2 * seconds, until=done)
    assert took == pytest.approx(seconds, rel=0.3)
    assert np.median(distances) == pytest.approx(radius, rel=0.15)


def test_arducopter_turns_where_it_is_told_to(station):
    gcs = station(autopilot="ardupilot")
    gcs.get_ready()
    upload(
        gcs,
        [
            HOME_ROW,
            (TAKEOFF, 3, (0, 0), 0, 10.0),
            (SPLINE, 3, (0, 0), 20, 10.0),
            (YAW, 2, (250, 0), 0, 0.0),
            (DELAY, 2, (30, 0), 0, 0.0),
        ],
    )
    assert gcs.mode_to(4) == gcs.arm() == gcs.mode_to(3) == 0
    assert gcs.command(mavlink.MAV_CMD_MISSION_START) == 0
    gcs.fly(60, until=lambda: 3 in {each.seq for each in gcs.all("MISSION_ITEM_REACHED")})

    def heading():
        return math.degrees(math.pi / 2 - gcs.fleet.states.yaw[0]) % 360.0

    assert heading() == pytest.approx(250.0, abs=3.0)
    assert gcs.mode_to(4) == gcs.command(mavlink.MAV_CMD_CONDITION_YAW, 90, 0, 1, 0) == 0
    gcs.fly(20, until=lambda: abs(heading() - 90.0) < 3.0)
    assert gcs.command(mavlink.MAV_CMD_CONDITION_YAW, 30, 0, -1, 1) == 0
    gcs.fly(20, until=lambda: abs(heading() - 60.0) < 3.0)
    assert gcs.command(mavlink.MAV_CMD_CONDITION_YAW, 30, 0, 2, 1) == 4
