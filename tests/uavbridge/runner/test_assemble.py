"""What a mission's values become."""

import pytest

from uavbridge import config
from uavbridge.runner import assemble


@pytest.mark.parametrize("clock", ["paced", "stepped"])
@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0, 200.0, 1000.0])
def test_there_is_a_fleet_for_every_speed(clock: str, speed: float) -> None:
    mission = config.load(None, {"clock": clock, "speed": speed})
    assert assemble.fleet_of(mission, (1, 2)).systems == (1, 2)
