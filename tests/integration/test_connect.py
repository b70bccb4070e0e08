"""Missions flown with vehicles that the bridge did not simulate: ours, started by hand."""

import re

import pytest

from tests.integration.missions import SMALL, document, launch, write
from tests.integration.simulator import free_port, simulator

pytestmark = pytest.mark.integration
SPEED = ("--speed", "8")


def url(port, kind="udpin"):
    return f"{kind}:127.0.0.1:{port}"


def states(done):
    return [agent["state"] for agent in document(done)["agents"]]


def test_vehicles_of_other_ids_on_one_port_fly_beside_simulated_ones(tmp_path):
    with simulator("--count", "2", "--ports", "shared", "--start-system", "7", *SPEED) as sim:
        done = launch(
            write(tmp_path, SMALL), "--vehicles", 3, "--json", "--out", tmp_path / "o",
            "--connect", f"udp://127.0.0.1:{sim.port}", "--connect", url(sim.port),
        )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert states(done) == ["landed"] * 3
    told = " ".join(done.stderr.split())
    assert f"agent 1: {url(sim.port)}, system 7: PX4" in told
    assert f"agent 2: {url(sim.port)}, system 8: PX4" in told
    assert "10 m east" in told
    flown = (tmp_path / "o" / "mission.toml").read_text()
    assert flown.count("endpoint") == 2
    speed = re.search(r"^speed = ([\d.]+)$", flown, re.MULTILINE)
    assert speed is not None
    assert 5.0 < float(speed[1]) < 11.0  # 8, that of the vehicles' clocks, as measured


@pytest.mark.soak
def test_without_a_mission_the_example_is_flown_at_the_first_vehicles_home(tmp_path):
    home = "-35.363262,149.165237,584"
    with simulator("--count", "2", "--spacing", "30", "--home", home, "--tcp", *SPEED) as sim:
        done = launch(
            "--connect", url(sim.port, "tcp"), "--connect", f"tcpout://127.0.0.1:{sim.port + 1}",
            "--duration", 45, "--json", "--out", tmp_path / "o",
        )  # fmt: skip
    assert done.returncode == 1  # no goal in so short a time
    assert states(done) == ["landed"] * 2
    assert document(done)["failures"] == []
    flown = (tmp_path / "o" / "mission.toml").read_text()
    assert re.search(r"latitude_deg = -35\.36326", flown)
    assert re.search(r"altitude_m = 58[34]", flown)


def test_a_home_too_far_away_or_too_high_is_an_error_before_anything_arms(tmp_path):
    for home, word in (("47.45,8.545594,488", "5.8 km"), ("47.3977,8.5455,560", "72 m above")):
        with simulator("--home", home, *SPEED) as sim:
            done = launch(write(tmp_path), "--connect", url(sim.port), "--out", tmp_path / "o")
        assert done.returncode != 0
        assert word in done.stderr
        assert "agent 1" in done.stderr
        assert "Traceback" not in done.stderr
        assert not (tmp_path / "o").exists()


def test_one_system_id_twice_is_an_error_that_names_both(tmp_path):
    port = free_port()
    with simulator(*SPEED, port=port), simulator(*SPEED, port=port):
        done = launch(write(tmp_path), "--connect", url(port))
    assert done.returncode != 0
    sources = re.findall(r"from 127\.0\.0\.1:\d+", done.stderr)
    assert "two vehicles have system id 1" in " ".join(done.stderr.split())
    assert len(set(sources)) == 2


def test_one_system_id_on_two_ports_is_an_error_too(tmp_path):
    with simulator(*SPEED) as one, simulator(*SPEED) as other:
        done = launch(write(tmp_path), "--connect", url(one.port), "--connect", url(other.port))
        text = " ".join(done.stderr.split())
    assert done.returncode != 0
    assert "two vehicles have system id 1" in text
    assert url(one.port) in text
    assert url(other.port) in text


def test_a_clock_of_another_speed_is_said(tmp_path):
    with simulator(*SPEED) as sim:
        done = launch(write(tmp_path), "--connect", url(sim.port), "--speed", 1)
    assert done.returncode == 2
    assert "give --speed 8" in " ".join(done.stderr.split())


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--connect", "carrier-pigeon:home"), "unknown kind of link"),
        (("--connect", "udpin:127.0.0.1:x"), "port"),
        (("--vehicles", 1, "--connect", "udpin::14540", "--connect", "udpin::14541"), "2 URLs"),
        (("--connect", "udpin::0", "--clock", "stepped"), "stepped"),
    ],
)
def test_bad_connections_are_exit_status_2(tmp_path, arguments, word):
    done = launch(write(tmp_path), *arguments)
    assert done.returncode == 2
    assert word in done.stderr
