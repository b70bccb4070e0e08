"""Missions with pheromones: repeatable, verified, both forms, columns kept, parts elsewhere."""

import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from tests.integration.missions import write
from uavbridge import config
from uavbridge.bus.messages import decode_truth
from uavbridge.bus.zenoh_bus import Router
from uavbridge.place.agent import patch_of
from uavbridge.recording.reader import Recording
from uavbridge.replay.verify import verify
from uavbridge.runner.launch import fly

pytestmark = pytest.mark.integration

MISSION = """
name = "small-pheromones"
seed = 5
planner = "pheromone"
duration = 60.0
tick = 0.5
coverage_goal = 1.0

[parameters]
sensor = 3
speed_m_s = 7.0

[area]
cell_m = 20.0
columns = 12
rows = 12

[pheromones]
form = "{form}"
step_s = 2.5
period = 8

[fleet]
starts = [[10.0, 10.0], [50.0, 10.0], [10.0, 50.0]]
altitude_m = 25.0

[sensor]
p = 0.97
q = 0.005
reach_m = 40.0

[belief]
prior = 0.05

[[obstacles]]
position = [110.0, 110.0]
radius_m = 25.0

[[obstacles]]
position = [190.0, 70.0]
radius_m = 15.0

[[targets]]
position = [150.0, 50.0]

[[targets]]
position = [50.0, 170.0]

[radio]
range_m = 200.0
{radio}
"""
COLUMNS = np.array([[110.0, 110.0, 25.0], [190.0, 70.0, 15.0]])


def mission(folder, form="places", radio="", extra=""):
    return write(folder, MISSION.format(form=form, radio=radio) + extra, f"{form}.toml")


def flown(path, folder, **changes):
    """Fly a mission in lockstep, without a report."""
    if folder is not None:
        folder.mkdir()
    return fly(config.load(path, {"clock": "stepped", **changes}), folder=folder)


def paced(path, folder, duration_s):
    """Fly a mission six times as fast as real time, without a report."""
    return flown(path, folder, clock="paced", speed=6.0, duration=duration_s)


def nearest(folder):
    """How near to a column's surface any vehicle ever was."""
    least = np.inf
    for message in Recording(folder).messages():
        if message.topic == "truth":
            place = decode_truth(message.data).position[:, None, :2]
            apart = np.hypot(*(place - COLUMNS[:, :2]).transpose(2, 0, 1)) - COLUMNS[:, 2]
            least = min(least, apart.min())
    return least


@pytest.mark.parametrize("form", ["places", "copies"])
def test_missions_are_repeatable_verified_and_keep_out_of_columns(form, tmp_path):
    path = mission(tmp_path, form, "loss = 0.1")
    first = flown(path, tmp_path / "a")
    assert first.digest == flown(path, None).digest
    checked = verify(tmp_path / "a")
    assert checked.ok, checked.difference
    assert checked.decisions > 200
    assert nearest(tmp_path / "a") > 1.0
    topics = {message.topic for message in Recording(tmp_path / "a").messages()}
    layers = {f"layer/pheromone-{name}" for name in ("target", "obstacle", "path", "combined")}
    assert layers | {"answer/1", "obstacle/1"} <= topics
    assert first.found >= 1


def test_a_place_agent_that_fails_costs_its_tile_only(tmp_path):
    extra = """
[[pheromones.failures]]
place = 1001
from_s = 20.0
to_s = 45.0
"""
    result = flown(mission(tmp_path, extra=extra), tmp_path / "out")
    assert not result.failures
    assert verify(tmp_path / "out").ok


@pytest.fixture
def place_agent(tmp_path):
    """Starts place agents alone; ends them afterwards."""
    children = []

    def start(path, router, *places):
        given = [f"--place={place}" for place in places]
        child = subprocess.Popen(
            [sys.executable, "-m", "uavbridge", "agent", str(path), *given, "--router", router,
             "--store", str(tmp_path / "tiles")],
            stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        children.append(child)
        assert child.stdout.readline().startswith("place agents 1001")
        return child

    yield start
    for child in children:
        child.terminate()
        child.communicate(timeout=10)


def tile(folder):
    """What the place agent stored last."""
    return patch_of((folder / "place-1001.tile").read_bytes()[8:])


def until(condition, limit_s=150.0):
    """Wait for something to become true."""
    end = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.1)


def test_a_place_agent_alone_is_killed_comes_back_and_forgets_for_the_next_run(
    tmp_path, place_agent
):
    stored = tmp_path / "tiles" / "place-1001.tile"
    with Router() as router, ThreadPoolExecutor(1) as aside:
        extra = f'\n[bus]\nrouter = "{router.endpoint}"\n'
        text = MISSION.format(form="places", radio="").replace(
            'form = "places"', 'form = "places"\nremote = [1001]'
        )
        path = write(tmp_path, text + extra)
        child = place_agent(path, router.endpoint, 1001)

        def kill_and_restart():
            until(lambda: stored.exists() and tile(stored.parent).step >= 8)
            child.kill()
            child.wait()
            before = tile(stored.parent)
            place_agent(path, router.endpoint, 1001)
            return before

        restarted = aside.submit(kill_and_restart)
        result = paced(path, tmp_path / "out", 45.0)
        assert not result.failures
        before, after = restarted.result(), tile(stored.parent)
        assert after.step > before.step + 2
        worn = before.layers[2] < 1.0
        assert worn.any()
        assert (after.layers[2][worn] < 1.0).all(), "what it stored is what it went on from"
        paced(path, None, 5.0)
        assert tile(stored.parent).step < after.step, "another run begins anew"
    answers = [m for m in Recording(tmp_path / "out").messages() if m.topic.startswith("answer/")]
    assert len(answers) > 20
    assert nearest(tmp_path / "out") > 0.0
