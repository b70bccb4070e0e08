"""One mission for every kind and face: take-off, waypoint, loiter, delay, speed, jump, land."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common as mavlink

HOME = round(47.397742e7), round(8.545594e7)
TAKEOFF, WAYPOINT, LOITER, DELAY, SPEED, JUMP, LAND = 22, 16, 19, 93, 178, 177, 21


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
    rows = rows_of(kind == "plane", first)
    rows = [(WAYPOINT, 0, (0, 0), 0, 489.0)] * first + rows
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, len(rows), 0))
    for seq, (command, frame, params, north, height) in enumerate(rows):
        gcs.fly(0.1)
        latitude = HOME[0] + round(north / 0.0111186)
        gcs.send(
            mavlink.MAVLink_mission_item_int_message(
                1, 1, seq, frame, command, 0, 1, *map(float, params), 0.0, 0.0,
                latitude, HOME[1], height,
            )
        )  # fmt: skip
    gcs.fly(0.1)
    assert gcs.newest("MISSION_ACK").type == 0
    assert gcs.mode_to(*modes[0]) == gcs.arm() == gcs.mode_to(*modes[-1]) == 0
    if first:  # ArduCopter waits on the ground for it
        assert gcs.command(mavlink.MAV_CMD_MISSION_START) == 0
    last = first + len(rows_of(False, first)) - 1
    gcs.fly(220, until=lambda: last in {each.seq for each in gcs.all("MISSION_ITEM_REACHED")})
    reached = [each.seq - first for each in gcs.all("MISSION_ITEM_REACHED")]
    assert reached == [0, 1, 2, 3, 4, 2, 3, 4, 6]
    if kind != "plane":
        assert gcs.position == pytest.approx([0.0, 10.0, 0.0], abs=3.2)
    assert gcs.position[2] == pytest.approx(0.0, abs=0.5)
