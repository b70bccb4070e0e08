"""A planner that another package brings flies a mission."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = f"{ROOT / 'docs/examples/my_planner'}{os.pathsep}{ROOT / 'tests/plugin_package'}"
MISSION = """
name = "third-party"
planner = "nearest-unseen"
clock = "stepped"

[parameters]
speed_m_s = 9.0

[area]
cell_m = 50
columns = 4
rows = 4

[fleet]
starts = [[25, 25], [175, 175]]
model = "perfect"

[[targets]]
position = [130, 60]
"""


@pytest.mark.integration
def test_it_flies(tmp_path: Path) -> None:
    path = tmp_path / "mission.toml"
    path.write_text(MISSION)
    done = subprocess.run(
        [sys.executable, "-m", "uavbridge", "launch", path, "--json", "--out", tmp_path / "out"],
        capture_output=True,
        text=True,
        timeout=100,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": PACKAGE},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["mission"] == "third-party"
    assert summary["coverage"] >= 0.9
    assert [target["cell"] for target in summary["targets"]] == [[2, 1]]
    assert summary["targets"][0]["found_at_s"] is not None
    assert [agent["state"] for agent in summary["agents"]] == ["landed", "landed"]
    assert all(agent["frames_heard"] > 0 for agent in summary["agents"])
    assert (tmp_path / "out" / "report.html").exists()
