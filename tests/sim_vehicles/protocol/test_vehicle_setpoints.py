from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

NAN = float("nan")
LOCAL, LOCAL_OFFSET, BODY, BODY_OFFSET, BODY_FRD = 1, 7, 8, 9, 12


def flying(station, **options):
    gcs = station(in_air_m=20.0, **options)
    gcs.fleet.states.yaw[0] = 0.0  # facing east
    gcs.fleet.states.position[0, :2] = 5.0, -5.0
    gcs.stream = lambda: gcs.setpoint((-5.0, 5.0, -20.0), yaw=np.pi / 2)
    gcs.fly(0.2)
    assert gcs.mode_to(6) == 0
    gcs.fly(5.0)
    assert gcs.position == pytest.approx([5, -5, 20], abs=0.05)
    return gcs


@pytest.mark.parametrize(
    ("frame", "position", "end"),
    [  # it faces east
        (LOCAL, (1.0, 2.0, -21.0), (2, 1, 21)),
        (LOCAL_OFFSET, (1.0, 2.0, -3.0), (7, -4, 23)),
        (BODY, (1.0, 2.0, -3.0), (6, -7, 23)),
        (BODY_OFFSET, (1.0, 2.0, -3.0), (6, -7, 23)),
        (BODY_FRD, (1.0, 2.0, -3.0), (6, -7, 23)),
    ],
)
def test_positions_in_all_frames(station, frame, position, end):
    gcs = flying(station)
    gcs.stream = None
    gcs.setpoint(position, frame=frame, yaw=np.pi / 2)
    gcs.param("COM_OF_LOSS_T", 20.0)
    gcs.fly(5)
    assert gcs.position == pytest.approx(end, abs=0.05)


@pytest.mark.parametrize(
    ("frame", "velocity"),
    [
        (LOCAL, (1.0, 2.0, 0.5)),
        (LOCAL_OFFSET, (1.0, 2.0, 0.5)),
        (BODY, (2.0, -1.0, 0.5)),
        (BODY_OFFSET, (2.0, -1.0, 0.5)),
        (BODY_FRD, (2.0, -1.0, 0.5)),
    ],
)
def test_velocities_in_all_frames(station, frame, velocity):
    gcs = flying(station)
    gcs.stream = lambda: gcs.setpoint(velocity=velocity, frame=frame, yaw=np.pi / 2)
    gcs.fly(1)
    assert gcs.velocity == pytest.approx([2.0, 1.0, -0.5], abs=1e-6)


@pytest.mark.parametrize(("frame", "height"), [(0, 489.4 + 25), (5, 489.4 + 25), (3, 25), (6, 25)])
def test_global_positions(station, frame, height):
    gcs = flying(station)
    north = 47.397742 + 15 / 111_191
    gcs.stream = lambda: gcs.send(
        mavlink.MAVLink_set_position_target_global_int_message(
            0, 1, 1, frame, 0xDF8, round(north * 1e7), 85455940, height, *[0.0] * 8
        )
    )
    gcs.fly(10)
    assert gcs.position == pytest.approx([0, 15, 25], abs=0.1)


def test_mixed_height_and_velocity(station):
    gcs = flying(station)
    gcs.stream = lambda: gcs.send(
        mavlink.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, 1, 0xDC7 & ~0x4 | 0x20, 0, 0, -30.0, 3.0, 0, 0, 0, 0, 0, 0, 0
        )
    )
    gcs.fly(5)
    assert gcs.position[2] == pytest.approx(30.0, abs=0.05)
    assert gcs.velocity[1] == pytest.approx(3.0)


def test_yaw_and_yaw_rate(station):
    gcs = flying(station, model="multirotor")
    assert gcs.fleet.states.yaw[0] == pytest.approx(0.0, abs=0.05)
    gcs.stream = lambda: gcs.setpoint((-5.0, 5.0, -20.0), yaw=np.pi)  # south
    gcs.fly(4)
    assert gcs.fleet.states.yaw[0] == pytest.approx(-np.pi / 2, abs=0.05)
    gcs.stream = lambda: gcs.setpoint((-5.0, 5.0, -20.0))  # no word of it: kept
    gcs.fly(3)
    assert gcs.fleet.states.yaw[0] == pytest.approx(-np.pi / 2, abs=0.05)
    gcs.stream = lambda: gcs.send(
        mavlink.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, 1, 0x5F8, -5.0, 5.0, -20.0, 0, 0, 0, 0, 0, 0, 0, 0.2
        )
    )
    gcs.fly(3)
    assert gcs.fleet.states.rates[0, 2] == pytest.approx(-0.2, abs=0.02)  # clockwise


@pytest.mark.parametrize(
    ("frame", "mask", "values"),
    [
        (1, 0xFFF, [0.0] * 11),  # everything ignored
        (1, 0xC3F, [0.0] * 11),  # acceleration only
        (1, 0xDF8 | 0x200, [0.0] * 11),  # force
        (1, 0xDF8, [NAN] * 11),
        (1, 0xDF8, [3e38] * 11),
        (1, 0xDF8, [float("inf")] * 11),
        (11, 0xDF8, [0.0] * 11),  # a frame that is not known here
        (255, 0xDF8, [0.0] * 11),
    ],
)
def test_setpoints_that_ask_for_nothing_do_not_count(station, frame, mask, values):
    gcs = flying(station)
    gcs.stream = lambda: gcs.send(
        mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, mask, *values)
    )
    gcs.fly(0.8)
    assert gcs.position == pytest.approx([5, -5, 20], abs=0.1)
    gcs.fly(1)
    assert gcs.mode == "Return"


def test_setpoints_for_another_vehicle_do_not_count(station):
    gcs = flying(station)
    gcs.system = 2
    gcs.fly(1.5)
    assert gcs.mode == "Return"


def test_setpoints_in_hold_change_nothing(station):
    gcs = flying(station)
    assert gcs.mode_to(4, 3) == 0
    gcs.stream = lambda: gcs.setpoint((50.0, 50.0, -50.0))
    gcs.fly(3)
    assert gcs.position == pytest.approx([5, -5, 20], abs=0.2)
