from __future__ import annotations

import struct

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sim_vehicles.px4_parameters import TABLE

INT32, REAL32 = 6, 9


def wire(value: int) -> float:
    return struct.unpack("<f", struct.pack("<i", value))[0]


def bits(value: float) -> int:
    return struct.unpack("<i", struct.pack("<f", value))[0]


def read(gcs, name):
    gcs.send(mavlink.MAVLink_param_request_read_message(1, 1, name.encode(), -1))
    values = [each for each in gcs.collect() if each.get_type() == "PARAM_VALUE"]
    return values[0] if values else None


def change(gcs, name, value, kind=REAL32):
    gcs.send(mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, kind))
    values = [each for each in gcs.collect() if each.get_type() == "PARAM_VALUE"]
    return values[0] if values else None


def test_the_whole_list_comes_a_few_at_a_time(station):
    gcs = station()
    gcs.send(mavlink.MAVLink_param_request_list_message(1, 1))
    gcs.fleet.advance(100_000)
    assert len([each for each in gcs.collect() if each.get_type() == "PARAM_VALUE"]) <= 10
    gcs.fly(2)
    values = gcs.all("PARAM_VALUE")
    assert [each.param_index for each in values] == list(range(len(TABLE)))
    assert {each.param_count for each in values} == {len(TABLE)}
    table = {parameter.name: parameter for parameter in TABLE}
    for each in values:
        parameter = table[each.param_id]
        value = bits(each.param_value) if each.param_type == INT32 else each.param_value
        assert each.param_type == parameter.type
        if parameter.name != "MAV_SYS_ID":
            assert value == pytest.approx(parameter.default, rel=1e-6)


def test_read_by_name_and_by_index(station):
    gcs = station()
    value = read(gcs, "MIS_TAKEOFF_ALT")
    assert (value.param_value, value.param_type) == (2.5, REAL32)
    gcs.send(mavlink.MAVLink_param_request_read_message(1, 1, b"", value.param_index))
    assert gcs.collect()[0].param_id == "MIS_TAKEOFF_ALT"
    gcs.send(mavlink.MAVLink_param_request_read_message(1, 1, b"", 5000))
    assert read(gcs, "NOT_THERE") is None
    assert read(gcs, "A_NAME_OF_16_BYT") is None


def test_whole_numbers_travel_as_bits(station):
    gcs = station()
    value = read(gcs, "COM_LOW_BAT_ACT")
    assert (bits(value.param_value), value.param_type) == (3, INT32)
    echo = change(gcs, "COM_LOW_BAT_ACT", wire(2), INT32)
    assert bits(echo.param_value) == 2
    echo = change(gcs, "SYS_AUTOSTART", wire(-7), INT32)
    assert bits(echo.param_value) == -7
    assert gcs.fleet.pilot.parameters.get(0, "SYS_AUTOSTART") == -7


@pytest.mark.parametrize(
    ("name", "value", "kind"),
    [
        ("COM_LOW_BAT_ACT", 2.0, REAL32),  # wrong type
        ("MIS_TAKEOFF_ALT", wire(5), INT32),
        ("COM_LOW_BAT_ACT", wire(99), INT32),  # out of range
        ("MPC_XY_CRUISE", -3.0, REAL32),
        ("MPC_XY_CRUISE", float("nan"), REAL32),
        ("MPC_XY_CRUISE", float("inf"), REAL32),
    ],
)
def test_bad_values_are_not_taken_and_the_old_one_is_told(station, name, value, kind):
    gcs = station()
    before = read(gcs, name).param_value
    echo = change(gcs, name, value, kind)
    assert echo.param_value == before
    assert gcs.texts[-1].startswith(f"parameter {name} ")


def test_unknown_ones_are_not_answered(station):
    assert change(station(), "NOT_THERE", 1.0) is None


def test_each_vehicle_has_its_own(station):
    gcs = station(count=3)
    change(gcs, "MPC_XY_CRUISE", 7.0)
    column = gcs.fleet.pilot.parameters.column("MPC_XY_CRUISE")
    assert column.tolist() == [7.0, 5.0, 5.0]
    assert gcs.fleet.pilot.parameters.column("MAV_SYS_ID").tolist() == [1.0, 2.0, 3.0]


def test_given_at_the_start(station):
    gcs = station(parameters={"MIS_TAKEOFF_ALT": 12.0})
    assert read(gcs, "MIS_TAKEOFF_ALT").param_value == 12.0
