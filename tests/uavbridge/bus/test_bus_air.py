"""Nobody hears what the radio does not carry: the same on the local and on the live bus."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from tests.uavbridge.bus.sessions import LocalSessions, Sessions, ZenohSessions
from uavbridge.bus import keys
from uavbridge.bus.air import Air, SafetyBeacons
from uavbridge.bus.api import Bus
from uavbridge.bus.ether import Ether
from uavbridge.bus.messages import FullMap, Truth, decode_map, encode_map, encode_truth
from uavbridge.bus.screening import Bounds
from uavbridge.bus.tiles import Tiling
from uavbridge.bus.truth import TruthTrack
from uavbridge.bus.wire import DELTA, KEYFRAME, WAITED_BYTES, Beacon, Frame, Kind, Vector, encode
from uavbridge.radio import Link, Quality, Radio
from uavbridge.rng import stream

STILL = (0.0, 0.0, 0.0)
SECOND = 1_000_000


def frame(sender: int, position: Vector, t_us: int = 0, tick: int = 0, kind: Kind = DELTA) -> Frame:
    return Frame(kind, sender, tick, t_us, position, STILL, payload=b"from %d" % sender)


def senders(heard: Sequence[Frame]) -> list[int]:
    return [f.sender for f in heard]


class AirTests(Sessions):
    def sent(self, frames: Sequence[Frame], air: Air, bus: Bus, *listeners: Bus) -> None:
        self.settle(bus, *listeners)
        for message in frames:
            air.send(message)
        self.settle(bus, *listeners)

    def test_no_byte_of_an_out_of_range_frame_reaches_an_inbox(self) -> None:
        rng = stream(3, "layouts")
        one, two = self.session(), self.session()
        homes = {one: [1, 2, 3], two: [4, 5, 6]}
        airs = {bus: Air(bus, Radio(400.0), ids) for bus, ids in homes.items()}
        for tick in range(25):
            spots = {i: tuple(rng.uniform(0, 900, 3).tolist()) for i in range(1, 7)}
            self.settle(one, two)
            self.settle(two, one)
            for bus, ids in homes.items():
                for i in ids:
                    airs[bus].send(frame(i, spots[i], tick * SECOND, tick))
            self.settle(one, one, two)
            self.settle(two, one, two)
            heard = {}
            for bus, ids in homes.items():
                heard |= airs[bus].receive({i: spots[i] for i in ids}, tick * SECOND + 1)
            for i in spots:
                near = [j for j in spots if j != i and math.dist(spots[i], spots[j]) <= 400.0]
                assert senders(heard[i]) == near
                assert [f.payload for f in heard[i]] == [b"from %d" % j for j in near]
                assert all(f.tick == tick for f in heard[i])
        for bus, ids in homes.items():
            assert airs[bus].arrivals == 25 * 6
            for i in ids:
                accounts = airs[bus].traffic[i]
                assert accounts.frames_heard + accounts.dropped["out of range"] == 25 * 5

    @pytest.mark.parametrize(
        ("at_sending", "at_receiving", "hears"),
        [(399.0, 401.0, True), (401.0, 399.0, False), (400.0, 900.0, True), (401.0, 0.0, False)],
    )
    def test_the_truth_at_sending_time_decides(
        self, at_sending: float, at_receiving: float, hears: bool
    ) -> None:
        bus, far = self.session(), self.session()
        truth = TruthTrack(far)
        sender, receiver = Air(bus, Radio(400.0), [1]), Air(far, Radio(400.0), [2], truth=truth)
        self.settle(bus, far)
        for t_us, distance in ((0, at_sending), (SECOND, at_receiving)):
            place = [[0.0, 0.0, 0.0], [distance, 0.0, 0.0]]
            message = Truth(t_us, (1, 2), np.array(place))
            bus.publish(keys.TRUTH, encode_truth(message))
        # what both ends believe is far off, and changes nothing
        self.sent([frame(1, (-5000.0, 0, 0))], sender, bus, far)
        heard = receiver.receive({2: (5000.0, 0.0, 0.0)}, SECOND)
        assert senders(heard[2]) == ([1] if hears else [])
        assert receiver.unsure == 0

    @pytest.mark.parametrize(("own_x", "hears"), [(399.0, True), (401.0, False)])
    def test_without_truth_the_beacon_and_the_own_position_decide(
        self, own_x: float, hears: bool
    ) -> None:
        bus, far = self.session(), self.session()
        sender, receiver = Air(bus, Radio(400.0), [1]), Air(far, Radio(400.0), [2])
        self.sent([frame(1, STILL)], sender, bus, far)
        assert senders(receiver.receive({2: (own_x, 0.0, 0.0)}, 0)[2]) == ([1] if hears else [])

    def test_beacons_have_their_own_range_keys_and_accounts(self) -> None:
        bus, far = self.session(), self.session()
        air = Air(far, Radio(400.0), [2])
        source = SafetyBeacons(bus, Radio(100.0), [1])
        beacons = SafetyBeacons(far, Radio(100.0), [2])
        self.settle(bus, far)
        for t_us, x in ((0, 99.0), (SECOND, 101.0)):
            source.send(Beacon(1, t_us, (x, 0.0, 0.0), STILL))
        self.settle(bus, far)
        heard = beacons.receive({2: STILL}, SECOND)
        assert [b.t_us for b in heard[2]] == [0]
        assert beacons.traffic[2].dropped == {"out of range": 1}
        assert air.receive({2: STILL}, SECOND) == {2: []}
        assert air.arrivals == 0
        assert source.traffic[1].frames_sent == 2
        assert source.traffic[1].bytes_sent == 2 * 40

    def test_who_comes_late_sees_everything_by_keyframe_and_by_query(self) -> None:
        bus, late = self.session(), self.session()
        air = Air(bus, Radio(400.0), [1])
        air.send(frame(1, STILL))
        self.settle(bus, late)
        full = FullMap(1, 0, 0.0, 0.0, 100.0, np.array([[0.25, 1.0]]), np.array([[5, -1]], int))
        bus.serve(keys.state_map(1), lambda _: encode_map(full))
        receiver = Air(late, Radio(400.0), [2])
        people = late.subscribe(keys.state_map("*"))
        self.settle(bus, late)
        answers = late.query(keys.state_map("*"))
        bus.publish(keys.state_map(1), encode_map(full))
        self.sent([frame(1, STILL, SECOND, 1, KEYFRAME)], air, bus, late)
        assert [f.kind for f in receiver.receive({2: STILL}, SECOND)[2]] == [KEYFRAME]
        for samples in (answers, people.drain()):
            assert [sample.key for sample in samples] == ["state/1/map"]
            seen = decode_map(samples[0].data)
            assert seen is not None
            assert seen.probability.tolist() == [[0.25, 1.0]]
            assert seen.stamp_us.tolist() == [[5, -1]]

    @pytest.mark.parametrize("count", [4, 10, 20, 40])
    def test_deliveries_per_process_grow_linearly_with_agents(self, count: int) -> None:
        """Two processes with half of the agents each: one delivery per agent, tick and process."""
        ticks = 5
        one, two = self.session(), self.session()
        half = count // 2
        homes = {one: range(half), two: range(half, count)}
        airs = {bus: Air(bus, Radio(math.inf), tuple(ids)) for bus, ids in homes.items()}
        for tick in range(ticks):
            self.settle(one, two)
            self.settle(two, one)
            for bus, ids in homes.items():
                for i in ids:
                    airs[bus].send(frame(i, STILL, tick * SECOND, tick))
            self.settle(one, one, two)
            self.settle(two, one, two)
            for bus, ids in homes.items():
                heard = airs[bus].receive({i: STILL for i in ids}, tick * SECOND)
                assert all(len(frames) == count - 1 for frames in heard.values())
        assert [air.arrivals for air in airs.values()] == [ticks * count] * 2

    def test_tiles_keep_far_traffic_away_and_nothing_else(self) -> None:
        rng = stream(4, "flight")
        tiling = Tiling.of(50.0, 10.0)
        bus, tiled, plain = self.session(), self.session(), self.session()
        source = Air(bus, Radio(50.0), range(1, 9), tiling)
        near = Air(tiled, Radio(50.0), [0], tiling)
        all_of_it = Air(plain, Radio(50.0), [0])
        everything = plain.subscribe("air/**")
        spots = {i: rng.uniform(-300, 300, 3) * (1, 1, 0) for i in range(9)}
        course = {i: rng.uniform(-10, 10, 3) * (1, 1, 0) for i in range(9)}
        arrived = 0
        for tick in range(40):
            place = {i: tuple((spots[i] + tick * course[i]).tolist()) for i in spots}
            self.settle(bus, tiled, plain)
            for i in range(1, 9):
                source.send(frame(i, place[i], tick * SECOND, tick))
            self.settle(bus, tiled, plain)
            arrived += len(everything.drain())
            heard = near.receive({0: place[0]}, tick * SECOND)
            in_range = [i for i in range(1, 9) if math.dist(place[0], place[i]) <= 50.0]
            assert senders(heard[0]) == in_range
        assert arrived == 40 * 8
        assert 8 <= near.arrivals < arrived / 2
        assert all_of_it.arrivals == 0


class TestLocalAir(AirTests, LocalSessions):
    pass


class TestZenohAir(AirTests, ZenohSessions):
    pass


class TestAccounts(LocalSessions):
    """What needs no second implementation to be believed."""

    def test_an_agent_never_hears_its_own_frame(self) -> None:
        air = Air(self.session(), Radio(math.inf), [1, 2])
        air.send(frame(1, STILL))
        heard = air.receive({1: STILL, 2: STILL}, 0)
        assert (senders(heard[1]), senders(heard[2])) == ([], [1])
        assert air.traffic[1].dropped == {}

    def test_frames_come_by_sender_and_tick_whatever_the_order_of_arrival(self) -> None:
        air = Air(self.session(), Radio(math.inf), [1, 2, 3])
        for sender, tick in ((3, 1), (1, 5), (3, 0), (1, 4)):
            air.send(frame(sender, STILL, tick, tick))
        heard = air.receive({1: STILL, 2: STILL, 3: STILL}, 10)
        assert [(f.sender, f.tick) for f in heard[2]] == [(1, 4), (1, 5), (3, 0), (3, 1)]
        assert air.receive({1: STILL, 2: STILL, 3: STILL}, 10) == {1: [], 2: [], 3: []}

    def test_bytes_are_counted_where_they_go(self) -> None:
        told: list[tuple[int, bytes, bool, str]] = []
        air = Air(self.session(), Radio(400.0), [1, 2, 3], log=lambda *heard: told.append(heard))
        message = frame(1, STILL)
        size = len(air.send(message))
        assert size == len(encode(message)) == 44 + len(b"from 1")
        air.receive({1: STILL, 2: (300.0, 0, 0), 3: (500.0, 0, 0)}, 0)
        one, two, three = (air.traffic[i] for i in (1, 2, 3))
        assert (one.frames_offered, one.frames_sent, one.bytes_sent) == (1, 1, size)
        assert (one.frames_heard, two.frames_heard, three.frames_heard) == (0, 1, 0)
        assert (two.bytes_heard, three.bytes_heard) == (size, 0)
        assert (two.dropped, three.dropped) == ({}, {"out of range": 1})
        data = encode(message)
        assert told == [(2, data, True, "delivered"), (3, data, False, "out of range")]

    def test_what_nobody_may_hear_is_counted(self) -> None:
        bus = self.session()
        air = Air(bus, Radio(math.inf), [1, 2])
        good = encode(frame(7, STILL, SECOND, 1))
        bus.publish("air/0/0/7", good)
        bus.publish("air/0/0/7", good)
        bus.publish("air/0/0/8", good)
        bus.publish("air/0/0/7", b"\xff" * 60)
        bus.publish("air/0/0/7", good[:-1])
        bus.publish("air/0/0/7", encode(frame(7, STILL, 100 * SECOND, 99)))
        heard = air.receive({1: STILL, 2: STILL}, SECOND)
        assert [senders(inbox) for inbox in heard.values()] == [[7], [7]]
        assert air.rejects == {
            "duplicate": 1,
            "sender": 1,
            "magic": 1,
            "length": 1,
            "future": 1,
        }
        assert air.arrivals == 6

    def test_a_frame_newer_than_the_truth_waits_for_it(self) -> None:
        truth = TruthTrack()
        air = Air(self.session(), Radio(400.0), [1, 2], truth=truth)
        believed = {1: STILL, 2: STILL}
        truth.add(0, (1, 2), [STILL, STILL])
        air.send(frame(1, STILL, 1000))
        assert air.receive(believed, 2000)[2] == []
        truth.add(2000, (1, 2), [STILL, (900.0, 0, 0)])
        # halfway between the two samples it was 450 m away
        assert air.receive(believed, 3000)[2] == []
        assert air.traffic[2].dropped == {"out of range": 1}
        assert air.unsure == 0

    @pytest.mark.parametrize("known", [True, False])
    def test_it_does_not_wait_for_ever(self, known: bool) -> None:
        truth = TruthTrack()
        air = Air(self.session(), Radio(400.0), [1, 2], truth=truth)
        if known:
            truth.add(0, (1, 2), [STILL, (300.0, 0, 0)])
        believed = {1: STILL, 2: STILL}
        air.send(frame(1, STILL, 1000))
        for t_us in (1000, 250_000, 500_000):
            assert air.receive(believed, t_us)[2] == []
        assert senders(air.receive(believed, 501_000)[2]) == [1]
        assert air.unsure == 1

    def test_it_waits_as_long_as_it_is_told_where_there_was_truth(self) -> None:
        truth = TruthTrack()
        air = Air(self.session(), Radio(400.0), [1, 2], truth=truth, hold_s=5.0)
        truth.add(0, (1, 2), [STILL, (399.0, 0, 0)])
        believed = {1: STILL, 2: STILL}
        air.send(frame(1, STILL, 1000))
        for t_us in (1000, 501_000, 4_000_000):
            assert air.receive(believed, t_us)[2] == []
        truth.add(2000, (1, 2), [STILL, (403.0, 0, 0)])
        assert air.receive(believed, 4_100_000)[2] == []
        assert air.traffic[2].dropped == {"out of range": 1}

    def test_an_unlimited_radio_asks_for_no_truth(self) -> None:
        air = Air(self.session(), Radio(math.inf), [1, 2], truth=TruthTrack())
        air.send(frame(1, STILL, 1000))
        assert senders(air.receive({1: STILL, 2: STILL}, 1000)[2]) == [1]

    def test_who_is_no_vehicle_is_where_it_says(self) -> None:
        truth = TruthTrack()
        truth.add(0, (2,), [(350.0, 0.0, 0.0)])
        bus = self.session()
        air = Air(bus, Radio(400.0), [2], truth=truth)
        for sender, x in ((50, 0.0), (51, -100.0)):
            bus.publish(f"air/0/0/{sender}", encode(frame(sender, (x, 0.0, 0.0))))
        assert senders(air.receive({2: STILL}, 0)[2]) == [50]

    def test_a_process_without_agents_hears_nothing(self) -> None:
        bus = self.session()
        air = Air(bus, Radio(math.inf), [])
        bus.publish("air/0/0/7", encode(frame(7, STILL)))
        assert air.receive({}, 0) == {}

    def test_a_closed_air_is_silent(self) -> None:
        bus = self.session()
        air = Air(bus, Radio(math.inf), [1, 2])
        air.close()
        air.send(frame(1, STILL))
        assert air.receive({1: STILL, 2: STILL}, 0)[2] == []


class TestRadio(LocalSessions):
    """What the radio does to frames, on their way to agents."""

    def flown(
        self, radio: Radio, ticks: int, agents: Sequence[int] = (1, 2, 3), shuffled: bool = False
    ) -> tuple[Air, list[tuple[int, int, int, int]]]:
        """Everybody sends at each second; (tenth, receiver, sender, tick) of what was heard."""
        rng = stream(9, "order")
        bus = self.session()
        source, air = Air(bus, radio, agents), Air(bus, radio, agents)
        box = bus.subscribe("air/**")
        heard = []
        places = dict.fromkeys(agents, STILL)
        for tenth in range(10 * ticks + 100):
            if tenth % 10 == 0 and tenth < 10 * ticks:
                for agent in rng.permutation(agents).tolist() if shuffled else agents:
                    source.send(frame(agent, STILL, tenth * 100_000, tenth // 10))
            for agent, inbox in air.receive(places, tenth * 100_000).items():
                heard += [(tenth, agent, f.sender, f.tick) for f in inbox]
        assert len(box.drain()) == air.arrivals
        return air, heard

    def test_late_frames_come_when_they_are_due(self) -> None:
        quality = Quality(delay_s=1.25, jitter_s=2.0)
        air, heard = self.flown(Radio(math.inf, 1, quality), 20)
        assert len(heard) == 20 * 3 * 2
        waits = [tenth / 10 - tick for tenth, _, _, tick in heard]
        assert min(waits) >= 1.25
        assert max(waits) < 3.36
        assert len(set(waits)) > 10
        order = [tick for _, agent, sender, tick in heard if (agent, sender) == (2, 1)]
        assert order != sorted(order)  # the jitter is longer than a tick
        assert air.traffic[2].frames_heard == 40

    def test_the_order_of_arrival_changes_nothing(self) -> None:
        quality = Quality(loss=0.2, burst_enter=0.05, burst_leave=0.3, delay_s=0.3, jitter_s=1.0)
        links = (Link(1, 2, bytes_per_s=60.0), Link(2, loss=0.5))
        radio = Radio(math.inf, 4, quality, links)
        air, heard = self.flown(radio, 60)
        again, reheard = self.flown(radio, 60, shuffled=True)
        assert heard == reheard
        assert air.traffic == again.traffic
        assert set(air.traffic[2].dropped) == {"loss", "burst"}

    def test_the_senders_bandwidth_makes_frames_wait_and_drops_what_is_too_much(self) -> None:
        size = len(encode(frame(1, STILL))) + WAITED_BYTES
        bus = self.session()
        radio = Radio(math.inf, 1, Quality(bytes_per_s=size / 2, queue_s=4.0))
        air, far = Air(bus, radio, [1]), Air(bus, radio, [2])
        heard = []
        for second in range(40):
            if second < 20:
                air.send(frame(1, STILL, second * SECOND, second))
            heard += [
                (second - f.tick, f.tick) for f in far.receive({2: STILL}, second * SECOND)[2]
            ]
        accounts = air.traffic[1]
        assert heard[:4] == [(2, 0), (3, 1), (4, 2), (5, 3)]
        assert max(wait for wait, _ in heard) == 6
        assert len(heard) == accounts.frames_sent == 12
        assert accounts.dropped == {"queue": accounts.frames_offered - accounts.frames_sent}
        assert accounts.dropped_bytes["queue"] == accounts.bytes_offered - accounts.bytes_sent > 0

    def test_what_was_dropped_is_counted_in_bytes_by_reason(self) -> None:
        links = (Link(1, 2, loss=1.0), Link(1, 3, bytes_per_s=1.0))
        radio = Radio(100.0, 1, Quality(queue_s=1.0), links)
        told: list[tuple[int, str]] = []
        air = Air(
            self.session(),
            radio,
            [1, 2, 3, 4],
            log=lambda i, _, __, reason: told.append((i, reason)),
        )
        air.send(frame(1, STILL, 0, 0))
        second = len(air.send(frame(1, STILL, 1000, 1)))
        size = air.traffic[1].bytes_sent
        air.receive({1: STILL, 2: STILL, 3: STILL, 4: (500.0, 0.0, 0.0)}, 2000)
        assert air.traffic[2].dropped_bytes == {"loss": size}
        assert air.traffic[4].dropped_bytes == {"out of range": size}
        assert air.traffic[3].dropped_bytes == {"queue": second}
        assert told == [
            (2, "loss"),
            (4, "out of range"),
            (2, "loss"),
            (3, "queue"),
            (4, "out of range"),
        ]
        assert air.receive({i: STILL for i in range(1, 5)}, 100 * SECOND)[3][0].tick == 0
        assert told[-1] == (3, "delivered")


class TestScreening(LocalSessions):
    """What no honest agent sends."""

    bounds = Bounds(
        team=(1, 2, 7), mission=5, most_bytes=100, area=(0, 0, 1000, 1000), speed_m_s=10, old_s=30
    )

    @pytest.mark.parametrize(
        ("change", "reason"),
        [
            ({"t_us": 102 * SECOND}, "future"),
            ({"t_us": 69 * SECOND}, "replayed"),
            ({"mission": 6}, "mission"),
            ({"cells": bytes(101)}, "size"),
            ({"position": (7000.0, 0.0, 0.0)}, "position"),
            ({"position": (0.0, 0.0, 20_000.0)}, "position"),
            ({"position": (100.0, 0.0, 0.0)}, "jump"),
            ({"sender": 3}, "stranger"),
            ({"sender": 2}, "sender"),
        ],
    )
    def test_impossible_frames_are_dropped_and_counted(
        self, change: dict[str, Any], reason: str, caplog: pytest.LogCaptureFixture
    ) -> None:
        bus = self.session()
        air = Air(bus, Radio(math.inf), [1], bounds=self.bounds)
        good = Frame(DELTA, 7, 99, 99 * SECOND, STILL, STILL, mission=5)
        bus.publish("air/0/0/7", encode(good))
        bad = replace(good, **{"t_us": 100 * SECOND, "tick": 100, **change})
        key = f"air/0/0/{bad.sender if reason == 'stranger' else 7}"
        for _ in range(3):
            bus.publish(key, encode(bad))
        heard = air.receive({1: STILL}, 100 * SECOND)[1]
        assert [f.tick for f in heard] == [99]
        assert air.rejects == {reason: 3}
        warnings = [r.getMessage() for r in caplog.records if r.levelname == "WARNING"]
        assert len(warnings) == 1
        assert reason in warnings[0]

    def test_a_jump_does_not_shut_out_the_real_one(self) -> None:
        bus = self.session()
        air = Air(bus, Radio(math.inf), [1], bounds=self.bounds)
        ticks = []
        for tick in range(40):
            for x, lie in ((900.0, 500), (tick * 10.0, 0)):
                message = Frame(DELTA, 7, tick, tick * SECOND + lie, (x, 0, 0), STILL, mission=5)
                if lie == 0 or tick > 5:
                    bus.publish("air/0/0/7", encode(message))
            ticks += [f.tick for f in air.receive({1: STILL}, tick * SECOND)[1]]
        assert ticks == list(range(40))
        assert air.rejects == {"jump": 34}

    def test_a_second_copy_is_an_accident_at_first_and_a_replay_later(
        self, caplog: pytest.LogCaptureFixture
    ) -> None:
        bus = self.session()
        air = Air(bus, Radio(math.inf), [1], bounds=self.bounds)
        message = encode(Frame(DELTA, 7, 10, 10 * SECOND, STILL, STILL, mission=5))
        for second in (10, 12, 15, 20):
            bus.publish("air/0/0/7", message)
            assert len(air.receive({1: STILL}, second * SECOND)[1]) == (second == 10)
        assert air.rejects == {"duplicate": 1, "replayed": 2}
        assert [record.getMessage() for record in caplog.records] == [
            "a frame of agent 7 dropped: replayed"
        ]

    def test_whoever_was_away_may_be_anywhere(self) -> None:
        bus = self.session()
        air = Air(bus, Radio(math.inf), [1], bounds=self.bounds)
        for tick, x in ((0, 0.0), (15, 900.0)):
            message = Frame(DELTA, 7, tick, tick * SECOND, (x, 0, 0), STILL, mission=5)
            bus.publish("air/0/0/7", encode(message))
            assert len(air.receive({1: STILL}, tick * SECOND)[1]) == 1


class TestOneByOne(LocalSessions):
    """A process of one agent judges frames one by one, one of several all at once."""

    @pytest.mark.parametrize("known", [True, False])
    def test_one_agent_hears_what_it_would_among_others(self, known: bool) -> None:
        rng, radio = stream(8, "flights"), Radio(150.0)
        bus, logs = self.session(), ([], [])
        truths = [TruthTrack(), TruthTrack()]
        pair = [
            Air(
                bus, radio, agents, truth=truth if known else None,
                log=lambda i, data, heard, why, log=log: log.append((i, data, heard, why)),
            )
            for agents, truth, log in zip(([1], [1, 9]), truths, logs, strict=True)
        ]  # fmt: skip
        source = Air(bus, radio, range(1, 6))
        for tick in range(40):
            spots = rng.uniform(0, 200, (6, 3))
            for truth in truths:
                truth.add(tick * SECOND, (1, 2, 3, 4, 5, 9), spots)
            for i in range(1, 6):
                source.send(frame(i, tuple(spots[i - 1] + 30.0), tick * SECOND, tick))
            places = {1: tuple(spots[0] - 30.0), 9: tuple(spots[5])}
            alone, among = (air.receive(places, tick * SECOND + 1) for air in pair)
            assert alone[1] == among[1]
        assert logs[0] == [row for row in logs[1] if row[0] == 1]
        assert pair[0].traffic[1] == pair[1].traffic[1]
        assert pair[0].traffic[1].dropped["out of range"] > 20


class TestEther(LocalSessions):
    """Experiments and missions: the same radio, the same deliveries."""

    def test_it_carries_what_the_air_does(self) -> None:
        quality = Quality(
            loss=0.2, burst_enter=0.1, burst_leave=0.3, delay_s=0.4, jitter_s=3.0, bytes_per_s=90.0
        )
        radio = Radio(150.0, 4, quality, (Link(1, 2, bytes_per_s=50.0), Link(3, loss=0.6)))
        team, rng = (1, 2, 3, 4), stream(2, "places")
        air, ether = Air(self.session(), radio, team), Ether(radio, team)
        spots = rng.uniform(0, 120, (4, 3))
        places = {i: tuple(place) for i, place in zip(team, spots.tolist(), strict=True)}
        count = 0
        for tick in range(60):
            t_us = tick * SECOND
            heard = air.receive(places, t_us)
            assert list(heard.values()) == ether.receive(t_us)
            count += sum(map(len, heard.values()))
            frames = [frame(i, places[i], t_us, tick) for i in team]
            for message in frames:
                air.send(message)
            ether.send(frames, np.array(list(places.values())))
        assert air.traffic == ether.traffic
        assert count > 100
        assert {reason for t in air.traffic.values() for reason in t.dropped} >= {"loss", "burst"}
