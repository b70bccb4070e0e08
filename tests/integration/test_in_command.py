"""Who has the vehicle: its pilot, its autopilot's own net, or the bridge."""

import struct

import pytest

from tests.integration.bridge import HOLD, RTL, Pilot, bridge
from tests.integration.missions import SMALL, write
from tests.integration.simulator import simulator

pytestmark = pytest.mark.integration
LONG = (
    SMALL.replace("duration = 200.0", "duration = 2000.0")
    .replace('planner = "sweep"', 'planner = "random"')
    .replace("position = [125.0, 175.0]", "position = [199.0, 1.0]")
)
SPEED = ("--speed", "5")


def whole(wire):
    """A whole parameter of PX4's, which travels as bits."""
    return struct.unpack("<i", struct.pack("<f", wire))[0]


def test_a_pilots_mode_is_left_alone_until_an_operator_says_so(tmp_path):
    with simulator("--tcp", *SPEED) as sim, bridge(
        tmp_path / "o", write(tmp_path, LONG), "--vehicles", 1,
        "--connect", f"tcp:127.0.0.1:{sim.port}",
    ) as flown:  # fmt: skip
        pilot = Pilot(sim.port)
        before = {name: pilot.ask(name) for name in ("GF_MAX_HOR_DIST", "COM_OF_LOSS_T")}
        assert whole(pilot.ask("NAV_DLL_ACT")) == 0
        flown.until("agent 1: search")
        assert pilot.ask("GF_MAX_HOR_DIST") > 100.0  # the mission's net is set
        assert whole(pilot.ask("NAV_DLL_ACT")) == 2
        assert whole(pilot.ask("COM_OBL_RC_ACT")) == 5
        pilot.mode(*HOLD)
        flown.until("agent 1: vehicle went to AUTO.LOITER: yielded")
        place = (pilot.newest["LOCAL_POSITION_NED"].x, pilot.newest["LOCAL_POSITION_NED"].y)
        pilot.look(3.0)
        assert pilot.flown_mode == HOLD
        there = pilot.newest["LOCAL_POSITION_NED"]
        assert abs(there.x - place[0]) + abs(there.y - place[1]) < 40.0
        assert flown.command("takeover", "--agent", 1)[0]["ok"]
        pilot.until(lambda me: me.flown_mode[0] == 6)
        pilot.mode(*RTL)
        pilot.until(lambda me: me.flown_mode == RTL)
        pilot.until(lambda me: not me.armed, limit_s=60.0)
        assert "takeover" in flown.text
        summary = flown.end()
        assert [agent["state"] for agent in summary["agents"]] == ["landed"]
        assert "AUTO.RTL: yielded" in summary["failures"][0]
        assert {name: pilot.ask(name) for name in before} == before  # and put back
        assert whole(pilot.ask("NAV_DLL_ACT")) == 0
        assert whole(pilot.ask("GF_ACTION")) == 2
        pilot.close()
