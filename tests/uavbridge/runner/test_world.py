"""What simulated payloads see and hear over terrain."""

from __future__ import annotations

import numpy as np

from uavbridge import config
from uavbridge.bus import keys
from uavbridge.bus.local import LocalHub
from uavbridge.bus.messages import Obstacle, decode_obstacles, decode_readings, decode_signals
from uavbridge.runner.world import senses_of

HILLS = (
    'name = "hills"\nvehicles = 2\n[area]\ncell_m = 50\ncolumns = 6\nrows = 6\n'
    "[terrain]\nseed = 3\nsteepest_deg = 35\nhills = 6\n"
    "[[targets]]\nposition = [125, 125]\n"
    '[[agents]]\nid = 2\nkind = "rover"\n'
)


def over(mission: config.Mission, heights: list[float], x: float = 125.0) -> np.ndarray:
    terrain = mission.terrain()
    assert terrain is not None
    ground = float(terrain.height_at((x, 125.0)))
    return np.array([(x, 125.0, ground + height) for height in heights])


def test_cells_are_looked_at_from_a_height_above_the_ground() -> None:
    mission, hub = config.parse(HILLS), LocalHub()
    bus = hub.bus()
    boxes = [bus.subscribe(keys.obs(agent)) for agent in (1, 2)]
    senses = senses_of(mission, (1, 2), hub.bus())
    senses.step(0, over(mission, [3.0, 0.0]))
    low, rover = (box.drain() for box in boxes)
    assert low == []  # too low to see, however high the ground is
    assert decode_readings(rover[0].data) is not None  # stands on its cell
    senses.step(100_000, over(mission, [30.0, 0.0]))
    (seen,) = boxes[0].drain()
    readings = decode_readings(seen.data)
    assert readings is not None
    assert readings.looks[0][:2] == (2, 2)


def test_signals_take_the_place_of_cells() -> None:
    mission, hub = config.parse(HILLS + "[signals]\nperiod_s = 0.5\n"), LocalHub()
    box = hub.bus().subscribe(keys.obs(1))
    senses = senses_of(mission, (1, 2), hub.bus())
    for t_us in range(0, 1_000_000, 100_000):
        senses.step(t_us, over(mission, [30.0, 0.0], x=160.0))
    heard = [decode_signals(sample.data) for sample in box.drain()]
    assert [one.t_us for one in heard if one is not None] == [0, 500_000]
    for one in heard:
        assert one is not None
        assert one.heard[0][0] == 0
        assert not one.heard[0][2]


def test_each_agent_is_told_of_the_columns_in_its_sight_that_it_does_not_know() -> None:
    columns = "".join(
        f"[[obstacles]]\nposition = [{x}, 200]\nradius_m = 20\nknown = {known}\n"
        for x, known in ((150, "false"), (180, "true"), (280, "false"))
    )
    mission, hub = config.parse(HILLS + "[sensor]\nsight_m = 60\n" + columns), LocalHub()
    boxes = [hub.bus().subscribe(keys.obs(agent)) for agent in (1, 2)]
    senses_of(mission, (1, 2), hub.bus()).step(0, np.array([[150.0, 130, 0], [280, 10, 0]]))
    told = [[decode_obstacles(sample.data) for sample in box.drain()] for box in boxes]
    (first,) = [one for one in told[0] if one is not None]
    assert first.seen == (Obstacle(0, 150.0, 200.0, 20.0, 3.0),)
    assert not any(told[1])
