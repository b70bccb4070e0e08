"""Binding planners to missions, and what is said of wrong parameters."""

import pytest

from planners.registry import BUILTIN, bind, describe, parameters
from planners.trials import scenario


def test_the_planners_that_come_with_the_package():
    flocks = {"esustpm", "boids", "boids-guided", "starling"}
    assert set(BUILTIN) >= flocks | {"mower", "sweep", "random"}
    assert all(name == kind.name for name, kind in BUILTIN.items())


def test_defaults_and_values():
    assert bind(BUILTIN["esustpm"], scenario(), {}).params.c_m == 120.0
    assert bind(BUILTIN["esustpm"], scenario(), {"c_m": 80, "keep": "best"}).params.c_m == 80.0
    assert isinstance(parameters(BUILTIN["esustpm"], {"c_m": 80}).c_m, float)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"speed": 1.0}, r"unknown parameter 'speed' \(known: k, t, c_m,"),
        ({"c_m": "120"}, "parameter c_m must be a number, not a text"),
        ({"c_m": True}, "parameter c_m must be a number, not true or false"),
        ({"c_m": -1.0}, "parameter c_m must be at least 0, not -1.0"),
        ({"c_m": float("nan")}, "parameter c_m must be finite"),
        ({"c_m": 10**400}, "parameter c_m must be a number"),
        ({"neighbours": 2.0}, "parameter neighbours must be a whole number"),
        ({"escape_ratio": 1.5}, "parameter escape_ratio must be 0 to 1"),
        ({"keep": "never"}, "parameter keep must be one of entered, best, not 'never'"),
        ({"keep": None}, "parameter keep must be a text"),
    ],
)
def test_wrong_values_are_named(values, words):
    with pytest.raises(ValueError, match="planner esustpm: .*" + words):
        bind(BUILTIN["esustpm"], scenario(), values)


@pytest.mark.parametrize("kind", BUILTIN.values(), ids=BUILTIN)
def test_defaults_are_themselves_allowed(kind):
    assert bind(kind, scenario(), {row.name: row.default for row in describe(kind)})
    for row in describe(kind):
        assert row.doc
        assert row.unit
        assert "\n" not in row.doc
