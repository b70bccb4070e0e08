"""Missions and ways to fly them, for the integration tests."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

SMALL = """
name = "small"
seed = 3
planner = "sweep"
duration = 200.0
coverage_goal = 0.9

[area]
cell_m = 50.0
columns = 4
rows = 4

[fleet]
starts = [[25.0, 25.0], [75.0, 25.0], [125.0, 25.0], [175.0, 25.0]]
altitude_m = 20.0

[sensor]
period_s = 1.0

[[targets]]
position = [125.0, 175.0]

[radio]
range_m = 120.0

[safety]
altitude_min_m = 10.0
altitude_max_m = 46.0
"""


def write(folder, text=SMALL, name="small.toml"):
    """A mission file in a folder."""
    path = folder / name
    path.write_text(text)
    return path


def launch(*arguments, env=None, timeout=100):
    """Run ``uavbridge launch``; the finished process."""
    return subprocess.run(
        [sys.executable, "-m", "uavbridge", "launch", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
        env={**os.environ, **(env or {})},
    )


def document(done):
    """The JSON document that a launch printed, with what went wrong if there is none."""
    assert done.stdout.startswith("{"), done.stdout + done.stderr
    return json.loads(done.stdout)
