"""Missions under merge rules other than the default: the merged map steers, also over zenoh."""

import json

import pytest

from tests.integration.missions import SMALL, launch, write

pytestmark = pytest.mark.integration


def mission(folder, merge):
    guided = SMALL.replace('planner = "sweep"', 'planner = "esustpm"')
    return write(folder, f'{guided}\n[belief]\nmerge = "{merge}"\n')


@pytest.mark.parametrize("merge", ["average", "modified-ogmm", "sensed-data", "counts"])
def test_stepped(tmp_path, merge):
    path = mission(tmp_path, merge)
    done = launch(path, "--clock", "stepped", "--out", tmp_path / "o", "--json")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["coverage"] >= 0.9
    assert summary["entropy"] < 8.0  # of 16 bits


@pytest.mark.soak
def test_paced(tmp_path):
    path = mission(tmp_path, "counts")
    options = ("--clock", "paced", "--speed", 4, "--out", tmp_path / "o", "--json")
    done = launch(path, *options)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["coverage"] >= 0.9
