"""A flight whose process is killed: what it wrote reads, reports and verifies."""

import re
import signal
import subprocess
import sys
import time

import pytest
from click.testing import CliRunner

from tests.integration.missions import ROOT, write
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
