import math
import struct
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from uavbridge.bus import messages, wire
from uavbridge.bus.messages import FullMap, Obstacle, Obstacles, Readings, Signals, Truth
from uavbridge.bus.wire import DELTA, KEYFRAME, Beacon, Frame, Probe

float32s = st.floats(-1e4, 1e4, width=32)
vectors = st.tuples(float32s, float32s, float32s)
u32s = st.integers(0, 2**32 - 1)
u16s = st.integers(0, 2**16 - 1)
times = st.integers(0, wire.TIME_LIMIT_US)
digests = st.lists(u16s, min_size=1, max_size=wire.DIGESTS_LIMIT).map(tuple)
probes = st.builds(Probe, to=u16s, node=u32s, digests=digests, echo=st.booleans())
frames = st.builds(
    Frame,
    kind=st.sampled_from([DELTA, KEYFRAME]),
    sender=u16s,
    tick=st.integers(0, 2**24 - 1),
    t_us=times,
    position=vectors,
    velocity=vectors,
    payload=st.binary(max_size=80),
    rule=st.integers(0, 15),
    cells=st.binary(max_size=80),
    mission=u16s,
    root=u32s,
    heard=st.integers(0, 2**40),
    probes=st.lists(probes, max_size=3).map(tuple),
    waited_s=st.integers(0, 65535).map(lambda ms: ms / 1000.0),
)
beacons = st.builds(Beacon, sender=u32s, t_us=times, position=vectors, velocity=vectors)
cells16 = st.integers(0, 65535)
readings = st.builds(
    Readings,
    t_us=times,
    looks=st.lists(st.tuples(cells16, cells16, st.booleans()), max_size=9).map(tuple),
)

signals = st.builds(
    Signals,
    t_us=times,
    heard=st.lists(st.tuples(cells16, float32s, st.booleans()), max_size=9).map(tuple),
)


places, sizes = st.floats(-1e6, 1e6), st.floats(0.0, 1e4)
obstacles = st.builds(
    Obstacles,
    times,
    st.lists(st.builds(Obstacle, st.integers(0, 2**16 - 1), places, places, sizes, sizes)).map(
        tuple
    ),
)


@st.composite
def maps(draw: st.DrawFn) -> FullMap:
    columns, rows = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    count = columns * rows
    likely = draw(st.lists(st.floats(0, 1, width=32), min_size=count, max_size=count))
    stamps = draw(st.lists(st.integers(-1, 2**53), min_size=count, max_size=count))
    return FullMap(
        draw(u32s),
        draw(times),
        draw(float32s),
        draw(float32s),
        100.0,
        np.array(likely).reshape(columns, rows),
        np.array(stamps, np.int64).reshape(columns, rows),
    )


@st.composite
def truths(draw: st.DrawFn) -> Truth:
    ids = tuple(sorted(draw(st.sets(u32s, max_size=6))))
    place = draw(st.lists(vectors, min_size=len(ids), max_size=len(ids)))
    return Truth(draw(times), ids, np.array(place, np.float64).reshape(-1, 3))


Decoder = Callable[[bytes, Counter[str] | None], Any]
DECODERS: list[Decoder] = [
    wire.decode,
    wire.decode_beacon,
    messages.decode_map,
    messages.decode_readings,
    messages.decode_signals,
    messages.decode_obstacles,
    messages.decode_truth,
]
encoded = st.one_of(
    frames.map(wire.encode),
    beacons.map(wire.encode_beacon),
    maps().map(messages.encode_map),
    readings.map(messages.encode_readings),
    signals.map(messages.encode_signals),
    obstacles.map(messages.encode_obstacles),
    truths().map(messages.encode_truth),
)


@given(frames)
def test_a_frame_survives(frame: Frame) -> None:
    assert wire.decode(wire.encode(frame)) == frame


@given(frames, st.integers(0, 2**24 - 1), st.integers(0, 254))
def test_the_time_of_a_whole_tick_needs_no_bytes(frame: Frame, tick: int, tenths: int) -> None:
    whole = replace(frame, tick=tick, t_us=tick * tenths * 100_000)
    data = wire.encode(whole)
    assert wire.decode(data) == whole
    assert wire.sender_and_tick(data) == (frame.sender, tick)
    assert len(data) <= len(wire.encode(replace(whole, t_us=1))) - 8


@given(beacons)
def test_a_beacon_survives(beacon: Beacon) -> None:
    assert wire.decode_beacon(wire.encode_beacon(beacon)) == beacon


@given(readings)
def test_readings_survive(looks: Readings) -> None:
    assert messages.decode_readings(messages.encode_readings(looks)) == looks


@given(signals)
def test_signals_survive(heard: Signals) -> None:
    assert messages.decode_signals(messages.encode_signals(heard)) == heard


@given(obstacles)
def test_obstacles_survive(seen: Obstacles) -> None:
    assert messages.decode_obstacles(messages.encode_obstacles(seen)) == seen


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"x": np.nan}, "position"),
        ({"y": 2e6}, "position"),
        ({"radius_m": -1.0}, "value"),
        ({"room_m": np.inf}, "value"),
    ],
)
def test_impossible_obstacles_are_refused(wrong: dict[str, float], reason: str) -> None:
    column = Obstacle(1, 2.0, 3.0, 4.0, 5.0)._replace(**wrong)  # type: ignore[arg-type]
    rejects: Counter[str] = Counter()
    data = messages.encode_obstacles(Obstacles(0, (column,)))
    assert messages.decode_obstacles(data, rejects) is None
    assert rejects == {reason: 1}


@given(maps())
def test_a_map_survives(full: FullMap) -> None:
    again = messages.decode_map(messages.encode_map(full))
    assert again is not None
    assert np.array_equal(again.probability, full.probability)
    assert np.array_equal(again.stamp_us, full.stamp_us)
    assert (again.agent, again.t_us, again.west_m, again.south_m, again.cell_m) == (
        (full.agent, full.t_us, full.west_m, full.south_m, full.cell_m)
    )


@given(truths())
def test_the_truth_survives(truth: Truth) -> None:
    again = messages.decode_truth(messages.encode_truth(truth))
    assert again is not None
    assert (again.t_us, again.ids) == (truth.t_us, truth.ids)
    assert np.array_equal(again.position, truth.position)


@given(st.one_of(st.binary(max_size=200), st.binary(max_size=200).map(b"UB\x03".__add__)))
def test_any_bytes_are_read_or_refused(data: bytes) -> None:
    for decode in DECODERS:
        rejects: Counter[str] = Counter()
        message = decode(data, rejects)
        assert (message is None) == (rejects.total() == 1)


@given(encoded, st.data())
def test_truncated_bytes_are_refused(data: bytes, draw: st.DataObject) -> None:
    short = data[: draw.draw(st.integers(0, len(data) - 1))]
    long = data + draw.draw(st.binary(min_size=1, max_size=40))
    for decode in DECODERS:
        assert decode(short, None) is None
        assert decode(long, None) is None


@given(encoded, st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=8))
def test_mutated_bytes_raise_nothing(data: bytes, changes: list[tuple[int, int]]) -> None:
    mutated = bytearray(data)
    for place, value in changes:
        mutated[place % len(data)] = value
    for decode in DECODERS:
        rejects: Counter[str] = Counter()
        message = decode(bytes(mutated), rejects)
        assert (message is None) == (rejects.total() == 1)


@given(encoded)
def test_one_kind_is_never_read_as_another(data: bytes) -> None:
    assert sum(decode(data, None) is not None for decode in DECODERS) == 1


REFERENCE = Path(__file__).parents[3] / "docs/reference/wire_format.md"
FRAME = wire.encode(
    Frame(
        DELTA,
        sender=3,
        tick=25,
        t_us=12_500_000,
        position=(1.0, 2.0, 30.0),
        velocity=(0.5, 0.0, 0.0),
        payload=b"p",
        rule=1,
        mission=0x1122,
        root=0xAABBCCDD,
        heard=0b110,
        probes=(Probe(7, 0, (1, 515)),),
    )
)


def test_the_bytes_are_those_that_the_reference_shows() -> None:
    shown = " ".join(REFERENCE.read_text().split())
    assert FRAME.hex(" ", -4) in shown


@pytest.mark.parametrize(
    ("offset", "change", "reason"),
    [
        (0, b"XX", "magic"),
        (2, b"\x02", "version"),
        (3, b"\x03", "kind"),
        (11, b"\x00", "length"),
        (11, b"\xff", "length"),
        (12, b"\xff", "length"),
        (13, b"\xf1", "length"),
        (14, struct.pack("<f", math.nan), "position"),
        (18, struct.pack("<f", math.inf), "position"),
        (22, struct.pack("<f", 2e6), "position"),
        (26, struct.pack("<f", -math.inf), "velocity"),
        (43, b"\x02", "length"),
        (43, b"\xff\xff", "length"),
        (45, b"\x02", "length"),
        (53, b"\x00", "probe"),
        (53, b"\x11", "probe"),
        (53, b"\x03", "length"),
    ],
)
def test_the_reason_is_counted(offset: int, change: bytes, reason: str) -> None:
    rejects: Counter[str] = Counter()
    data = FRAME[:offset] + change + FRAME[offset + len(change) :]
    assert wire.decode(data, rejects) is None
    assert rejects == {reason: 1}


@pytest.mark.parametrize(
    ("offset", "change", "reason"),
    [
        (42, struct.pack("<q", -1), "time"),
        (42, struct.pack("<q", 2**60), "time"),
        (50, b"\x01\x00\x00\x00", "length"),
        (50, b"\xff\xff\xff\xff", "size"),
        (12, b"\x05", "length"),
    ],
)
def test_a_time_and_a_length_are_checked(offset: int, change: bytes, reason: str) -> None:
    rejects: Counter[str] = Counter()
    sound = wire.encode(Frame(DELTA, 1, 2, 3, (0, 0, 0), (0, 0, 0), cells=bytes(18)))
    data = sound[:offset] + change + sound[offset + len(change) :]
    assert wire.decode(sound) is not None
    assert wire.decode(data, rejects) is None
    assert rejects == {reason: 1}


@pytest.mark.parametrize(
    "frame",
    [
        Frame(DELTA, -1, 0, 0, (0, 0, 0), (0, 0, 0)),
        Frame(DELTA, 1, 2**24, 0, (0, 0, 0), (0, 0, 0)),
        Frame(DELTA, 1, 0, 0, (0, 0, 0), (0, 0, 0), rule=16),
        Frame(DELTA, 1, 0, 0, (0, 0, 0), (0, 0, 0), mission=2**16),
        Frame(DELTA, 1, 0, 0, (0, 0, 0), (0, 0, 0), heard=-1),
        Frame(DELTA, 1, 0, 0, (0, 0, 0), (0, 0, 0), heard=2**2040),
        Frame(DELTA, 1, 0, 0, (1e39, 0, 0), (0, 0, 0)),
        Frame(DELTA, 1, 0, 0, (0, 0, 0), (0, 0, 0), probes=(Probe(1, 0, ()),)),
        Frame(DELTA, 1, 0, 0, (0, 0, 0), (0, 0, 0), probes=(Probe(1, 0, (1,)),) * 256),
        Frame(DELTA, 1, 0, 0, (0, 0, 0), (0, 0, 0), waited_s=70.0),
        Frame(DELTA, 1, 0, 0, (0, 0, 0), (0, 0, 0), payload=bytes(65536)),
        Frame(DELTA, 1, 0, 0, (0, 0, 0), (0, 0, 0), cells=bytes(wire.CELLS_LIMIT + 1)),
    ],
)
def test_what_does_not_fit_is_an_error_of_the_sender(frame: Frame) -> None:
    with pytest.raises(ValueError, match=r"frame|cells"):
        wire.encode(frame)


def test_absurd_numbers_in_maps_and_truth_are_refused() -> None:
    sound = FullMap(1, 0, 0.0, 0.0, 10.0, np.full((2, 2), 0.5), np.full((2, 2), -1))
    data = messages.encode_map(sound)
    start = len(data) - 16
    for value in (math.nan, -0.1, 1.1, math.inf):
        rejects: Counter[str] = Counter()
        bad = data[:start] + struct.pack("<f", value) + data[start + 4 :]
        assert messages.decode_map(bad, rejects) is None
        assert rejects == {"value": 1}
    huge = data[:16] + struct.pack("<II", 2**31, 2**31) + data[24:]
    rejects = Counter()
    assert messages.decode_map(huge, rejects) is None
    assert rejects == {"size": 1}
    twice = messages.encode_truth(Truth(0, (4, 4), np.zeros((2, 3))))
    assert messages.decode_truth(twice) is None
    with pytest.raises(ValueError, match="positions"):
        messages.encode_truth(Truth(0, (1, 2), np.zeros((1, 3))))
    with pytest.raises(ValueError, match="stamps"):
        messages.encode_map(FullMap(1, 0, 0, 0, 1, np.zeros((2, 2)), np.zeros((3, 2), np.int64)))
