"""A mission's own vehicles beside the other simulators of the machine."""

from __future__ import annotations

from pathlib import Path

import pytest

from sim_vehicles.leases import Leases, lease_seats
from uavbridge.errors import BusError, LinkError
from uavbridge.runner.leased import Leased


def test_ids_and_ports_are_nobody_elses(tmp_path: Path) -> None:
    other = Leases(tmp_path)
    lease_seats(2, other)
    with Leased([1, 2, 3], leases=Leases(tmp_path)) as leased:
        assert leased.systems == {1: 3, 2: 4, 3: 5}
        assert leased.keep(14542) == 14542
        with pytest.raises(LinkError, match=r"UDP port 14541 is another simulator's \(pid \d+\)"):
            leased.keep(14541)
        other.close()
        assert [seat.port for seat in lease_seats(2, other)] == [14540, 14541]
        assert [seat.port for seat in lease_seats(2, other)] == [14543, 14544]
    other.close()


def test_without_a_folder_for_leases_a_mission_flies(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with Leased([1, 2], leases=Leases(tmp_path / "file" / "leases")) as leased:
        assert leased.systems == {1: 1, 2: 2}
        assert leased.keep(14540) == 14540


def test_a_name_flies_once_at_a_router(tmp_path: Path) -> None:
    router = "tcp/127.0.0.1:7447"
    with Leased([1], (router, "liu"), Leases(tmp_path)):
        with pytest.raises(BusError, match=r"bus.router: a mission liu flies at tcp.*\(pid \d+\)"):
            Leased([1], (router, "liu"), Leases(tmp_path))
        with Leased([1], (router, "other"), Leases(tmp_path)) as other:
            assert other.systems == {1: 2}
        Leased([1], ("tcp/127.0.0.1:7448", "liu"), Leases(tmp_path))
