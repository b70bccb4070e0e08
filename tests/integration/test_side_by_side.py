"""Fleets of one machine, started at once: no two vehicles share a system id or a port."""

import json
import signal
import subprocess
import sys

import pytest

from sim_vehicles.codec import Counts, decode
from tests.integration.missions import write
from tests.integration.simulator import COMMAND, free_port
from uavbridge.recording.tlog import read_tlog

pytestmark = pytest.mark.integration
STATION = 245


def start(*command):
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_simulators_that_start_together_share_nothing():
    asked = [(), ("--kind", "rover"), ("--port", str(free_port())), ("--count", "12"), ()]
    running = [start(*COMMAND, "--count", "2", *more, "--json") for more in asked]
    try:
        seats = [json.loads(each.stdout.readline())["vehicles"] for each in running]
    finally:
        for each in running:
            each.send_signal(signal.SIGINT)
            each.communicate(timeout=100)
    systems = [seat["id"] for found in seats for seat in found]
    ports = [port for found in seats for port in {seat["port"] for seat in found}]
    assert len(set(systems)) == len(systems) == 20
    assert len(set(ports)) == len(ports) == 9


def test_missions_that_fly_together_have_vehicles_of_their_own(tmp_path):
    mission = write(tmp_path)
    running = [
        start(
            *(sys.executable, "-m", "uavbridge", "launch", str(mission), "--headless"),
            *("--duration", "20", "--speed", "10", "--out", str(tmp_path / str(number))),
        )
        for number in range(2)
    ]
    for each in running:
        _, errors = each.communicate(timeout=120)
        assert "Traceback" not in errors
    systems = [senders(path) - {STATION} for path in tmp_path.glob("?/vehicle_*.tlog")]
    assert [len(each) for each in systems] == [1] * 8
    assert len(set.union(*systems)) == 8


def senders(path):
    """System ids in a recording of one vehicle's link."""
    packets = (decode(data, Counts()) for _, data in read_tlog(path, 0))
    return {packet.system for found in packets for packet in found}
