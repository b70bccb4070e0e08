"""A signed link from end to end: who has no key is not heard."""

import pytest

from tests.integration.missions import document, launch, write
from tests.integration.simulator import simulator
from tests.integration.test_doctor import doctor

pytestmark = pytest.mark.integration


def test_only_with_the_key_does_a_mission_fly(tmp_path):
    keys, others = tmp_path / "keys", tmp_path / "others"
    keys.write_text("passphrase:open sesame\n")
    others.write_text("passphrase:abracadabra\n")
    mission = write(tmp_path)
    with simulator("--tcp", "--speed", "8", "--signing-keys", str(keys)) as sim:
        url = ("--connect", f"tcp:127.0.0.1:{sim.port}", "--vehicles", "1")
        for wrong, words in (((), "its key"), (("--signing-keys", others), "wrongly signed")):
            status, document_, bad = doctor(mission, *url, *wrong, "--wait", "2")
            assert status == 1
            assert words in bad["agent 1"], document_
        done = launch(
            mission, *url, "--signing-keys", keys, "--json", "--out", tmp_path / "o",
            "--duration", "25",
        )  # fmt: skip
    assert [agent["state"] for agent in document(done)["agents"]] == ["landed"]
    assert document(done)["failures"] == []
