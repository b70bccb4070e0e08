"""A live mission while somebody sprays garbage at its UDP ports and its keys on the bus."""

import random
import socket
import subprocess
import sys
import time
from contextlib import suppress

import pytest

from sim_vehicles.codec import Encoder
from tests.integration.missions import SMALL, document, write
from tests.integration.simulator import free_port
from uavbridge.bus import keys
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.errors import BusError
from uavbridge.recording.reader import Recording

pytestmark = pytest.mark.integration

AGENTS = (1, 2, 3, 4)
BAD_TEXTS = (
    b"", b"{}", b"null", b"[1]", b'{"order":"dance"}', b'{"order":7}', b'{"order":"\xd2"}',
    b'{"phase":"\xff\xfe"}', b'{"x":' + b"[" * 100_000, b'{"order":"goto","position":[1e300,0,0]}',
)  # fmt: skip


class Vandal:
    """Damages what it overhears and sends it on, under its own key or another's."""

    def __init__(self, first_port: int, router: str) -> None:
        self._draw = random.Random(1)
        self._bus = ZenohBus(router, "small", wait_s=10.0)
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._ports = range(first_port, first_port + len(AGENTS))
        self._heard = self._bus.subscribe("**")
        self._overheard: list[tuple[str, bytes]] = []

    def spray(self) -> None:
        """One handful."""
        draw, stranger = self._draw, Encoder(77)
        for port in self._ports:
            good = stranger.pack("HEARTBEAT", mavlink_version=3, autopilot=12)
            for data in (b"", draw.randbytes(draw.randrange(400)), self._damaged(good), good):
                self._udp.sendto(data, ("127.0.0.1", port))
        self._overheard = (self._overheard + list(self._heard.drain()))[-300:]
        for key, data in draw.sample(self._overheard, min(10, len(self._overheard))):
            self._bus.publish(key, self._damaged(data))
            space, _, _ = key.rpartition("/")
            if space.startswith(("air", "safety")) or space == "state":
                self._bus.publish(f"{space}/{draw.choice((5, 99, 4_000_000_000))}", data)
        for key in (keys.cmd(), keys.cmd(1), keys.state(2), keys.state_map(1), keys.obs(3)):
            self._bus.publish(key, draw.choice(BAD_TEXTS))
            self._bus.publish(key, draw.randbytes(draw.randrange(60)))

    def _damaged(self, data: bytes) -> bytes:
        """Cut short, or with a wrong first byte: not a message any more."""
        if self._draw.random() < 0.5:
            return data[: self._draw.randrange(len(data))] if data else b""
        return b"\x00" + data[1:]

    def close(self) -> None:
        self._udp.close()
        self._bus.close()


def test_a_mission_flies_on_through_garbage(tmp_path):
    router, first, out = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}", 31540, tmp_path / "out"
    text = SMALL + f'\n[bus]\nlisten = "{router}"\n[simulator]\nports = {first}\n'
    mission = write(tmp_path, text)
    arguments = ("--clock", "paced", "--speed", "5", "--duration", "40", "--json", "--out", out)
    command = [sys.executable, "-m", "uavbridge", "launch", mission, *arguments]
    with subprocess.Popen(
        [str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as flight:
        vandal = Vandal(first, router)
        with suppress(BusError):  # the flight is over
            while flight.poll() is None:
                vandal.spray()
                time.sleep(0.02)
        vandal.close()
        printed, said = flight.communicate(timeout=60)
    assert "Traceback" not in said
    assert printed.startswith("{"), said
    summary = document(subprocess.CompletedProcess(command, flight.returncode, printed, said))
    assert summary["failures"] == []
    assert {agent["state"] for agent in summary["agents"]} == {"landed"}
    assert [agent["id"] for agent in summary["agents"]] == list(AGENTS)
    assert summary["min_separation_m"] > 5.0
    assert Recording(out).complete
    assert Recording(out).digest() == summary["digest"]
