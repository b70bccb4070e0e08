"""``uavbridge doctor`` on vehicles of the simulator."""

import json
import socket
import subprocess
import sys

import pytest

from tests.integration.missions import write
from tests.integration.simulator import free_port, simulator

pytestmark = pytest.mark.integration


def doctor(*arguments):
    """Exit status, the document, and the words of the findings by subject."""
    done = subprocess.run(
        [sys.executable, "-m", "uavbridge", "doctor", *map(str, arguments), "--json"],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert "Traceback" not in done.stderr
    document = json.loads(done.stdout)
    bad = {f["subject"]: f["text"] for f in document["findings"] if f["level"] == "error"}
    return done.returncode, document, bad


def url(port):
    return f"udpin:127.0.0.1:{port}"


def test_two_makes_that_are_ready(tmp_path):
    speed = ("--speed", "10")
    with simulator(*speed, "--start-system", "7") as px4, simulator(
        *speed, "--start-system", "8", "--autopilot", "ardupilot"
    ) as ardupilot:  # fmt: skip
        status, document, bad = doctor(
            write(tmp_path), "--connect", url(px4.port), "--connect", url(ardupilot.port),
            "--wait", "30",
        )  # fmt: skip
    assert (status, document["ready"], bad) == (0, True, {})
    words = " ".join(finding["text"] for finding in document["findings"])
    for word in ("PX4 1.17", "ArduCopter 4.6", "system 7 at", "ready to arm", "answers in"):
        assert word in words
    biting = next(f for f in document["findings"] if "BATT_FS_LOW_ACT" in f["text"])
    assert biting["level"] == "warning"
    assert "BATT_FS_LOW_ACT" in biting["remedy"]


def test_what_is_not_ready_not_there_or_there_twice(tmp_path):
    mission = write(tmp_path)
    with simulator("--autopilot", "ardupilot", "--speed", "1") as sim:
        status, _, bad = doctor(mission, "--connect", url(sim.port), "--wait", "3")
        assert status == 1
        assert bad["agent 1"].startswith("waits for: ")
    silent = free_port()
    status, _, bad = doctor(mission, "--connect", url(silent), "--wait", "1")
    assert status == 1
    assert f"nobody is heard at {url(silent)}" in bad["agent 1"]
    with simulator("--speed", "8") as one, simulator("--speed", "8") as other:
        urls = ("--connect", url(one.port), "--connect", url(other.port))
        status, _, bad = doctor(mission, *urls, "--wait", "3")
    assert status == 1
    assert bad["vehicles"].startswith("two vehicles have system id 1: ")
    assert url(other.port) in bad["vehicles"]


def test_a_port_in_use_is_named_with_who_has_it(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        status, _, bad = doctor(write(tmp_path), "--connect", url(port))
    assert status == 1
    assert "taken by" in bad[f"udp port {port}"]
    assert "pid" in bad[f"udp port {port}"]
