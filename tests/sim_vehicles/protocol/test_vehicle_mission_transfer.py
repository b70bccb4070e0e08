from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic

LAT, LON = 473977420, 85455940
ACCEPTED, UNSUPPORTED, INVALID_SEQUENCE, CANCELLED = 0, 3, 13, 15


def item(seq, command=16, frame=6, x=LAT, y=LON, z=10.0, p1=0.0, kind=0):
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, seq, frame, command, 0, 1, p1, 0.0, 0.0, float("nan"), x, y, z, kind
    )


def answer(gcs, items, fresh):
    """Do as a ground station does; the result once it is there."""
    for message in fresh:
        name = message.get_type()
        if name == "MISSION_REQUEST_INT" and message.mission_type == items[0].mission_type:
            gcs.send(items[message.seq])
        elif name == "MISSION_ACK":
            return message.type
    return None


def upload(gcs, items, patience_s=1.0):
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, len(items), items[0].mission_type))
    end = gcs.fleet.now_us + patience_s * 1e6
    while gcs.fleet.now_us < end:
        result = answer(gcs, items, gcs.collect())
        if result is not None:
            return result
        gcs.fleet.advance(gcs.fleet.now_us + 20_000)
    return None


def download(gcs, kind=0, integer=True):
    gcs.send(mavlink.MAVLink_mission_request_list_message(1, 1, kind))
    gcs.collect()
    items = []
    request = (
        mavlink.MAVLink_mission_request_int_message
        if integer
        else mavlink.MAVLink_mission_request_message
    )
    for seq in range(gcs.newest("MISSION_COUNT").count):
        gcs.send(request(1, 1, seq, kind))
        items.extend(each for each in gcs.collect() if each.get_type().startswith("MISSION_ITEM"))
    gcs.send(mavlink.MAVLink_mission_ack_message(1, 1, 0, kind))
    return items


@pytest.mark.parametrize(
    ("kind", "command"), [(0, 16), (1, 5003), (2, 5100)], ids=["mission", "fence", "rally"]
)
def test_up_and_down_again(station, kind, command):
    gcs = station()
    items = [item(k, command, x=LAT + 100 * k, p1=5.0, kind=kind) for k in range(5)]
    assert upload(gcs, items) == ACCEPTED
    back = download(gcs, kind)
    assert len(back) == 5
    for sent, got in zip(items, back, strict=True):
        assert got.get_type() == "MISSION_ITEM_INT"
        assert (got.seq, got.command, got.frame, got.x, got.y, got.z, got.param1) == (
            sent.seq, sent.command, sent.frame, sent.x, sent.y, sent.z, sent.param1,
        )  # fmt: skip
    floats = download(gcs, kind, integer=False)
    assert floats[1].get_type() == "MISSION_ITEM"
    assert floats[1].x == pytest.approx((LAT + 100) * 1e-7, abs=1e-5)
    for other in {0, 1, 2} - {kind}:
        assert download(gcs, other) == []


def test_float_items_are_taken_too(station):
    gcs = station()
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    gcs.send(
        mavlink.MAVLink_mission_item_message(
            1, 1, 0, 3, 16, 0, 1, 0, 0, 0, 0, LAT * 1e-7, LON * 1e-7, 20.0, 0
        )
    )
    assert gcs.collect()[-1].type == ACCEPTED
    (got,) = download(gcs)
    assert got.x == pytest.approx(LAT, abs=20)


@pytest.mark.parametrize(
    ("bad", "result"),
    [
        ({"command": 20}, UNSUPPORTED),  # PX4 wants it in the frame MISSION
        ({"command": 16, "frame": 2}, UNSUPPORTED),
        ({"command": 31000}, UNSUPPORTED),
        ({"frame": 10}, 2),  # terrain
        ({"x": 910_000_000}, 10),
        ({"y": 1_810_000_000}, 11),
        ({"z": 1e9}, 12),
        ({"command": 177, "frame": 2, "p1": 9.0}, 5),  # jump to nowhere
        ({"command": 5100}, UNSUPPORTED),
    ],
)
def test_bad_items_are_refused_and_the_old_mission_stays(station, bad, result):
    gcs = station()
    assert upload(gcs, [item(0)]) == ACCEPTED
    if result == 12:
        result = mavlink.MAV_MISSION_INVALID_PARAM7
    if result == 5:
        result = mavlink.MAV_MISSION_INVALID_PARAM1
    if result == 10:
        result = mavlink.MAV_MISSION_INVALID_PARAM5_X
    if result == 11:
        result = mavlink.MAV_MISSION_INVALID_PARAM6_Y
    assert upload(gcs, [item(0), item(1, **bad)]) == result
    assert len(download(gcs)) == 1


def test_clear(station):
    gcs = station()
    upload(gcs, [item(0)])
    upload(gcs, [item(0, 5100, kind=2)])
    gcs.send(mavlink.MAVLink_mission_clear_all_message(1, 1, 0))
    assert gcs.collect()[-1].type == ACCEPTED
    assert download(gcs) == []
    assert len(download(gcs, 2)) == 1
    gcs.send(mavlink.MAVLink_mission_clear_all_message(1, 1, 255))
    gcs.collect()
    assert download(gcs, 2) == []
    assert gcs.command(300) == 1


def test_an_empty_upload_clears(station):
    gcs = station()
    upload(gcs, [item(0)])
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, 0, 0))
    assert gcs.collect()[-1].type == ACCEPTED
    assert download(gcs) == []


def test_requests_are_repeated_then_given_up(station):
    gcs = station()
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    gcs.fly(6)
    requests = gcs.all("MISSION_REQUEST_INT")
    assert 15 <= len(requests) <= 22
    assert {each.seq for each in requests} == {0}
    assert gcs.newest("MISSION_ACK").type == CANCELLED
    count = len(requests)
    gcs.fly(2)
    assert len(gcs.all("MISSION_REQUEST_INT")) == count


def test_the_last_acknowledgement_is_repeated(station):
    gcs = station()
    items = [item(0), item(1)]
    assert upload(gcs, items) == ACCEPTED
    gcs.send(items[1])
    assert gcs.collect()[-1].type == ACCEPTED
    gcs.send(items[0])
    assert not gcs.collect()


def test_another_station_waits_its_turn(station):
    gcs = station()
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    gcs.collect()
    gcs.mav.srcComponent = 77
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
    assert gcs.collect()[-1].type == mavlink.MAV_MISSION_DENIED


def test_odd_requests(station):
    gcs = station()
    gcs.send(mavlink.MAVLink_mission_request_int_message(1, 1, 4, 0))
    assert gcs.collect()[-1].type == INVALID_SEQUENCE
    gcs.send(mavlink.MAVLink_mission_count_message(1, 1, 60_000, 0))
    assert gcs.collect()[-1].type == mavlink.MAV_MISSION_NO_SPACE
    for message in (
        mavlink.MAVLink_mission_count_message(1, 1, 1, 9),
        mavlink.MAVLink_mission_request_list_message(1, 1, 9),
        mavlink.MAVLink_mission_clear_all_message(1, 1, 9),
        mavlink.MAVLink_mission_request_partial_list_message(1, 1, 0, 1, 0),
        mavlink.MAVLink_mission_write_partial_list_message(1, 1, 0, 1, 0),
    ):
        gcs.send(message)
        assert gcs.collect()[-1].type == UNSUPPORTED


class Lossy:
    """Loses datagrams both ways, and may give the vehicle single wrong bytes."""

    def __init__(self, gcs, rng, loss, corrupt=0.0):
        self._rng, self._loss, self._corrupt = rng, loss, corrupt
        self._gcs, self._pass_on = gcs, gcs.send
        gcs.drop = lambda: rng.random() < loss
        gcs.send = self.send

    def send(self, message):
        data = bytearray(message.pack(self._gcs.mav))
        if self._rng.random() < self._loss:
            return
        if self._rng.random() < self._corrupt:
            data[self._rng.integers(len(data))] ^= 1 << int(self._rng.integers(8))
        self._gcs.fleet.receive(self._gcs.index, bytes(data))


def patient_upload(gcs, items):
    """Repeats what a ground station repeats: the count, and the last item."""
    for attempt in range(40):
        if attempt == 0 or not gcs.all("MISSION_REQUEST_INT"):
            gcs.send(mavlink.MAVLink_mission_count_message(1, 1, len(items), 0))
        elif gcs.newest("MISSION_REQUEST_INT").seq == len(items) - 1:
            gcs.send(items[-1])
        end = gcs.fleet.now_us + 1_500_000
        while gcs.fleet.now_us < end:
            result = answer(gcs, items, gcs.collect())
            if result == ACCEPTED:
                return True
            gcs.fleet.advance(gcs.fleet.now_us + 100_000)
    return False


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("loss", "corrupt"), [(0.05, 0.0), (0.3, 0.0), (0.1, 0.3)])
def test_upload_over_a_lossy_link(station, seed, loss, corrupt):
    gcs = station()
    items = [item(k, x=LAT + k, z=10.0 + k) for k in range(12)]
    lossy = Lossy(gcs, np.random.default_rng(seed), loss, corrupt)
    assert patient_upload(gcs, items)
    if corrupt:
        assert gcs.fleet.counts[0].garbage > 0
    gcs.drop, gcs.send = (lambda: False), lossy._pass_on
    assert [(each.x, each.z) for each in download(gcs)] == [(each.x, each.z) for each in items]


@given(st.integers(0, 2**32), st.lists(st.integers(0, 8), max_size=30))
@settings(max_examples=30)
def test_any_order_of_messages_leaves_a_whole_mission_or_the_old_one(seed, events):
    fleet = Fleet([VehicleSpec(1, (0, 0, 0))], origin=Geodetic(47.0, 8.0, 400.0), model="perfect")
    mav = mavlink.MAVLink(None, 255, 190)
    rng = np.random.default_rng(seed)
    for event in events:
        message = {
            0: mavlink.MAVLink_mission_count_message(1, 1, int(rng.integers(4)), 0),
            1: mavlink.MAVLink_mission_clear_all_message(1, 1, 0),
            2: mavlink.MAVLink_mission_request_list_message(1, 1, 0),
            3: mavlink.MAVLink_mission_request_int_message(1, 1, int(rng.integers(5)), 0),
            4: mavlink.MAVLink_mission_ack_message(1, 1, int(rng.integers(16)), 0),
        }.get(event, item(int(rng.integers(4))))
        fleet.receive(0, message.pack(mav))
        fleet.advance(fleet.now_us + int(rng.integers(0, 3_000_000)))
        steps = fleet.pilot.plans[0].steps
        stored = fleet.squads[0].endpoints[0].stored.get(0, ())
        assert len(steps) == len(stored) <= 3
