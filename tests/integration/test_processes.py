"""Agents in processes of their own: started, killed, missed."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import psutil
import pytest
from tests.integration.missions import SMALL, launch, write

from uavbridge.recording.reader import Recording

pytestmark = pytest.mark.integration


@contextmanager
def started(*arguments, **options):
    """A running ``uavbridge``; nothing of it is left afterwards."""
    process = subprocess.Popen(
        [sys.executable, "-m", "uavbridge", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        **options,
    )
    family = []
    try:
        yield process
    finally:
        with_children = psutil.Process(process.pid) if process.poll() is None else None
        if with_children is not None:
            family = with_children.children(recursive=True)
        for each in [process, *family]:
            if each.pid and psutil.pid_exists(each.pid):
                each.kill()
        process.communicate()


def wait_for(condition, within_s=30.0):
    """Poll until it is so."""
    until = time.monotonic() + within_s
    while not (found := condition()):
        assert time.monotonic() < until, f"not within {within_s} s: {condition}"
        time.sleep(0.02)
    return found


def test_agents_fly_in_child_processes(tmp_path):
    mission = write(tmp_path)
    run = launch(
        mission, "--agents-per-process", 2, "--speed", 5, "--headless", "--json",
        "--out", tmp_path / "out",
    )  # fmt: skip
    summary = json.loads(run.stdout)
    assert run.returncode == 0, run.stderr
    assert [agent["phase"] for agent in summary["agents"]] == ["landed"] * 4
    assert {event["agent"] for event in summary["events"]} >= {1, 2, 3, 4}
    for name in ("1-2", "3-4"):
        own = Recording(tmp_path / "out" / "agents" / name)
        assert any(message.topic.startswith("decision/") for message in own.messages())
    joined = Recording(tmp_path / "out")
    assert {m.topic for m in joined.messages() if m.topic.startswith("air/")} == {
        f"air/{agent}" for agent in (1, 2, 3, 4)
    }
