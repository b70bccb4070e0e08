"""A mission whose bus asks everybody who they are: a real router, real certificates."""

import json
import math
import re
import shutil
import subprocess
import sys

import pytest
from websockets.sync.client import connect

from tests.integration.missions import write
from tests.integration.test_pheromones import MISSION
from tests.integration.test_processes import PAIR, router_of, running, searching
from uavbridge.bus.security import Identity
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.errors import BusError, ConfigError
from uavbridge.keys import make
from uavbridge.recording.reader import Recording

pytestmark = [pytest.mark.integration, pytest.mark.timeout(150)]

SECURE = PAIR.replace("[bus]\nagents_per_process = 1", '[security]\nkeys = "keys"')


def command(verb, router, *keys):
    return subprocess.run(
        [sys.executable, "-m", "uavbridge", "command", verb, "--router", router, *map(str, keys)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_only_those_with_credentials_take_part(tmp_path):
    mission = write(tmp_path, SECURE.format(duration=200.0))
    make(tmp_path / "keys", "pair", [1, 2])
    make(tmp_path / "late", "pair", [1, 2], days=-1.0)
    make(tmp_path / "strange", "pair", [1, 2])
    for folder in ("late", "strange"):  # the right router, the wrong certificate
        shutil.copy(tmp_path / "keys/agent-1/ca.pem", tmp_path / folder / "agent-1/ca.pem")
    with running(tmp_path, "launch", mission, "--web", "--out", tmp_path / "out") as launcher:
        router = router_of(launcher)
        launcher.says("page http://")
        assert router.startswith("tls/")
        searching(launcher)

        assert "--keys" in command("pause", router).stderr
        launcher.says("refused a session: received fatal alert: UnknownCA")
        with pytest.raises(BusError, match="no zenoh router answers"):
            ZenohBus(router.replace("tls", "tcp"), "pair")
        launcher.says("refused a session: received corrupt message")
        for folder in ("late", "strange"):
            with pytest.raises(BusError, match="does not take"):
                ZenohBus(router, "pair", identity=Identity(tmp_path / folder / "agent-1"))
        launcher.says("certificate expired")
        launcher.says("BadSignature")

        with ZenohBus(router, "pair", identity=Identity(tmp_path / "keys/agent-1")) as bus:
            bus.publish("air/0/0/2", b"spoof")
            launcher.says("refused agent-1: Put on uavbridge/pair/air/0/0/2 (1 in all)")

        refused = command("rtl", router, "--keys", tmp_path / "keys/monitor", "--timeout", 1)
        assert refused.returncode == 1
        launcher.says("refused monitor: Put on uavbridge/pair/cmd/all")
        assert "return" not in launcher.text

        page = re.search(r"page http(://\S+)", launcher.text)[1]
        with connect(f"ws{page}feed", max_size=None) as feed:  # the launcher's page is an operator
            assert json.loads(feed.recv(timeout=10))["planner"] == "esustpm"
            feed.send(json.dumps({"ask": 1, "order": "pause"}))
            told = (json.loads(text) for text in feed if isinstance(text, str))
            answer = next(message for message in told if message["kind"] == "answer")
            assert (answer["done"], answer["refused"]) == ([1, 2], [])

        obeyed = command("rtl", router, "--keys", tmp_path / "keys/operator")
        assert obeyed.returncode == 0, obeyed.stdout + obeyed.stderr
        launcher.says("agent 1: landed")
        launcher.says("agent 2: landed")
        launcher.process.wait(30)


def test_identities_that_are_not_there_are_named(tmp_path):
    with pytest.raises(ConfigError, match=r"agent-9/ca\.pem: no such file"):
        Identity(tmp_path / "agent-9")
    make(tmp_path / "keys", "pair", [1])
    with pytest.raises(ConfigError, match="keys: File exists"):
        make(tmp_path / "keys", "pair", [1])
    assert (tmp_path / "keys/agent-1/key.pem").stat().st_mode & 0o077 == 0


@pytest.mark.parametrize(
    ("told", "what"),
    [
        ({"days": math.nan}, "--days: must be at most 36500"),
        ({"days": math.inf}, "--days"),
        ({"hosts": ["ground", ""]}, "--host: ''"),
        ({"hosts": ["bäd host"]}, "--host: 'bäd host'"),
    ],
)
def test_what_makes_no_certificate_is_told_before_any_is_made(tmp_path, told, what):
    with pytest.raises(ConfigError, match=what):
        make(tmp_path / "keys", "n" * 80, [1], **told)
    assert not (tmp_path / "keys").exists()
    assert len(make(tmp_path / "keys", "n" * 80, [1])) == 5


def test_a_place_agent_has_an_identity_of_its_own(tmp_path):
    text = MISSION.format(form="places", radio="").replace(
        'form = "places"', 'form = "places"\nremote = [1001]'
    )
    mission = write(tmp_path, f'speed = 6.0\nheadless = true\n{text}[security]\nkeys = "keys"\n')
    made = subprocess.run(
        [sys.executable, "-m", "uavbridge", "keys", "new", tmp_path / "keys", "--mission", mission],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    assert "place-1001" in made.stdout
    out = tmp_path / "out"
    with running(tmp_path, "launch", mission, "--duration", 20, "--out", out) as launcher:
        router = router_of(launcher)
        place = ("agent", mission, "--place", 1001, "--router", router, "--keys")
        with running(tmp_path, *place, tmp_path / "keys/agent-1") as wrong:
            assert wrong.process.wait(30) == 2
            assert "agent-1's, not place-1001's" in wrong.text
        with running(tmp_path, *place, tmp_path / "keys/place-1001"):
            for agent in (1, 2, 3):
                launcher.says(f"agent {agent}: landed", within_s=60.0)
            launcher.process.wait(30)
    assert "refused" not in launcher.text
    answered = {m.topic for m in Recording(out / "agents" / "1").messages()}
    assert "answer/1" in answered
    assert "layer/pheromone-path" in {m.topic for m in Recording(out).messages()}
