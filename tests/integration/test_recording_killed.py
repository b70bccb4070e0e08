"""A flight whose process is killed: what it wrote reads, reports and verifies."""

import re
import signal
import subprocess
import sys
import time
from itertools import pairwise

import pytest
from click.testing import CliRunner

from tests.integration.missions import ROOT, write
from tests.integration.test_processes import PAIR, router_of, running, wait_for
from uavbridge.cli import main
from uavbridge.recording.reader import Recording

pytestmark = pytest.mark.integration
SPEED = 5.0


def test_a_killed_flight_is_recorded_up_to_its_last_second(tmp_path):
    out = tmp_path / "out"
    with subprocess.Popen(
        [sys.executable, "-m", "uavbridge", "launch", str(write(tmp_path)), "--headless",
         "--clock", "paced", "--speed", str(SPEED), "--out", str(out)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT,
    ) as process:  # fmt: skip
        for line in process.stdout:
            if re.search("[1-4] search", line):
                break
        time.sleep(1.0)
        last = max((m.t_us for m in Recording(out).messages()), default=0)
        process.send_signal(signal.SIGKILL)
        process.wait()
    recording = Recording(out)
    assert not recording.complete
    messages = list(recording.messages())
    # everything that was there before the kill, and no gap of more than a second
    assert messages[-1].t_us >= last
    seconds = {message.t_us // 1_000_000 for message in messages}
    assert seconds == set(range(max(seconds) + 1))
    assert {m.topic for m in messages} >= {"mission", "score", "truth", "air/1", "heard/1", "log"}
    assert set(recording.tlogs()) == {1, 2, 3, 4}
    done = CliRunner().invoke(main, ["report", str(out)])
    assert done.exit_code == 0, done.output
    assert "the recording ends before the mission does" in done.output
    assert (out / "figures" / "map.png").exists()
    done = CliRunner().invoke(main, ["replay", str(out), "--verify"])
    assert "none differs" in done.output
    dumped = subprocess.run(
        [sys.executable, "-m", "pymavlink.tools.mavlogdump", "--types", "HEARTBEAT",
         str(out / "vehicle_2.tlog")],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert dumped.stdout.count("HEARTBEAT") > 20, dumped.stderr


def told(folder):
    """What is recorded so far, but for what the recorder says of itself."""
    first = folder / "mission.mcap"
    there = first.exists() and first.stat().st_size > 0
    return [m for m in Recording(folder).messages() if m.topic != "head"] if there else []


def test_a_killed_recorder_is_started_again_and_appends(tmp_path):
    mission = write(tmp_path, PAIR.format(duration=60.0).replace("agents_per_process = 1", ""))
    out = tmp_path / "joined"
    with running(tmp_path, "launch", mission, "--out", tmp_path / "out") as launcher:
        record = ("record", "--router", router_of(launcher), "--out", out)
        launcher.says("agent 1: search")
        with running(tmp_path, *record) as first:
            wait_for(lambda: sum(m.topic == "state/1" for m in told(out)) > 5)
            first.process.kill()
        kept = told(out)
        killed_us = max(m.t_us for m in kept)
        began = time.monotonic()
        with running(tmp_path, *record) as second:
            second.says("recording pair to ")
            back_s = time.monotonic() - began
            launcher.process.wait(60)
            assert second.process.wait(30) == 0, second.text
    recording = Recording(out)
    assert len(recording.parts) == 2
    messages = told(out)
    assert messages[: len(kept)] == kept
    states = [m.t_us / 1e6 for m in messages if m.topic == "state/2"]
    # it missed what was said while it was away, at four times real time, and nothing else
    after = [t_s for t_s in states if t_s > killed_us / 1e6]
    assert after[0] - killed_us / 1e6 < 4.0 * (back_s + 3.0)
    assert {round(b - a) for a, b in pairwise(after)} == {1}
    assert any(m.topic == "summary" or b"landed" in m.data for m in messages[-50:])
