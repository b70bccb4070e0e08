"""Orders to a mission that flies in another process."""

import json
import re
import subprocess
import sys
import time

import pytest

from tests.integration.missions import SMALL, write

pytestmark = pytest.mark.integration
# So large that nobody has seen all of it before the orders come.
SLOW = (
    SMALL.replace("columns = 4", "columns = 12")
    .replace("rows = 4", "rows = 12")
    .replace("position = [125.0, 175.0]", "position = [599.0, 599.0]")
)


@pytest.fixture
def flying(tmp_path):
    """A launched mission's router and process, after take-off; ended in the end."""
    text = SLOW.replace("duration = 200.0", "duration = 2000.0").replace(
        'planner = "sweep"', 'planner = "random"'
    )
    with subprocess.Popen(
        [sys.executable, "-m", "uavbridge", "launch", str(write(tmp_path, text)), "--headless",
         "--clock", "paced", "--speed", "10", "--out", str(tmp_path / "out")],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    ) as process:  # fmt: skip
        until = time.monotonic() + 30
        while not (router := re.search(r"tcp/\S+:\d+", process.stdout.readline())):
            assert time.monotonic() < until
        router = router.group()
        while "search" not in process.stdout.readline() and time.monotonic() < until:
            pass
        yield router, process
        if process.poll() is None:
            process.terminate()
            process.communicate(timeout=60)


def command(router, *arguments):
    done = subprocess.run(
        [sys.executable, "-m", "uavbridge", "command", *arguments, "--router", router, "--json"],
        capture_output=True, text=True, timeout=30, check=False,
    )  # fmt: skip
    assert "Traceback" not in done.stderr
    return done.returncode, json.loads(done.stdout) if done.stdout else done.stderr


def test_orders_are_obeyed_or_refused_with_a_reason(flying):
    router, process = flying
    status, replies = command(router, "pause")
    assert status == 0
    assert [reply["agent"] for reply in replies] == [1, 2, 3, 4]
    assert all(reply["ok"] and 0 < reply["took_s"] < 3 for reply in replies)
    status, replies = command(router, "pause", "--agent", "2")
    assert status == 1
    assert replies[0]["reason"] == "not in phase hold"
    assert command(router, "goto", "--to", "100,100,30", "--agent", "2")[0] == 0
    assert command(router, "hold", "--agent", "3")[0] == 0
    assert command(router, "takeover", "--agent", "3")[0] == 0
    status, message = command(router, "rtl", "--agent", "9")
    assert status == 1
    assert "agent 9" in message
    status, message = command(router, "rtl", "--mission", "other")
    assert status == 1
    assert "small" in message
    assert command(router, "abort")[0] == 0
    output, _ = process.communicate(timeout=150)
    assert "4 landed" in output
    assert process.returncode == 1


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("goto",), "--to"),
        (("pause", "--to", "1,2"), "--to"),
        (("goto", "--to", "north"), "north"),
    ],
)
def test_bad_orders_are_exit_status_2(arguments, word):
    status, message = command("tcp/127.0.0.1:1", *arguments)
    assert status == 2
    assert word in message


def test_no_router_is_said():
    status, message = command("tcp/127.0.0.1:1", "pause")
    assert status == 1
    assert "tcp/127.0.0.1:1" in message
