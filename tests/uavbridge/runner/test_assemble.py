"""What a mission's values become."""

from __future__ import annotations

import dataclasses

import pytest

from planners.registry import BUILTIN
from uavbridge import config
from uavbridge.errors import ConfigError
from uavbridge.runner import assemble


@pytest.mark.parametrize("clock", ["paced", "stepped"])
@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0, 200.0, 1000.0])
def test_there_is_a_fleet_for_every_speed(clock: str, speed: float) -> None:
    mission = config.load(None, {"clock": clock, "speed": speed})
    assert assemble.fleet_of(mission, (1, 2)).systems == (1, 2)


def test_a_mission_says_how_long_its_batteries_last() -> None:
    mission = config.load(None, {"simulator.endurance": 7.5})
    assert assemble.fleet_of(mission, (1, 2)).squads[0].states.endurance.tolist() == [7.5, 7.5]


def test_a_planner_that_cannot_be_bound_is_a_fault_in_one_line() -> None:
    def bind(scenario, params):
        raise KeyError("heights")

    kind = dataclasses.replace(BUILTIN["random"], bind=bind)
    with pytest.raises(ConfigError, match="planner random: KeyError: 'heights'"):
        assemble.planner_of(config.load(None, {"planner": "random"}), kind)
