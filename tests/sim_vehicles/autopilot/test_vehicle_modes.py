from __future__ import annotations

import pytest

from sim_vehicles import px4_parameters
from sim_vehicles.flavour import PX4
from sim_vehicles.modes import MODES, Mode
from sim_vehicles.params import Parameter, Parameters, Type
from sim_vehicles.routines import ROUTINES


def test_every_mode_has_a_row_and_the_automatic_ones_a_routine():
    assert set(MODES) == set(Mode) - {Mode.BRAKE}
    assert {mode for mode, spec in MODES.items() if spec.auto} == set(ROUTINES)


@pytest.mark.parametrize(
    ("mode", "custom", "base"),
    [  # as seen in the heartbeats of PX4 1.17
        (Mode.HOLD, 50593792, 29),
        (Mode.TAKEOFF, 33816576, 29),
        (Mode.OFFBOARD, 393216, 17),
        (Mode.RETURN, 84148224, 29),
    ],
)
def test_px4_numbers(mode, custom, base):
    assert PX4.custom_mode(mode) == custom
    assert PX4.base_mode(mode, armed=False) == base
    assert PX4.base_mode(mode, armed=True) == base + 128


@pytest.mark.parametrize("mode", list(MODES))
def test_px4_modes_come_back(mode):
    assert PX4.mode_of(PX4.custom_mode(mode)) is mode


@pytest.mark.parametrize(("main", "sub"), [(0, 0), (4, 1), (4, 9), (5, 0), (7, 0), (255, 3)])
def test_px4_modes_that_are_not_there(main, sub):
    assert PX4.mode_of_command(main, sub) is None


@pytest.mark.parametrize("value", [0, 1, -1, 7, 2**31 - 1, -(2**31), 123456789])
def test_whole_parameters_travel_as_bits(value):
    wire = PX4.encoded(Type.INT32, value)
    assert PX4.decoded(Type.INT32, wire) == value


def test_parameter_table():
    table = (Parameter("B", Type.REAL32, 0.1, 0.0, 1.0), Parameter("A", Type.INT32, 3, 0, 9))
    parameters = Parameters(table, 2, {"B": 0.5})
    assert [parameter.name for parameter in parameters.table] == ["A", "B"]
    column = parameters.column("A")
    parameters.set(1, "A", 7)
    assert column.tolist() == [3.0, 7.0]
    assert parameters.get(0, "B") == 0.5
    for name, value in (("A", 10), ("A", 1.5), ("B", float("nan")), ("B", float("inf"))):
        with pytest.raises(ValueError, match=name):
            parameters.set(0, name, value)
    with pytest.raises(ValueError, match="NOT_THERE"):
        Parameters(table, 1, {"NOT_THERE": 1})


def test_defaults_are_within_their_ranges():
    names = [parameter.name for parameter in px4_parameters.TABLE]
    assert len(set(names)) == len(names)
    for parameter in px4_parameters.TABLE:
        assert len(parameter.name) <= 16
        assert parameter.low <= parameter.default <= parameter.high
