"""One mission over three machines, a router on each."""

import json
import time
from contextlib import ExitStack

import pytest

from tests.integration.hosts import address, hosts
from tests.integration.missions import write
from tests.integration.test_processes import PAIR, running
from uavbridge.recording.reader import Recording

pytestmark = [pytest.mark.integration, pytest.mark.timeout(150)]

TRIO = PAIR.replace(
    "starts = [[25.0, 25.0], [225.0, 225.0]]",
    "starts = [[25.0, 25.0], [225.0, 225.0], [25.0, 225.0]]",
).replace(
    "agents_per_process = 1",
    f'remote = [2, 3]\nrouter = "tcp/{address(1)}:7447"\n\n[simulator]\nhost = "{address(1)}"',
)


def test_three_machines_fly_one_mission_though_the_link_between_them_breaks(tmp_path):
    mission = write(tmp_path, TRIO.format(duration=45.0))
    out = tmp_path / "out"
    with hosts(3) as (ground, second, third):
        routers = [f"tcp/{address(number)}:7447" for number in (1, 2, 3)]
        link = ("router", "--listen", routers[1], "--connect", routers[0])
        with (
            ExitStack() as stack,
            # started in no particular order: each waits for what it needs
            running(
                tmp_path, "agent", mission, "--id", 3, "--router", routers[2],
                "--out", tmp_path / "three", host=third,
            ) as agent_3,
            running(
                tmp_path, "router", "--listen", routers[2], "--connect", routers[1], host=third
            ),
            running(tmp_path, *link, host=second) as middle,
            running(tmp_path, "router", "--listen", routers[0], host=ground),
            running(tmp_path, "launch", mission, "--out", out, host=ground) as launcher,
            running(
                tmp_path, "agent", mission, "--id", 2, "--router", routers[1], host=second
            ) as agent_2,
        ):  # fmt: skip
            for agent in (agent_2, agent_3):
                agent.says("mission time agreed within")
            for number in (1, 2, 3):
                launcher.says(f"agent {number}: search")
            middle.process.kill()  # two machines are cut off, each by itself
            time.sleep(4.0)
            stack.enter_context(running(tmp_path, *link, host=second))
            for number in (1, 2, 3):
                launcher.says(f"agent {number}: landed", within_s=80.0)
            assert agent_2.process.wait(30) == 0, agent_2.text
            assert agent_3.process.wait(30) == 0, agent_3.text
            launcher.process.wait(30)
    summary = json.loads((out / "summary.json").read_text())
    assert [agent["state"] for agent in summary["agents"]] == ["landed"] * 3
    assert not [text for text in summary["failures"] if "agent" in text]
    assert {death["agent"] for death in summary["deaths"] if death["back_s"]} == {2, 3}
    heard = {m.topic for m in Recording(tmp_path / "three").messages()}
    assert {"heard/3", "decision/3"} <= heard
    assert summary["agents"][2]["frames_heard"] > 20
    alone, *elsewhere = [agent["clock_error_s"] for agent in summary["agents"]]
    assert alone is None
    assert all(0.0 < error_s < 0.5 for error_s in elsewhere)
