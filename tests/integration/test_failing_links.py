"""Missions whose bridge, links or vehicles fail, on real sockets."""

import re
import time
from contextlib import contextmanager

import numpy as np
import pytest

from tests.integration.bridge import HOLD, RTL, Pilot, bridge
from tests.integration.missions import SMALL, document, launch, write
from tests.integration.relay import relay
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


@contextmanager
def over_a_relay(tmp_path, text=LONG, *arguments):
    """A vehicle behind a bad link, and the bridge that flies it."""
    port = free_port()
    with (
        relay(port) as bad,
        simulator(*SPEED, port=bad.port),
        bridge(
            tmp_path / "o", write(tmp_path, text), "--vehicles", 1,
            "--connect", f"udpin:127.0.0.1:{port}", *arguments,
        ) as flown,
    ):  # fmt: skip
        yield bad, flown


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


def test_a_third_lost_and_the_rest_doubled_reordered_and_corrupted(tmp_path):
    port = free_port()
    with relay(port) as bad, simulator("--speed", "4", port=bad.port):
        bad.loss, bad.trouble = 0.3, 0.4
        done = launch(
            write(tmp_path), "--vehicles", 1, "--connect", f"udpin:127.0.0.1:{port}",
            "--duration", 25, "--json", "--out", tmp_path / "o",
        )  # fmt: skip
    assert [agent["state"] for agent in document(done)["agents"]] == ["landed"], done.stderr
    assert document(done)["failures"] == []


def test_lost_acknowledgements_are_asked_for_again(tmp_path):
    with over_a_relay(tmp_path, SMALL, "--duration", 15) as (bad, flown):
        bad.swallows = {"COMMAND_ACK": 6, "PARAM_VALUE": 3}
        summary = flown.end()
        assert not any(bad.swallows.values())
    assert [agent["state"] for agent in summary["agents"]] == ["landed"]
    assert summary["failures"] == []


def test_a_vehicle_that_falls_silent_costs_only_itself_and_comes_home(tmp_path):
    port = free_port()
    with (
        relay(port) as bad,
        simulator(*SPEED, "--start-system", "7", port=bad.port),
        simulator("--tcp", *SPEED) as other,
        bridge(
            tmp_path / "o", write(tmp_path), "--vehicles", 2, "--duration", 60,
            "--connect", f"udpin:127.0.0.1:{port}", "--connect", tcp(other),
        ) as flown,
    ):  # fmt: skip
        flown.until("agent 1: search")
        bad.down = True
        flown.until("agent 1: vehicle silent for")
        summary = flown.end()
    states = [agent["state"] for agent in summary["agents"]]
    assert states == ["failed", "landed"]
    assert len(summary["failures"]) == 1


def test_offboard_that_drops_out_is_yielded_not_taken_back(tmp_path):
    with over_a_relay(tmp_path) as (bad, flown):
        flown.until("agent 1: search")
        bad.deaf = True  # our setpoints do not arrive, its telemetry does
        flown.until("agent 1: vehicle went to AUTO.LOITER: yielded")
        bad.deaf = False
        time.sleep(1.0)
        assert flown.command("takeover", "--agent", 1)[0]["ok"]
        flown.interrupt()  # Ctrl-C: home, and the net put back
        summary = flown.end()
    assert [agent["state"] for agent in summary["agents"]] == ["landed"]


@pytest.mark.soak
def test_a_reboot_in_flight_is_told(tmp_path):
    port = free_port()
    with (
        relay(port) as before,
        relay(port) as after,
        simulator(*SPEED, port=before.port),
        bridge(
            tmp_path / "o", write(tmp_path, LONG), "--vehicles", 1,
            "--connect", f"udpin:127.0.0.1:{port}",
        ) as flown,
    ):  # fmt: skip
        after.down = True
        flown.until("agent 1: climb")
        with simulator(*SPEED, port=after.port):  # the same vehicle, just switched on
            flown.until("agent 1: search")
            before.down, after.down = True, False
            flown.until("agent 1: vehicle says: system 1 has restarted")
            summary = flown.end()
    assert "yielded" in summary["failures"][0]


@pytest.mark.soak
def test_a_low_battery_is_the_autopilots_business_and_told(tmp_path):
    with simulator("--tcp", *SPEED) as sim, bridge(
        tmp_path / "o", write(tmp_path, LONG), "--vehicles", 1, "--connect", tcp(sim)
    ) as flown:  # fmt: skip
        pilot = Pilot(sim.port)
        flown.until("agent 1: search")
        pilot.set("BAT_LOW_THR", 0.9999)
        pilot.set("BAT_CRIT_THR", 0.9998)
        flown.until("vehicle says: Critical battery level", "AUTO.LOITER: yielded")
        pilot.until(lambda me: me.flown_mode == RTL)
        summary = flown.end()
        pilot.close()
    assert [agent["state"] for agent in summary["agents"]] == ["landed"]


def test_a_twin_in_flight_is_named_and_not_listened_to(tmp_path):
    port = free_port()
    with simulator(*SPEED, port=port), bridge(
        tmp_path / "o", write(tmp_path, LONG), "--vehicles", 1,
        "--connect", f"udpin:127.0.0.1:{port}",
    ) as flown:  # fmt: skip
        flown.until("agent 1: search")
        with simulator(*SPEED, port=port):
            flown.until("two vehicles have system id 1")
            assert len(set(re.findall(r"127\.0\.0\.1:\d+ and 127\.0\.0\.1:\d+", flown.text))) == 1
            flown.interrupt()
            summary = flown.end()
    assert [agent["state"] for agent in summary["agents"]] == ["landed"]


@pytest.mark.soak
def test_a_lost_position_ends_in_a_landing(tmp_path):
    with over_a_relay(tmp_path) as (bad, flown):
        flown.until("agent 1: search")
        bad.without = frozenset({"LOCAL_POSITION_NED", "GLOBAL_POSITION_INT"})
        flown.until("agent 1: vehicle lost its position: it lands")
        summary = flown.end()
    assert [agent["state"] for agent in summary["agents"]] == ["landed"]
    assert "lost its position" in summary["failures"][0]


def test_what_can_not_be_resumed_is_said(tmp_path):
    done = launch("--resume", tmp_path / "none")
    assert done.returncode == 2
    assert "none" in done.stderr
    short = ("--duration", 1, "--clock", "stepped", "--out", tmp_path / "o")
    launch(write(tmp_path), *short)
    done = launch("--resume", tmp_path / "o")
    assert done.returncode == 2
    assert "simulated vehicles ended with their bridge" in " ".join(done.stderr.split())
    done = launch(write(tmp_path), "--resume", tmp_path / "o")
    assert done.returncode == 2
    assert "--resume" in done.stderr
