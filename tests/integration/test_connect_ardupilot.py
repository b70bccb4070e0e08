"""ArduPilot's face of the simulator, started by hand and flown beside our own vehicles."""

import pytest

from tests.integration.missions import SMALL, document, launch, write
from tests.integration.simulator import simulator

pytestmark = pytest.mark.integration
ARDUPILOT = ("--autopilot", "ardupilot", "--speed", "8")
MIXED = SMALL + '\n[[agents]]\nid = 2\nkind = "rover"\n'


@pytest.mark.soak
def test_a_copter_a_rover_and_a_simulated_px4_in_one_mission(tmp_path):
    with (
        simulator(*ARDUPILOT, "--start-system", "7") as copter,
        simulator(*ARDUPILOT, "--start-system", "9", "--kind", "rover", "--home",
                  "47.3975,8.5461,488") as rover,
    ):  # fmt: skip
        done = launch(
            write(tmp_path, MIXED), "--vehicles", 3, "--json", "--out", tmp_path / "o",
            "--duration", 45,
            "--connect", f"udpin:127.0.0.1:{copter.port}",
            "--connect", f"udpin:127.0.0.1:{rover.port}",
        )  # fmt: skip
    assert [agent["state"] for agent in document(done)["agents"]] == ["landed"] * 3, done.stderr
    assert document(done)["failures"] == []
    told = " ".join(done.stderr.split())
    assert f"agent 1: udpin:127.0.0.1:{copter.port}, system 7: ArduCopter 4.6" in told
    assert f"agent 2: udpin:127.0.0.1:{rover.port}, system 9: ArduRover 4.6" in told
    assert "keeps the safety net" not in told
