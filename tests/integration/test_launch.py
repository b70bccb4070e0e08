"""Whole missions by the command line: stepped, paced, interrupted, refused, from Python."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from dataclasses import dataclass

import numpy as np
import psutil
import pytest
from pymavlink import mavutil

import uavbridge
from planners.planner import PlannerKind
from planners.registry import BUILTIN
from planners.types import Goal, GoTo
from tests.integration.missions import ROOT, SMALL, document, launch, write
from uavbridge.recording.reader import Recording

pytestmark = pytest.mark.integration

KEYS = {
    "mission", "seed", "clock", "duration_s", "wall_s", "coverage", "uncertainty", "entropy",
    "targets", "false_targets", "agents", "radio", "min_separation_m", "failures", "deaths",
    "ticks", "late_ticks", "digest", "out",
}  # fmt: skip
AGENT_KEYS = {
    "id", "state", "distance_m", "frames_sent", "frames_heard", "bytes_sent", "bytes_heard",
    "bytes_offered", "map_bytes_sent", "dropped", "dropped_bytes", "rejected",
    "clock_offset_s", "clock_error_s", "date_offset_s",
}  # fmt: skip


@pytest.fixture(autouse=True)
def _nothing_left_behind():
    before = {child.pid for child in psutil.Process().children(recursive=True)}
    yield
    left = [c for c in psutil.Process().children(recursive=True) if c.pid not in before]
    assert not left, left


def test_stepped_mission_is_the_same_for_the_same_seed(tmp_path):
    mission = write(tmp_path)
    digests = []
    for place, (seed, hashing) in enumerate([(3, "0"), (3, "4711"), (4, "0")]):
        out = tmp_path / f"out{place}"
        arguments = ("--clock", "stepped", "--seed", seed, "--duration", 40, "--json")
        done = launch(mission, *arguments, "--out", out, env={"PYTHONHASHSEED": hashing})
        digests.append(document(done)["digest"])
    assert digests[0] == digests[1] != digests[2]
    first, second = tmp_path / "out0", tmp_path / "out1"
    for name in ("mission.mcap", "vehicle_1.tlog", "vehicle_4.tlog"):
        ours, theirs = (first / name).read_bytes(), (second / name).read_bytes()
        assert name == "mission.mcap" or ours == theirs


def test_paced_mission_over_udp_and_zenoh(tmp_path):
    out = tmp_path / "out"
    done = launch(write(tmp_path), "--clock", "paced", "--speed", 12, "--json", "--out", out)
    summary = document(done)
    assert done.returncode == 0, done.stderr
    assert set(summary) == KEYS
    assert all(set(agent) == AGENT_KEYS for agent in summary["agents"])
    assert summary["clock"] == "paced"
    assert summary["coverage"] >= 0.9
    assert [target["cell"] for target in summary["targets"]] == [[2, 3]]
    assert summary["targets"][0]["found_at_s"] > 0
    assert {agent["state"] for agent in summary["agents"]} == {"landed"}
    assert all(agent["frames_heard"] > 0 for agent in summary["agents"])
    assert summary["min_separation_m"] > 5
    assert summary["failures"] == []
    assert {path.name for path in out.iterdir()} == {
        "summary.json", "report.html", "figures", "mission.mcap", "mission.toml",
        *(f"vehicle_{i}.tlog" for i in range(1, 5)),
    }  # fmt: skip
    log = mavutil.mavlink_connection(str(out / "vehicle_2.tlog"))
    kinds = set()
    while (message := log.recv_match()) is not None:
        kinds.add(message.get_type())
    log.close()
    assert {"HEARTBEAT", "SET_POSITION_TARGET_LOCAL_NED", "COMMAND_ACK"} <= kinds
    recording = Recording(out)
    assert recording.complete
    assert recording.digest() == summary["digest"]
    topics = {message.topic.partition("/")[0] for message in recording.messages()}
    assert {"mission", "air", "heard", "obs", "setpoint", "state", "event", "score"} <= topics


def test_agents_and_vehicles_wait_for_each_other_where_the_machine_is_too_slow(tmp_path):
    done = launch(write(tmp_path), "--clock", "paced", "--speed", 1000, "--json",
                  "--out", tmp_path / "out")  # fmt: skip
    summary = document(done)
    assert summary["failures"] == []
    assert {agent["state"] for agent in summary["agents"]} == {"landed"}
    assert summary["min_separation_m"] > 5
    assert summary["wall_s"] > summary["duration_s"] / 1000 * 2
    assert "left out" not in done.stderr


def test_time_limit_without_the_goal_is_exit_status_1(tmp_path):
    done = launch(
        write(tmp_path), "--clock", "stepped", "--duration", 30, "--out", tmp_path / "o", "--json"
    )
    assert done.returncode == 1
    assert {agent["state"] for agent in document(done)["agents"]} == {"landed"}


def interrupted(mission, out, *, wait_s, signals):
    """Launch in real time, send signals; return code, output and how long the end took."""
    said = out.with_suffix(".log")
    with said.open("w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "uavbridge", "launch", str(mission), "--speed", "10",
             "--out", str(out), "--headless", "--clock", "paced"],
            stdout=log, stderr=subprocess.STDOUT,
        )  # fmt: skip
        while "zenoh router" not in said.read_text():
            assert process.poll() is None, said.read_text()
            time.sleep(0.05)
        time.sleep(wait_s)
        began = time.monotonic()
        for _ in range(signals):
            process.send_signal(signal.SIGINT)
            time.sleep(0.3)
        process.wait(60)
    return process.returncode, said.read_text(), time.monotonic() - began


def test_ctrl_c_brings_all_home(tmp_path):
    far = SMALL.replace("duration = 200.0", "duration = 2000.0").replace(
        "coverage_goal = 0.9", "coverage_goal = 1.0"
    )
    mission = write(tmp_path, far.replace("position = [125.0, 175.0]", "position = [1.0, 199.0]"))
    status, output, _ = interrupted(mission, tmp_path / "o", wait_s=6.0, signals=1)
    assert status in (0, 1)
    assert "Traceback" not in output
    assert "4 landed" in output
    assert (tmp_path / "o" / "summary.json").exists()


def test_a_second_ctrl_c_stops_at_once(tmp_path):
    status, output, took = interrupted(write(tmp_path), tmp_path / "o", wait_s=3.0, signals=2)
    assert status != 0
    assert took < 6.0
    assert "Traceback" not in output


def one_line(done, status, *words):
    """The launch ended with a status, one clear line, no traceback."""
    assert done.returncode == status, done.stderr
    assert "Traceback" not in done.stderr
    errors = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 1, done.stderr
    for word in words:
        assert word in errors[0]


def test_router_port_in_use(tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        text = SMALL + f'\n[bus]\nlisten = "tcp/127.0.0.1:{port}"\n'
        done = launch(write(tmp_path, text), "--out", tmp_path / "o", "--clock", "paced")
    one_line(done, 1, "small.toml: bus.listen: ", f"127.0.0.1:{port}", "in use")


def test_router_that_is_not_there(tmp_path):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    done = launch(write(tmp_path), "--router", endpoint, "--out", tmp_path / "o")
    one_line(done, 1, "small.toml: bus.router: ", endpoint)


def test_vehicle_port_in_use(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        text = SMALL + f"\n[simulator]\nports = {port}\n"
        done = launch(write(tmp_path, text), "--out", tmp_path / "o", "--clock", "paced")
    one_line(done, 1, "small.toml: simulator.ports: ", str(port), "in use")


def test_endpoint_port_in_use(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        text = SMALL + f'\n[[agents]]\nid = 2\nendpoint = "udpin:127.0.0.1:{port}"\n'
        done = launch(write(tmp_path, text), "--out", tmp_path / "o", "--clock", "paced")
    one_line(done, 1, "small.toml: endpoint of agent 2: ", str(port), "in use")


def test_files_where_it_starts_do_not_get_in_the_way(tmp_path):
    for name in ("planners", "numpy", "zenoh"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError")
    done = subprocess.run(
        [sys.executable, "-P", "-m", "uavbridge", "launch", write(tmp_path), "--clock", "paced",
         "--duration", "1", "--speed", "10", "--out", "o", "--json"],
        capture_output=True, text=True, check=False, cwd=tmp_path, timeout=60,
    )  # fmt: skip
    assert {agent["state"] for agent in document(done)["agents"]} <= {"landed", "failed"}


def test_a_reader_that_goes_away_does_not_end_the_flight(tmp_path):
    arguments = ["launch", write(tmp_path), "--clock", "stepped", "--out", tmp_path / "o"]
    process = subprocess.Popen(
        [sys.executable, "-m", "uavbridge", *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    process.stdout.readline()
    process.stdout.close()
    _, errors = process.communicate(timeout=100)
    assert "Traceback" not in errors
    summary = json.loads((tmp_path / "o" / "summary.json").read_text())
    assert {agent["state"] for agent in summary["agents"]} == {"landed"}


def test_an_endpoint_that_never_answers_costs_only_itself(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    text = SMALL + f'\n[[agents]]\nid = 2\nendpoint = "udpin:127.0.0.1:{port}"\n'
    done = launch(write(tmp_path, text), "--speed", 15, "--out", tmp_path / "o", "--json")
    summary = document(done)
    assert done.returncode == 1
    assert len(summary["failures"]) == 1
    assert summary["failures"][0].startswith("agent 2: never answered")
    assert f"udpin:127.0.0.1:{port}" in summary["failures"][0]
    assert [agent["state"] for agent in summary["agents"]] == [
        "landed", "failed", "landed", "landed",
    ]  # fmt: skip


def test_a_vehicle_that_refuses_to_arm_says_why(tmp_path):
    text = SMALL + "\n[simulator.parameters]\nCOM_ARM_MIS_REQ = 1\n"
    done = launch(write(tmp_path, text), "--clock", "stepped", "--out", tmp_path / "o", "--json")
    failures = document(done)["failures"]
    assert done.returncode == 1
    assert len(failures) == 4
    assert all("refused to arm" in text and "mission" in text for text in failures)


def test_a_third_party_planner_flies(tmp_path):
    paths = [ROOT / "tests" / "plugin_package", ROOT / "docs" / "examples" / "my_planner"]
    path = os.pathsep.join([*map(str, paths), os.environ.get("PYTHONPATH", "")])
    listed = subprocess.run(
        [sys.executable, "-m", "uavbridge", "planners", "--json"],
        capture_output=True, text=True, check=True, env={**os.environ, "PYTHONPATH": path},
    )  # fmt: skip
    names = {each["name"] for each in json.loads(listed.stdout)}
    (mine,) = names - set(BUILTIN)
    done = launch(
        write(tmp_path), "--planner", mine, "--clock", "stepped", "--duration", 60,
        "--out", tmp_path / "o", "--json", env={"PYTHONPATH": path},
    )  # fmt: skip
    assert document(done)["coverage"] > 0.2


@dataclass(frozen=True)
class NoParams:
    pass


class Eastwards:
    def init(self, view):
        return None

    def plan(self, view, memory, rng):
        return Goal(GoTo(view.position + np.array([30.0, 0.0, 0.0]))), None


def test_a_planner_of_ones_own_from_python(tmp_path):
    kind = PlannerKind("eastwards", "Flies east.", NoParams, lambda scenario, params: Eastwards())
    result = uavbridge.run(write(tmp_path), planner=kind, overrides={"duration": 60.0})
    assert result.tracks[1].shape[1] == 3
    assert result.tracks[1][:, 0].max() > 150
    assert result.belief.shape == (4, 4)
    assert len(result.series.t_s) == len(result.series.coverage) > 60
    assert np.isfinite(result.min_separation_m)
    assert result.out == ""


def test_a_page_is_served_while_it_flies(tmp_path):
    arguments = ["--speed", "10", "--duration", "20", "--headless", "--clock", "paced", "--web"]
    with subprocess.Popen(
        [sys.executable, "-m", "uavbridge", "launch", str(write(tmp_path)), *arguments,
         "--out", str(tmp_path / "o")],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    ) as process:  # fmt: skip
        lines = iter(process.stdout.readline, "")
        address = next(line.split()[1] for line in lines if line.startswith("page http"))
        with urllib.request.urlopen(address, timeout=10) as page:
            assert b"<!doctype html>" in page.read()
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(address, timeout=2)


def test_a_stepped_mission_has_no_page(tmp_path):
    done = launch(write(tmp_path), "--clock", "stepped", "--web", "--out", tmp_path / "o")
    one_line(done, 2, "--web", "stepped")
