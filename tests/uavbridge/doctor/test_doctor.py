"""What the doctor says, without anybody on the table."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from uavbridge.config import load
from uavbridge.doctor import examine
from uavbridge.doctor.bites import BITES
from uavbridge.doctor.clock import clock_finding, of_kernel
from uavbridge.doctor.finding import Level
from uavbridge.doctor.ports import holders, port_finding
from uavbridge.mavlink.ardupilot import ARDUCOPTER, ARDUPLANE, ARDUROVER
from uavbridge.mavlink.flavour import PX4


def test_every_flavour_has_its_parameters_that_bite() -> None:
    assert set(BITES) == {each.name for each in (PX4, ARDUCOPTER, ARDUROVER, ARDUPLANE)}
    for bites in BITES.values():
        assert all(len(bite.name) <= 16 and bite.remedy for bite in bites)


@pytest.mark.parametrize(
    ("flavour", "name", "value", "level"),
    [
        ("PX4", "COM_ARM_MIS_REQ", 1.0, Level.ERROR),
        ("PX4", "MPC_XY_VEL_MAX", 3.0, Level.WARNING),
        ("PX4", "MPC_XY_VEL_MAX", 12.0, None),
        ("ArduCopter", "FRAME_CLASS", 0.0, Level.ERROR),
        ("ArduCopter", "WPNAV_SPEED", 500.0, Level.WARNING),
        ("ArduCopter", "WPNAV_SPEED", 1000.0, None),
        ("ArduPlane", "RTL_AUTOLAND", 0.0, Level.WARNING),
    ],
)
def test_values_that_spoil_the_example_are_named(
    flavour: str, name: str, value: float, level: Level | None
) -> None:
    mission = load()
    found = [b.level for b in BITES[flavour] if b.name == name and b.bites(value, mission)]
    assert found == ([] if level is None else [level])


def test_a_mission_with_simulated_vehicles_could_fly() -> None:
    diagnosis = examine(load())
    assert diagnosis.ready
    assert {finding.level for finding in diagnosis.findings} == {Level.OK}
    assert diagnosis.lines()[-1] == "mission liu2022 could fly now"


def test_a_router_that_is_not_there_and_a_port_that_is_taken() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken, socket.create_server(
        ("127.0.0.1", 0)
    ) as closed:  # fmt: skip
        taken.bind(("127.0.0.1", 0))
        port, router = taken.getsockname()[1], closed.getsockname()[1]
        closed.close()
        changes = {"bus.router": f"tcp/127.0.0.1:{router}", "simulator.ports": port, "vehicles": 1}
        diagnosis = examine(load(None, changes))
        assert not diagnosis.ready
        wrong = {f.subject: f for f in diagnosis.findings if f.level is Level.ERROR}
        assert f"pid {os.getpid()}" in wrong[f"udp port {port}"].text
        assert "uavbridge router" in wrong["router"].remedy
    assert port_finding("udp", "127.0.0.1", port, "x").level is Level.OK


def test_an_address_of_another_machine_is_not_called_taken() -> None:
    found = port_finding("udp", "192.0.2.1", 14540, "x")
    assert found.level is Level.ERROR
    assert "192.0.2.1" in found.text
    assert "taken" not in found.text
    assert "of this machine" in found.remedy


def test_the_machines_clock_counts_where_there_are_several() -> None:
    assert of_kernel(0x40, 0).level is Level.WARNING
    assert of_kernel(0x1, 300_000).level is Level.WARNING
    assert of_kernel(0x1, 20_000).level is Level.OK
    assert clock_finding().subject == "clock"
    alone = examine(load())
    assert "clock" not in {finding.subject for finding in alone.findings}


def test_a_holder_is_found_by_its_socket(tmp_path: Path) -> None:
    (tmp_path / "net").mkdir()
    head = "  sl  local_address rem_address st tx rx tr tm retrnsmt uid timeout inode\n"
    row = "  1: 0100007F:38CC 00000000:0000 {} 0:0 0:0 0 0 0 {} 2 0 0\n"
    (tmp_path / "net" / "udp").write_text(head + row.format("07", 4711))
    (tmp_path / "net" / "tcp").write_text(head + row.format("01", 4711))  # not one that listens
    descriptors = tmp_path / "123" / "fd"
    descriptors.mkdir(parents=True)
    (tmp_path / "123" / "comm").write_text("qgroundcontrol\n")
    (descriptors / "9").symlink_to("socket:[4711]")
    (descriptors / "10").symlink_to("/dev/null")
    assert holders("udp", 14540, tmp_path) == ["qgroundcontrol (pid 123)"]
    assert holders("tcp", 14540, tmp_path) == []
    assert holders("udp", 14541, tmp_path) == []
