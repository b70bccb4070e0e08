from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink import mavutil
from pymavlink.dialects.v20 import common

from uavbridge.recording.tlog import TlogWriter, frame_length, read_tlog, tlog_digest

EPOCH_US = 1_700_000_000_000_000


def frames(count: int) -> list[bytes]:
    mav = common.MAVLink(None, srcSystem=3, srcComponent=1)
    return [
        bytes(common.MAVLink_local_position_ned_message(ms, 1.0, 2.0, -30.0, 0, 0, 0).pack(mav))
        for ms in range(count)
    ]


def test_pymavlink_reads_it_back(tmp_path: Path) -> None:
    path = tmp_path / "vehicle_3.tlog"
    log = TlogWriter(path, 3, EPOCH_US)
    sent = frames(30)
    for tick, frame in enumerate(sent):
        log.write(tick * 100_000, frame)
    log.close()
    reader = mavutil.mavlink_connection(str(path))
    for tick in range(30):
        message = reader.recv_match()
        assert message.get_type() == "LOCAL_POSITION_NED"
        assert message.time_boot_ms == tick
        assert message._timestamp == pytest.approx(EPOCH_US / 1e6 + tick / 10, abs=1e-5)
    assert reader.recv_match() is None
    reader.close()


def test_a_datagram_of_several_frames_is_split(tmp_path: Path) -> None:
    path = tmp_path / "log"
    log = TlogWriter(path, 3, EPOCH_US)
    sent = frames(4)
    log.write(5, b"".join(sent) + b"noise")
    log.close()
    assert list(read_tlog(path, EPOCH_US)) == [(5, frame) for frame in sent]
    assert (log.frames, log.noise_bytes) == (4, 5)
    assert tlog_digest(path, 3, EPOCH_US) == log.digest()


def test_a_killed_process_leaves_all_but_the_last_second(tmp_path: Path) -> None:
    path = tmp_path / "log"
    log = TlogWriter(path, 3, EPOCH_US)
    for tick, frame in enumerate(frames(100)):
        log.write(tick * 100_000, frame)
    assert len(list(read_tlog(path, EPOCH_US))) >= 90
    path.write_bytes(path.read_bytes()[:-3])
    assert len(list(read_tlog(path, EPOCH_US))) >= 89
    log.close()


def test_lengths_of_signed_and_old_frames() -> None:
    signed = bytes([0xFD, 3, 1]) + bytes(7 + 3 + 2 + 13)
    old = bytes([0xFE, 9]) + bytes(4 + 9 + 2)
    assert frame_length(signed) == len(signed)
    assert frame_length(old) == len(old)
    assert frame_length(b"junk" + old, 4) == len(old)


def heads() -> st.SearchStrategy[bytes]:
    """Bytes that begin as a frame does, now and then."""
    return st.builds(bytes.__add__, st.sampled_from([b"", b"\xfd\x00", b"\xfe\x01"]), st.binary())


@given(st.lists(heads()))
def test_any_bytes_are_taken_and_read_back(
    tmp_path_factory: pytest.TempPathFactory, chunks: list[bytes]
) -> None:
    path = tmp_path_factory.mktemp("any") / "log"
    log = TlogWriter(path, 1, 0)
    for chunk in [*chunks, b"", *frames(1)]:
        log.write(0, chunk)
    log.close()
    assert log.noise_bytes <= sum(map(len, chunks))
    assert [frame for _, frame in read_tlog(path, 0)][-1:] == frames(1)
    assert len(list(read_tlog(path, 0))) == log.frames
    assert tlog_digest(path, 1, 0) == log.digest()
