"""Frame borders by header alone."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from sim_vehicles.codec import Counts, Encoder, decode
from uavbridge.mavlink.frames import by_system, split, system_of

systems = st.integers(1, 255)


def heartbeat(system: int) -> bytes:
    return Encoder(system).pack("HEARTBEAT", custom_mode=7, mavlink_version=3)


@given(st.lists(systems, min_size=1, max_size=8))
def test_split_gives_the_frames_that_were_joined(senders: list[int]) -> None:
    frames = [heartbeat(system) for system in senders]
    assert split(b"".join(frames)) == frames
    assert [system_of(frame) for frame in frames] == senders


@given(st.lists(systems, min_size=1, max_size=8), st.binary(max_size=5))
def test_by_system_loses_and_invents_nothing(senders: list[int], tail: bytes) -> None:
    frames = [heartbeat(system) for system in senders]
    parts = by_system(b"".join(frames) + tail)
    assert sorted(b"".join(part for _, part in parts)) == sorted(b"".join(frames) + tail)
    assert [system for system, _ in parts] == list(dict.fromkeys(senders))
    for system, part in parts:
        heard = decode(part, Counts())
        assert [packet.system for packet in heard] == [system] * senders.count(system)


@given(st.binary(max_size=80))
def test_any_bytes_are_taken(data: bytes) -> None:
    assert b"".join(split(data)) == data[: sum(map(len, split(data)))]
    parts = by_system(data)
    assert not parts or sum(len(part) for _, part in parts) == len(data)


def test_signed_and_version_one_frames() -> None:
    plain = heartbeat(3)
    signed = plain[:2] + b"\x01" + plain[3:] + bytes(13)
    old = bytes([0xFE, 9, 0, 9, 1, 0]) + bytes(9) + b"\0\0"
    assert split(signed + old + plain) == [signed, old, plain]
    assert by_system(signed + old) == [(3, signed), (9, old)]


def test_a_frame_cut_short_is_no_frame() -> None:
    frame = heartbeat(1)
    assert split(frame + frame[:-1]) == [frame]
    assert by_system(frame[:-1]) == []
