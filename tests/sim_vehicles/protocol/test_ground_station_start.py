"""What QGroundControl asks when it meets a vehicle: all of it answered or refused at once."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from pymavlink.dialects.v20 import development

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4
FACES = [
    ("px4", "multirotor"),
    ("px4", "rover"),
    ("ardupilot", "multirotor"),
    ("ardupilot", "rover"),
    ("px4", "plane"),
    ("ardupilot", "plane"),
]


@pytest.fixture(params=FACES, ids=lambda face: "-".join(face))
def gcs(request, station):
    autopilot, kind = request.param
    made = station(autopilot=autopilot, kind=kind)
    made.get_ready()
    made.px4 = autopilot == "px4"
    return made


def test_messages_asked_for(gcs):
    """Message id, and whether it is there."""
    refusal = DENIED if gcs.px4 else FAILED
    for message, name, there in [
        (148, "AUTOPILOT_VERSION", True),
        (300, "PROTOCOL_VERSION", False),
        (242, "HOME_POSITION", True),
        (33, "GLOBAL_POSITION_INT", True),
        (331, "ODOMETRY", True),
        (29, "SCALED_PRESSURE", True),
        (395, "COMPONENT_INFORMATION", False),
        (397, "COMPONENT_METADATA", False),
        (396, "COMPONENT_INFORMATION_BASIC", False),
        (259, "CAMERA_INFORMATION", False),
        (280, "GIMBAL_MANAGER_INFORMATION", False),
        (76, "COMMAND_LONG", False),
        (65000, "", False),
    ]:
        gcs.received.clear()
        assert gcs.command(512, message) == (ACCEPTED if there else refusal), name
        if there:
            assert gcs.newest(name) is not None, name


def test_the_modes_that_there_are(gcs):
    """PX4 tells all of them, or one by its number from 1; ArduPilot 4.6 does not know them."""
    assert gcs.command(512, 436) == (ACCEPTED if gcs.px4 else FAILED)
    if not gcs.px4:
        assert gcs.command(512, 435) == FAILED
        return
    modes = len(gcs.fleet.pilot.craft.modes)
    for wanted in (0, 1, modes):
        gcs.send(mavlink.MAVLink_command_long_message(1, 1, 512, 0, 435, wanted, 0, 0, 0, 0, 0))
        found = [
            message
            for _, datagram in gcs.fleet.transmit()
            for message in development.MAVLink(None).parse_buffer(datagram)
            if message.get_type() == "AVAILABLE_MODES"
        ]
        assert [each.mode_index for each in found] == (
            [wanted] if wanted else [*range(1, modes + 1)]
        )
        assert {each.number_modes for each in found} == {modes}
        names = {each.standard_mode or each.mode_name for each in found}
        assert wanted or {"Hold", "Offboard", 5, 6, 7, 8} <= names
    assert gcs.command(512, 435, modes + 1) == DENIED


def test_commands_of_the_start(gcs):
    assert gcs.command(mavlink.MAV_CMD_GET_HOME_POSITION) == ACCEPTED
    assert gcs.command(mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION, 1) == UNSUPPORTED
    assert gcs.command(mavlink.MAV_CMD_RUN_PREARM_CHECKS) == ACCEPTED
    assert gcs.command(mavlink.MAV_CMD_REQUEST_CAMERA_INFORMATION, 1) == UNSUPPORTED
    assert gcs.command(mavlink.MAV_CMD_REQUEST_STORAGE_INFORMATION, 1) == UNSUPPORTED
    assert gcs.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 30, 100_000) == ACCEPTED


def test_plans_of_all_types(gcs):
    for kind in (0, 1, 2):
        gcs.send(mavlink.MAVLink_mission_request_list_message(1, 1, kind))
        assert [each.mission_type for each in gcs.collect()] == [kind]
    assert [each.count for each in gcs.all("MISSION_COUNT")] == [0, 0, 0]


def test_all_parameters_come(gcs):
    gcs.send(mavlink.MAVLink_param_request_list_message(1, 1))
    gcs.fly(30)
    values = gcs.all("PARAM_VALUE")
    assert len({each.param_id for each in values}) == values[0].param_count == len(values)
    assert [each.param_index for each in values] == list(range(len(values)))


def test_files_are_refused_at_once(gcs):
    """Opening "/general.json": NAK, unknown command."""
    payload = bytearray(251)
    payload[:6] = 7, 0, 0, 4, 13, 0
    payload[12:25] = b"/general.json"
    gcs.send(mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, list(payload)))
    (answer,) = gcs.collect()
    assert answer.get_type() == "FILE_TRANSFER_PROTOCOL"
    assert list(answer.payload[:6]) == [8, 0, 0, 129, 1, 4]
    assert answer.payload[12] == 7


def test_there_are_no_logs(gcs):
    gcs.send(mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF))
    (answer,) = gcs.collect()
    assert (answer.get_type(), answer.num_logs) == ("LOG_ENTRY", 0)
