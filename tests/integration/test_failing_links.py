"""Missions whose bridge, links or vehicles fail, on real sockets."""

import socket
import threading
import time

import numpy as np
import pytest

from tests.integration.bridge import HOLD, RTL, Pilot, bridge
from tests.integration.missions import SMALL, document, launch, write
from tests.integration.simulator import free_port, simulator

pytestmark = pytest.mark.integration
LONG = (
    SMALL.replace("duration = 200.0", "duration = 2000.0")
    .replace('planner = "sweep"', 'planner = "random"')
    .replace("position = [125.0, 175.0]", "position = [199.0, 1.0]")
)
SPEED = ("--speed", "5")


def tcp(sim, index=0):
    return f"tcp:127.0.0.1:{sim.port + index}"


def test_a_killed_bridge_is_followed_by_one_that_goes_on(tmp_path):
    """Vehicles hold, then return; a new bridge takes them over in flight."""
    out = tmp_path / "o"
    with simulator("--tcp", "--spacing", "40", "--count", "2", *SPEED) as sim:
        urls = ("--connect", tcp(sim), "--connect", tcp(sim, 1), "--vehicles", 2)
        pilot = Pilot(sim.port)
        with bridge(out, write(tmp_path), *urls, "--duration", 120) as flown:
            flown.until("agent 1: search", "agent 2: search")
            time.sleep(2.0)
            flown.kill()
        pilot.until(lambda me: me.flown_mode == HOLD)
        pilot.until(lambda me: me.flown_mode == RTL)
        with bridge(None, "--resume", out) as again:
            again.until("agent 1: takes over", "agent 2: takes over")
            pilot.until(lambda me: me.flown_mode[0] == 6)
            again.out = out
            summary = again.end()
        assert [agent["state"] for agent in summary["agents"]] == ["landed"] * 2
        assert summary["failures"] == []
        assert summary["coverage"] > 0.5
        pilot.look(1.0)
        position = pilot.newest["LOCAL_POSITION_NED"]
        assert abs(position.x) + abs(position.y) < 5.0  # home, not the start of the search
        assert int(np.frombuffer(np.float32(pilot.ask("NAV_DLL_ACT")).tobytes(), "i4")[0]) == 0
        pilot.close()
    assert (out / "mission-2.mcap").exists()
