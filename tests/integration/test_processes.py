"""Agents in processes of their own: started, killed, frozen, missed, back again."""

import json
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from itertools import pairwise

import psutil
import pytest

from tests.integration.missions import write
from uavbridge.agent.agent import BEACON_US
from uavbridge.bus.wire import decode_beacon
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.recording.reader import Recording

pytestmark = [pytest.mark.integration, pytest.mark.timeout(150)]

PAIR = """
name = "pair"
seed = 3
speed = 4.0
duration = {duration}
coverage_goal = 1.0
headless = true

[area]
cell_m = 50.0
columns = 6
rows = 6

[fleet]
starts = [[25.0, 25.0], [225.0, 225.0]]
altitude_m = 20.0

[safety]
altitude_min_m = 10.0
altitude_max_m = 46.0

[bus]
agents_per_process = 1
"""


class Running:
    """A running ``uavbridge`` and what it says."""

    def __init__(self, folder, *arguments, host=None):
        self.log = folder / f"{arguments[0]}-{time.monotonic_ns()}.log"
        self._file = self.log.open("w")
        where = [] if host is None else ["ip", "netns", "exec", host]
        self.process = subprocess.Popen(
            [*where, sys.executable, "-m", "uavbridge", "-v", *map(str, arguments)],
            stdin=subprocess.DEVNULL,
            stdout=self._file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self.family = []

    @property
    def text(self):
        return self.log.read_text()

    def says(self, what, within_s=40.0, after=0):
        """Wait until it says something; the place in its output."""
        return wait_for(lambda: self.text.find(what, after) + 1, within_s, lambda: self.text)

    def children(self):
        """Its child processes, by what they are."""
        found = {}
        for child in psutil.Process(self.process.pid).children(recursive=True):
            words = child.cmdline()
            self.family.append(child)
            if "agent" in words:
                found[next(word for word in words if word.startswith("--id="))] = child
            elif "router" in words:
                found["router"] = child
            elif "uavbridge.runner.simulation" in words:
                found["simulation"] = child
        return found

    def close(self):
        for each in [self.process, *self.family]:
            if psutil.pid_exists(each.pid):
                each.kill()
        self.process.wait()
        self._file.close()


def wait_for(condition, within_s=40.0, why=lambda: ""):
    """Poll until it is so."""
    until = time.monotonic() + within_s
    while not (found := condition()):
        assert time.monotonic() < until, f"not within {within_s} s: {why()}"
        time.sleep(0.02)
    return found


@contextmanager
def running(folder, *arguments, host=None):
    started = Running(folder, *arguments, host=host)
    try:
        yield started
    finally:
        started.close()


def router_of(launcher):
    """The endpoint that a launcher printed."""
    launcher.says("zenoh router ")
    return launcher.text.split("zenoh router ")[1].split(",")[0]


def gone(family):
    """Whether none of these processes is left."""
    return not [
        each for each in family if psutil.pid_exists(each.pid) and each.status() != "zombie"
    ]


def searching(launcher):
    """Wait until both agents search; the launcher's children."""
    for agent in (1, 2):
        launcher.says(f"agent {agent}: search")
    return launcher.children()


def own_beacons(mailbox):
    """Beacons that a vehicle sent by itself: between the times of its agent's."""
    heard = [decode_beacon(sample.data) for sample in mailbox.drain()]
    return [beacon for beacon in heard if beacon.t_us % BEACON_US]


def times(folder, topic):
    """When there were messages of a topic."""
    return [message.t_us for message in Recording(folder).messages() if message.topic == topic]


def second_agent(folder, launcher, out):
    """A process for agent 2 beside those that the launcher started."""
    files = [out / "mission.toml", "--out", out / "agents" / "2"]
    return running(folder, "agent", *files, "--id", 2, "--router", router_of(launcher))


@pytest.fixture
def mission(tmp_path):
    return write(tmp_path, PAIR.format(duration=35.0))


def test_agents_fly_in_child_processes(tmp_path, mission):
    out = tmp_path / "out"
    with running(tmp_path, "launch", mission, "--duration", 25, "--out", out) as launcher:
        family = list(searching(launcher).values())
        with running(
            tmp_path, "agent", mission, "--id", 2, "--router", router_of(launcher)
        ) as other:
            assert other.process.wait(30) == 1
            assert "agent 2: another process flies it already" in other.text
        launcher.process.send_signal(signal.SIGSTOP)  # the others go on without it
        time.sleep(4.0)
        launcher.process.send_signal(signal.SIGCONT)
        launcher.process.wait(60)
        summary = json.loads((out / "summary.json").read_text())
        assert [agent["state"] for agent in summary["agents"]] == ["landed", "landed"]
        assert not [text for text in summary["failures"] if "agent" in text]
        wait_for(lambda: gone(family))
    for agent in ("1", "2"):
        own = Recording(out / "agents" / agent)
        topics = {message.topic for message in own.messages()}
        assert {f"decision/{agent}", f"heard/{agent}", f"air/{agent}"} <= topics
    joined = {message.topic for message in Recording(out).messages()}
    assert {"air/1", "air/2", "truth", "state/1", "state/2"} <= joined


def test_an_agent_is_killed_and_comes_back_in_flight(tmp_path, mission):
    out = tmp_path / "out"
    with running(tmp_path, "launch", mission, "--out", out) as launcher:
        children = searching(launcher)
        children["--id=2"].kill()
        launcher.says("agent 2: its process died", within_s=2.0)
        with second_agent(tmp_path, launcher, out) as agent:
            agent.says("takes over its vehicle in ")
            launcher.says("agent 2: its process is back")
            agent.says("agent 2: landed")
            assert agent.process.wait(30) == 0
        launcher.process.wait(60)
    text = launcher.text
    assert "agent 1: landed" in text
    assert "Arm" not in text
    own = Recording(out / "agents" / "2")
    assert len(own.parts) == 2
    summary = json.loads((out / "summary.json").read_text())
    assert [death["agent"] for death in summary["deaths"]] == [2]


def test_a_frozen_agent_is_told_of_and_the_other_flies_on(tmp_path, mission):
    with running(tmp_path, "launch", mission, "--out", tmp_path / "out") as launcher:
        children = searching(launcher)
        with ZenohBus(router_of(launcher), "pair") as bus:
            beacons = bus.subscribe("safety/*/*/2")
            children["--id=2"].suspend()
            launcher.says("agent 2: its process died", within_s=2.5)
            # the vehicle, which holds and then returns, tells where it is
            by_itself = wait_for(lambda: own_beacons(beacons))
        assert by_itself[0].position[2] > 10.0
        launcher.says("agent 1: landed")
        assert launcher.process.wait(60) == 1
        assert "agent 2: its process died at" in launcher.text.split("failures")[-1]
        wait_for(lambda: gone(children.values()))


def test_a_frozen_agent_wakes_up_when_another_process_has_its_vehicle(tmp_path):
    # its vehicle holds for long enough, however slowly another process starts
    patient = "\n[simulator.parameters]\nCOM_DL_LOSS_T = 200\n"
    mission, out = write(tmp_path, PAIR.format(duration=35.0) + patient), tmp_path / "out"
    with running(tmp_path, "launch", mission, "--out", out) as launcher:
        frozen = searching(launcher)["--id=2"]
        frozen.suspend()
        launcher.says("agent 2: its process died", within_s=2.5)
        with second_agent(tmp_path, launcher, out) as heir:
            heir.says("agent 2: search")
            frozen.resume()
            launcher.says("and another one flies it by now")
            heir.says("agent 2: landed")
            assert heir.process.wait(30) == 0
        launcher.process.wait(60)
    summary = json.loads((out / "summary.json").read_text())
    assert [agent["state"] for agent in summary["agents"]] == ["landed", "landed"]
    assert not [text for text in summary["failures"] if "agent" in text]


def test_agents_come_home_without_their_launcher(tmp_path, mission):
    out = tmp_path / "out"
    with running(tmp_path, "launch", mission, "--out", out) as launcher:
        children = searching(launcher)
        launcher.process.send_signal(signal.SIGKILL)
        wait_for(lambda: gone([children["--id=1"], children["--id=2"]]), 60.0)
        wait_for(lambda: gone(children.values()), 30.0)
    for agent in (1, 2):
        phases = [
            json.loads(message.data)["phase"]
            for message in Recording(out / "agents" / str(agent)).messages()
            if message.topic == f"state/{agent}"
        ]
        assert phases[-1] == "landed"


def test_agents_tell_when_the_simulator_dies(tmp_path, mission):
    with running(tmp_path, "launch", mission, "--out", tmp_path / "out") as launcher:
        children = searching(launcher)
        children["simulation"].kill()
        assert launcher.process.wait(30) == 1
        assert "the simulation ended" in launcher.text
        wait_for(lambda: gone(children.values()))


def test_agents_search_on_without_their_router_and_join_again(tmp_path):
    mission = write(tmp_path, PAIR.format(duration=50.0))
    out = tmp_path / "out"
    with running(tmp_path, "router", "--listen", "auto") as first:
        first.says("tcp/")
        endpoint = first.text.split()[0]
        with running(tmp_path, "launch", mission, "--router", endpoint, "--out", out) as launcher:
            searching(launcher)
            first.process.kill()
            launcher.says("router: it is gone", within_s=4.0)
            time.sleep(6.0)
            with running(tmp_path, "router", "--listen", endpoint) as second:
                second.says(endpoint)
                back = len(launcher.text)
                launcher.says("router: it is back", within_s=4.0)
                launcher.says("agent 1: landed", after=back)
                launcher.says("agent 2: landed", after=back)
                launcher.process.wait(60)
    sent = times(out / "agents" / "1", "air/1")
    gone, back = max(pairwise(times(out, "truth")), key=lambda pair: pair[1] - pair[0])
    assert sum(gone < t_us < back for t_us in sent) >= 5  # it searched on alone
    summary = json.loads((out / "summary.json").read_text())
    assert summary["deaths"] == []
    assert [agent["state"] for agent in summary["agents"]] == ["landed", "landed"]
