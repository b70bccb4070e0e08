"""Ten million mutated frames and packets: nothing is raised, nothing grows."""

import random
from collections import Counter

import numpy as np
import psutil
import pytest
from msgspec import DecodeError

from sim_vehicles.codec import Counts, Encoder, StreamDecoder, decode
from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic
from uavbridge.agent import orders, report
from uavbridge.bus import keys, messages, wire
from uavbridge.bus.air import Air
from uavbridge.bus.local import LocalHub
from uavbridge.mavlink.link import memory_pair
from uavbridge.radio import Radio
from uavbridge.vehicle.mavlink import MavlinkVehicle

pytestmark = [pytest.mark.soak, pytest.mark.timeout(3600)]

ORIGIN = Geodetic(47.0, 8.0, 400.0)
GROWTH = 24 << 20  # bytes that may come of caches and of the allocator


class Mutator:
    """Damages good messages in the ways that wires and attackers do."""

    def __init__(self, corpus, seed):
        self.draw = random.Random(seed)
        self.corpus = corpus

    def __call__(self):
        draw = self.draw
        data = bytearray(draw.choice(self.corpus))
        for _ in range(draw.randrange(1, 4)):
            kind = draw.randrange(5)
            at = draw.randrange(len(data) + 1)
            if kind == 0 and data:
                data[at % len(data)] ^= 1 << draw.randrange(8)
            elif kind == 1 and data:
                data[at % len(data)] = draw.choice((0, 1, 127, 128, 255))
            elif kind == 2:
                del data[at:]
            elif kind == 3:
                data[at:at] = draw.randbytes(draw.randrange(1, 9))
            else:
                data[at:] = draw.choice(self.corpus)[at:]
        return bytes(data)


def steady(step, count):
    """Call ``step`` so often; the memory it took after the first fifth, in bytes."""
    process, before = psutil.Process(), 0
    for number in range(count):
        if number == count // 5:
            before = process.memory_info().rss
        step()
    return process.memory_info().rss - before


def frames():
    still = (0.0, 0.0, 0.0)
    cells = np.random.default_rng(1).bytes(320)
    return [
        wire.encode(wire.Frame(wire.DELTA, 3, 4, 4_000_000, still, still)),
        wire.encode(wire.Frame(wire.KEYFRAME, 2, 9, 9_000_000, still, still, b"p", 1, cells)),
        wire.encode_beacon(wire.Beacon(3, 4_000_000, still, still)),
        messages.encode_readings(messages.Readings(5_000_000, ((1, 2, True), (3, 4, False)))),
        messages.encode_truth(messages.Truth(5_000_000, (1, 2), np.zeros((2, 3)))),
        orders.encode(orders.Order(orders.Verb.GOTO, position=(1.0, 2.0, 3.0))),
    ]


def test_messages_of_the_bus():
    mutate, rejects, read = Mutator(frames(), 1), Counter(), Counter()
    decoders = (
        wire.decode, wire.decode_beacon, messages.decode_readings, messages.decode_truth,
        messages.decode_map, messages.decode_signals, messages.decode_obstacles,
    )  # fmt: skip

    def step():
        data = mutate()
        for decoder in decoders:
            read[decoder.__name__] += decoder(data, rejects) is not None
        for decoder, faults in ((orders.decode, ValueError), (report.decode, DecodeError)):
            try:
                decoder(data)
            except faults:
                rejects["text"] += 1

    assert steady(step, 3_000_000) < GROWTH
    assert rejects.total() > 1_000_000
    assert read["decode"] > 1000


def test_the_radio_of_agents():
    hub = LocalHub()
    bus, stranger = hub.bus(), hub.bus()
    air = Air(bus, Radio(400.0), [1, 2])
    mutate, t_us, heard = Mutator(frames(), 2), 0, 0
    where = {1: (0.0, 0.0, 20.0), 2: (10.0, 0.0, 20.0)}

    def step():
        nonlocal t_us, heard
        for sender in range(3, 23):
            stranger.publish(keys.air((0, 0), sender), mutate())
        t_us += 100_000
        heard += sum(map(len, air.receive(where, t_us).values()))

    assert steady(step, 125_000) < GROWTH


NAMES = (
    "ATTITUDE", "AUTOPILOT_VERSION", "BATTERY_STATUS", "COMMAND_ACK", "COMMAND_INT",
    "COMMAND_LONG", "EXTENDED_SYS_STATE", "GLOBAL_POSITION_INT", "GPS_RAW_INT", "HEARTBEAT",
    "HOME_POSITION", "LOCAL_POSITION_NED", "MISSION_ACK", "MISSION_COUNT", "MISSION_CLEAR_ALL",
    "MISSION_ITEM_INT", "MISSION_REQUEST_INT", "MISSION_REQUEST_LIST", "MISSION_SET_CURRENT",
    "PARAM_REQUEST_LIST", "PARAM_REQUEST_READ", "PARAM_SET", "PARAM_VALUE", "PING",
    "REQUEST_DATA_STREAM", "SET_MODE", "SET_POSITION_TARGET_GLOBAL_INT",
    "SET_POSITION_TARGET_LOCAL_NED", "STATUSTEXT", "SYS_STATUS", "TIMESYNC", "VFR_HUD",
)  # fmt: skip


def packets():
    sender = Encoder(255, 190)
    return [sender.pack(name) for name in NAMES]


def test_packets():
    mutate, counts, stream = Mutator(packets(), 3), Counts(), StreamDecoder()

    def step():
        data = mutate()
        decode(data, counts)
        stream.feed(data, counts)

    assert steady(step, 3_000_000) < GROWTH
    assert counts.bad_crc > 1_000_000


def test_simulated_vehicles():
    fleet = Fleet([VehicleSpec(1, (0.0, 0.0, 0.0)), VehicleSpec(2, (9.0, 0.0, 0.0))], origin=ORIGIN)
    mutate, t_us = Mutator(packets(), 4), 0

    def step():
        nonlocal t_us
        for vehicle in (0, 1):
            fleet.receive(vehicle, mutate())
        t_us += 20_000
        fleet.advance(t_us)
        fleet.transmit()

    assert steady(step, 250_000) < GROWTH


def test_the_client_of_vehicles():
    near, far = memory_pair()
    vehicle = MavlinkVehicle(near, 255, origin=ORIGIN)  # the corpus' own system
    mutate, t_us = Mutator(packets(), 5), 0

    def step():
        nonlocal t_us
        for _ in range(10):
            far.send(mutate())
        t_us += 100_000
        vehicle.advance(t_us)
        far.receive()

    assert steady(step, 150_000) < GROWTH
