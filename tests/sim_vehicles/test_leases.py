"""Two simulators of one machine take neither the same ports nor the same ids."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from sim_vehicles.leases import Leases, lease_seats, lease_systems
from sim_vehicles.ports import Seat, ServerError


def test_neighbours_get_their_own_ports_and_ids(tmp_path: Path) -> None:
    one, two, three = (Leases(tmp_path) for _ in range(3))
    first = lease_seats(3, one)
    second = lease_seats(12, two)
    third = lease_seats(2, three, start_system=100)
    assert [(seat.system, seat.port) for seat in first] == [(1, 14540), (2, 14541), (3, 14542)]
    assert [seat.system for seat in second] == list(range(4, 16))
    assert {seat.port for seat in second} == {14543}  # shared
    assert [(seat.system, seat.port) for seat in third] == [(100, 14544), (101, 14545)]
    one.close()
    assert lease_seats(2, Leases(tmp_path))[0].port == 14540
    for leases in (two, three):
        leases.close()


def test_what_is_asked_for_by_number_is_kept_from_the_others(tmp_path: Path) -> None:
    asked, other, twin = (Leases(tmp_path) for _ in range(3))
    assert _pairs(lease_seats(1, asked, port=14540, start_system=2)) == [(2, 14540)]
    assert _pairs(lease_seats(2, other)) == [(3, 14541), (4, 14542)]
    assert _pairs(lease_seats(1, twin, port=14540, start_system=2)) == [(2, 14540)]
    assert _pairs(lease_seats(1, twin, port=14600)) == [(1, 14600)]
    for leases in (asked, other, twin):
        leases.close()


def test_vehicles_with_ports_of_their_own_get_ids_of_their_own(tmp_path: Path) -> None:
    one, two, three = (Leases(tmp_path) for _ in range(3))
    assert lease_systems([2, 5], one) == {2: 2, 5: 5}
    assert lease_systems([5, 6, 7], two) == {5: 6, 6: 7, 7: 8}
    assert lease_systems(range(1, 249), three) == {i: i for i in range(1, 249)}  # none left
    assert lease_systems([], three) == {}
    for leases in (one, two):
        leases.close()


def _pairs(found: tuple[Seat, ...]) -> list[tuple[int, int]]:
    return [(seat.system, seat.port) for seat in found]


def test_all_or_nothing(tmp_path: Path) -> None:
    one, two = Leases(tmp_path), Leases(tmp_path)
    assert one.take(["b"])
    assert not two.take(["a", "b"])
    assert one.take(["a"])
    one.close()
    assert two.take(["a", "b"])
    two.close()


def test_a_killed_process_holds_nothing(tmp_path: Path) -> None:
    code = (
        "import sys, time; from pathlib import Path; from sim_vehicles.leases import Leases\n"
        "held = Leases(Path(sys.argv[1])); print(held.take(['y']), flush=True); time.sleep(60)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "True\n"
        assert not Leases(tmp_path).take(["y"])
        process.kill()
    assert Leases(tmp_path).take(["y"])


def test_when_none_are_left_it_is_said(tmp_path: Path) -> None:
    one = Leases(tmp_path)
    lease_seats(200, one)
    with pytest.raises(ServerError, match="no 60 system ids in a row"):
        lease_seats(60, Leases(tmp_path))
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(ServerError, match="file"):
        Leases(blocked).take(["x"])
    one.close()
