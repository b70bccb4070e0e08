import hashlib
import struct
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer

from uavbridge.agent.report import AgentReport
from uavbridge.agent.report import decode as decode_report
from uavbridge.agent.report import encode as encode_report
from uavbridge.errors import ConfigError
from uavbridge.recording.digest import StreamDigest, prefix
from uavbridge.recording.parts import METADATA_NAME, ONE_FILE, Rotation, begun
from uavbridge.recording.reader import Recording
from uavbridge.recording.recorder import MCAP_NAME, Recorder
from uavbridge.recording.topics import (
    TOPICS,
    EventRecord,
    MissionRecord,
    ScoreRecord,
    SetpointRecord,
    encode,
    known,
    pack_heard,
    topic_kind,
    unpack_heard,
)

LZ4 = b"\x04\x22\x4d\x18"  # begins what a chunk holds
EPOCH_NS = 1_700_000_000_000_000_000
FRAME = bytes([0xFD, 3, 0, 0, 0, 1, 1, 30, 0, 0]) + b"abc" + b"xy"


def fly(
    folder: Path | None,
    *,
    seconds: int = 5,
    mcap: bool = True,
    epoch_ns: int = EPOCH_NS,
    rotation: Rotation = ONE_FILE,
) -> Recorder:
    """Record a small made-up mission; the recorder is left open."""
    recorder = Recorder(
        folder, mission_name="demo", epoch_ns=epoch_ns, mcap=mcap, rotation=rotation
    )
    recorder.record("mission", 0, MissionRecord(text="[mission]", seed=7, clock="stepped"))
    for t_us in range(0, seconds * 1_000_000, 200_000):
        for agent in (1, 2):
            position = [float(agent), t_us / 1e6, 30.0]
            setpoint = SetpointRecord("position", position)
            recorder.record(f"setpoint/{agent}", t_us, setpoint)
            recorder.write(f"air/{agent}", t_us, bytes(range(60)))
            recorder.tlog(agent).write(t_us, FRAME)
    return recorder


def independent_digest(folder: Path) -> str:
    """docs/reference/recording.md, followed with the mcap library and nothing of ours."""

    def field(data: bytes) -> bytes:
        return struct.pack("<I", len(data)) + data

    def tlog(path: Path) -> Iterator[tuple[int, bytes]]:
        data, at = path.read_bytes(), 0
        while at < len(data):
            (date_us,) = struct.unpack_from(">Q", data, at)
            length = 12 + data[at + 9]
            yield date_us - EPOCH_NS // 1000, data[at + 8 : at + 8 + length]
            at += 8 + length

    messages = hashlib.sha256()
    with (folder / MCAP_NAME).open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            if channel.topic != "summary":
                t_us = (message.log_time - EPOCH_NS) // 1000
                messages.update(field(channel.topic.encode()) + struct.pack("<q", t_us))
                messages.update(field(message.data))
    whole = hashlib.sha256(messages.digest())
    for agent in (1, 2):
        log = hashlib.sha256()
        for t_us, frame in tlog(folder / f"vehicle_{agent}.tlog"):
            log.update(field(f"tlog/{agent}".encode()) + struct.pack("<q", t_us) + field(frame))
        whole.update(struct.pack("<I", agent) + log.digest())
    return whole.hexdigest()


def test_the_mcap_library_reads_what_was_written(tmp_path: Path) -> None:
    fly(tmp_path).close()
    with (tmp_path / MCAP_NAME).open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 1 + 25 * 4
        states = [
            (schema, channel, message)
            for schema, channel, message in reader.iter_messages(topics=["setpoint/2"])
        ]
    schema, channel, message = states[-1]
    assert schema is not None
    assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
    assert msgspec.json.decode(message.data)["value"] == [2.0, 4.8, 30.0]
    assert message.log_time == EPOCH_NS + 4_800_000_000


def test_reader_gives_back_topics_times_and_bytes(tmp_path: Path) -> None:
    fly(tmp_path).close()
    recording = Recording(tmp_path)
    assert recording.complete
    assert (recording.mission_name, recording.epoch_ns) == ("demo", EPOCH_NS)
    messages = list(recording.messages())
    assert len(messages) == 101
    assert messages[-1] == ("air/2", 4_800_000, bytes(range(60)))


def test_digest_is_as_documented_and_as_read_back(tmp_path: Path) -> None:
    recorder = fly(tmp_path)
    digest = recorder.digest()
    recorder.write("summary", 5_000_000, b'{"wall_s": 3.2}')  # not part of it
    assert recorder.digest() == digest
    recorder.close()
    assert digest == independent_digest(tmp_path) == Recording(tmp_path).digest()


def test_digest_needs_no_files_and_no_date(tmp_path: Path) -> None:
    with fly(tmp_path) as kept, fly(None, epoch_ns=5) as null:
        assert kept.digest() == null.digest()


def test_telemetry_logs_without_the_rest(tmp_path: Path) -> None:
    fly(tmp_path, mcap=False).close()
    assert {path.name for path in tmp_path.iterdir()} == {"vehicle_1.tlog", "vehicle_2.tlog"}
    assert all(path.stat().st_size for path in tmp_path.iterdir())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize("name", [MCAP_NAME, "vehicle_1.tlog"])
def test_a_full_disk_ends_the_file_but_not_the_flight(
    tmp_path: Path, name: str, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / name).symlink_to("/dev/full")
    with fly(tmp_path, seconds=20) as recorder, fly(None, seconds=20) as null:
        assert recorder.digest() == null.digest()
    assert len(caplog.messages) == 1
    assert name in caplog.messages[0]
    assert "No space left" in caplog.messages[0]


def test_same_mission_same_files(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        fly(tmp_path / name).close()
    for file in (tmp_path / "one").iterdir():
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes()


@given(
    st.lists(st.tuples(st.sampled_from(["a", "ab", "b"]), st.integers(0, 2**40), st.binary())),
    st.lists(st.tuples(st.sampled_from(["a", "ab", "b"]), st.integers(0, 2**40), st.binary())),
)
def test_digest_tells_any_two_streams_apart(
    one: list[tuple[str, int, bytes]], two: list[tuple[str, int, bytes]]
) -> None:
    def value(records: list[tuple[str, int, bytes]]) -> bytes:
        digest = StreamDigest()
        for topic, t_us, data in records:
            digest.add(prefix(topic), t_us, data)
        return digest.value()

    assert (value(one) == value(two)) == (one == two)


def test_a_killed_process_leaves_all_but_the_last_second(tmp_path: Path) -> None:
    recorder = fly(tmp_path, seconds=10)
    killed = Recording(tmp_path)  # never closed
    assert not killed.complete
    times = [message.t_us for message in killed.messages()]
    assert max(times) >= 9_000_000
    assert len(times) >= 1 + 45 * 4
    recorder.close()


@given(cut=st.integers(0, 100_000))
def test_a_file_cut_anywhere_reads_up_to_the_cut(
    tmp_path_factory: pytest.TempPathFactory, cut: int
) -> None:
    folder = tmp_path_factory.mktemp("cut")
    fly(folder).close()
    path = folder / MCAP_NAME
    data = path.read_bytes()
    whole = list(Recording(path).messages())
    path.write_bytes(data[: cut % len(data)])
    try:
        left = list(Recording(path).messages())
    except ConfigError:
        assert cut % len(data) < 200  # not even the header is there
        return
    assert left == whole[: len(left)]


def test_a_damaged_chunk_ends_the_reading(tmp_path: Path) -> None:
    fly(tmp_path).close()
    path = tmp_path / MCAP_NAME
    data = bytearray(path.read_bytes())
    whole = list(Recording(path).messages())
    second_chunk = data.index(LZ4, data.index(LZ4) + 1)
    data[second_chunk + 20] ^= 0xFF
    path.write_bytes(data)
    left = list(Recording(path).messages())
    assert len(left) < len(whole)
    assert left == whole[: len(left)]


def test_what_is_no_recording_is_told_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"mission\.mcap: No such file"):
        Recording(tmp_path)
    (tmp_path / MCAP_NAME).write_bytes(b"hello")
    with pytest.raises(ConfigError, match="not an MCAP file"):
        Recording(tmp_path)


def test_unknown_topics_are_refused(tmp_path: Path) -> None:
    with (
        Recorder(tmp_path, mission_name="x", epoch_ns=0) as recorder,
        pytest.raises(KeyError),
    ):
        recorder.write("weather/1", 0, b"")


@pytest.mark.parametrize("name", [n for n, topic in TOPICS.items() if topic.struct])
def test_schemas_are_flat_objects(name: str) -> None:
    kind = topic_kind(f"{name}/3")
    _, encoding, data = kind.schema()
    schema = msgspec.json.decode(data)
    assert encoding == "jsonschema"
    assert schema["type"] == "object"
    assert all("type" in field for field in schema["properties"].values())


def test_a_battery_that_is_not_known_is_left_out_of_the_report() -> None:
    report = AgentReport(
        agent=1, t_us=0, phase="connect", mode="unknown", position=(0.0, 0.0, 0.0),
        velocity=(0.0, 0.0, 0.0), heading=0.0, armed=False, in_air=False, neighbours=0, note="",
        distance_m=0.0, declared=[],
    )  # fmt: skip
    data = encode_report(report)
    assert "battery" not in msgspec.json.decode(data)
    assert decode_report(data) == report
    _, _, schema = topic_kind("state/1").schema()
    assert "battery" not in msgspec.json.decode(schema)["required"]


def test_unknown_numbers_are_left_out() -> None:
    score = ScoreRecord(0.5, 10.0, 9.0, 1, separation=known(float("nan")))
    assert "separation" not in msgspec.json.decode(encode(score))
    assert msgspec.json.decode(encode(EventRecord("failure", "no link", 3)))["agent"] == 3


@given(
    st.lists(
        st.tuples(
            st.integers(0, 2**32 - 1),
            st.integers(0, 2**32 - 1),
            st.sampled_from(["delivered", "out of range", "loss"]),
        )
    ),
    st.binary(max_size=8),
)
def test_heard_round_trip(rows: list[tuple[int, int, str]], rest: bytes) -> None:
    records = unpack_heard(pack_heard(rows) + rest)
    codes = [{"delivered": 0, "out of range": 1, "loss": 2}[outcome] for _, _, outcome in rows]
    assert np.array_equal(records["sender"], [sender for sender, _, _ in rows])
    assert np.array_equal(records["outcome"], codes)


@pytest.mark.parametrize("rotation", [Rotation(part_us=2_000_000), Rotation(part_bytes=4000)])
def test_parts_are_read_as_one(tmp_path: Path, rotation: Rotation) -> None:
    (tmp_path / "one").mkdir()
    with fly(tmp_path / "one", seconds=9) as whole:
        pass
    with fly(tmp_path, seconds=9, rotation=rotation) as recorder:
        pass
    recording = Recording(tmp_path)
    assert len(recording.parts) > 2
    assert recording.complete
    assert list(recording.messages()) == list(Recording(tmp_path / "one").messages())
    assert recording.digest() == recorder.digest() == whole.digest()
    for number, path in recording.parts.items():  # each of them for any tool that reads MCAP
        assert Recording(path).path == tmp_path / MCAP_NAME
        with path.open("rb") as file:
            (_, first, _), *_ = make_reader(file, validate_crcs=True).iter_messages()
        assert first.topic == "mission", number


def test_a_recording_ends_where_a_part_is_missing(tmp_path: Path) -> None:
    fly(tmp_path, seconds=9, rotation=Rotation(part_us=2_000_000)).close()
    whole = list(Recording(tmp_path).messages())
    (tmp_path / "mission-3.mcap").unlink()
    left = Recording(tmp_path)
    assert not left.complete
    assert list(left.messages()) == whole[: 1 + 4 * 5 * 4 + 1]
    for number in (1, 2):
        (tmp_path / ("mission.mcap", "mission-2.mcap")[number - 1]).unlink()
    alone = Recording(tmp_path / "mission-4.mcap")
    assert [message.topic for message in alone.messages()][:1] == ["mission"]
    assert left.from_start
    assert not alone.from_start


def test_a_file_whose_writer_was_killed_at_once_is_no_recording(tmp_path: Path) -> None:
    assert not begun(tmp_path)
    (tmp_path / MCAP_NAME).touch()
    assert not begun(tmp_path)
    fly(tmp_path).close()
    assert begun(tmp_path)


def test_files_of_such_a_name_are_not_parts(tmp_path: Path) -> None:
    fly(tmp_path).close()
    (tmp_path / "other").mkdir()
    fly(tmp_path / "other", seconds=3, epoch_ns=5).close()
    (tmp_path / "other" / MCAP_NAME).rename(tmp_path / "mission-2.mcap")
    assert len(list(Recording(tmp_path).messages())) == 101
    assert len(list(Recording(tmp_path / "mission-2.mcap").messages())) == 61


def test_a_newer_format_is_refused_with_the_reason(tmp_path: Path) -> None:
    with (tmp_path / MCAP_NAME).open("wb") as file:
        writer = Writer(file)
        writer.start()
        facts = {"mission": "m", "epoch_ns": "0", "format": "99", "version": "7.1"}
        writer.add_metadata(METADATA_NAME, facts)
        writer.finish()
    with pytest.raises(ConfigError, match=r"recorded by uavbridge 7\.1 in format 99"):
        Recording(tmp_path)
