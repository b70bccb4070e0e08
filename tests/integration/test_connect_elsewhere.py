"""An agent in a process of its own, with a vehicle that nobody simulates here."""

import pytest

from tests.integration.missions import write
from tests.integration.simulator import simulator
from tests.integration.test_processes import PAIR, router_of, running

pytestmark = [pytest.mark.integration, pytest.mark.timeout(150)]
REMOTE = PAIR.format(duration=40).replace("agents_per_process = 1", "remote = [2]")


@pytest.mark.soak
def test_a_vehicle_of_another_id_is_flown_by_an_agent_elsewhere(tmp_path):
    mission = write(tmp_path, REMOTE)
    with (
        simulator("--tcp", "--speed", "4", "--start-system", "9") as sim,
        running(tmp_path, "launch", mission, "--out", tmp_path / "o") as launcher,
        running(
            tmp_path, "agent", mission, "--id", 2, "--router", router_of(launcher),
            "--connect", f"tcp:127.0.0.1:{sim.port}",
        ) as agent,
    ):  # fmt: skip
        agent.says("system 9: PX4")
        assert agent.process.wait(100) == 0, agent.text
        launcher.process.wait(60)
        assert "agent 2: climb" in agent.text  # on its way to its start
        assert "keeps the safety net" not in agent.text
        assert "Traceback" not in agent.text + launcher.text
