"""Who gets which id and port."""

import pytest

from sim_vehicles.ports import Seat, ServerError, resolve, seats


def test_up_to_ten_have_a_port_each_as_px4_does():
    assert seats(10) == tuple(Seat(i + 1, 14540 + i) for i in range(10))


def test_more_than_ten_share_one():
    assert seats(11) == tuple(Seat(i + 1, 14540) for i in range(11))
    assert {seat.port for seat in seats(3, each=False)} == {14540}


def test_ids_repeat_only_on_another_port():
    found = seats(1000)
    assert len(set(found)) == 1000
    assert {seat.port for seat in found} == {14540, 14541, 14542, 14543}
    assert max(seat.system for seat in found) == 250
    late = seats(600, start_system=200)
    assert len(set(late)) == 600
    assert {seat.system for seat in late} == set(range(200, 251))


@pytest.mark.parametrize("each", [True, False])
def test_the_ground_station_s_port_stays_free(each):
    taken = {seat.port for seat in seats(5000 if not each else 60, each=each)}
    assert 14550 not in taken
    assert seats(1, base=14550)[0].port == 14550  # unless asked for


@pytest.mark.parametrize(
    ("count", "options"),
    [(2, {"base": 65535, "each": True}), (1, {"base": 0}), (1, {"start_system": 251})],
)
def test_what_does_not_exist_is_refused(count, options):
    with pytest.raises(ValueError, match="must be 1"):
        seats(count, **options)


def test_unknown_hosts_are_named():
    with pytest.raises(ServerError, match=r"no\.such\.host\.invalid"):
        resolve("no.such.host.invalid")
