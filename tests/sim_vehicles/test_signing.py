"""Signing against pymavlink's own, and against those who have not the key."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega

from sim_vehicles.codec import Counts, Encoder, decode
from sim_vehicles.codec.signing import Keyring, Refused, Seal, read_keys

KEY, OTHER = bytes(range(32)), bytes(32)
NOW_US = 1_795_000_000_000_000
EPOCH_US = 1_420_070_400_000_000


def seal(key: bytes = KEY, now_us: int = NOW_US, link: int = 0) -> Seal:
    return Seal(Keyring({0: key}), lambda: now_us, link)


def frame(number: int = 0, system: int = 7) -> bytes:
    return Encoder(system).pack("HEARTBEAT", custom_mode=number, mavlink_version=3)


def theirs(system: int = 7, link: int = 3) -> ardupilotmega.MAVLink:
    """Pymavlink's end, which signs."""
    end = ardupilotmega.MAVLink(None, srcSystem=system, srcComponent=1)
    end.signing.secret_key = KEY
    end.signing.sign_outgoing = True
    end.signing.link_id = link
    end.signing.timestamp = (NOW_US - EPOCH_US) // 10
    return end


def test_pymavlink_reads_what_we_sign() -> None:
    end = theirs(system=245)
    end.signing.allow_unsigned_callback = None
    sealed = seal().close(frame(1) + frame(2), 7)
    read = end.parse_buffer(sealed)
    assert [message.custom_mode for message in read] == [1, 2]
    assert all(message.get_signed() for message in read)


def test_we_let_in_what_pymavlink_signs_once() -> None:
    end, ours = theirs(), seal()
    sent = [end.heartbeat_encode(2, 12, 81, number, 3).pack(end) for number in (1, 2, 3)]
    assert all(ours.open(each) == each for each in sent)
    assert [p.message.custom_mode for p in decode(b"".join(sent), Counts())] == [1, 2, 3]
    assert ours.open(sent[1]) == b""
    assert ours.refused == Refused(replayed=1)


def test_who_has_no_key_is_refused_and_counted() -> None:
    ours = seal()
    assert ours.open(frame()) == b""
    assert ours.open(seal(OTHER).close(frame(), 7)) == b""
    signed = bytearray(seal().close(frame(), 7))
    signed[12] ^= 1
    assert ours.open(bytes(signed)) == b""
    good = seal().close(frame(5), 7)
    assert ours.open(frame() + good) == good
    assert ours.refused == Refused(unsigned=2, wrong=2)


def test_a_recording_of_yesterday_is_not_let_in() -> None:
    old = seal(now_us=NOW_US - 24 * 3600 * 1_000_000).close(frame(), 7)
    ours = seal()
    assert ours.open(old) == b""
    assert ours.refused == Refused(replayed=1)
    late = seal(now_us=NOW_US - 30 * 1_000_000).close(frame(), 7)
    assert ours.open(late) == late  # a new stream may lag by a minute


def test_streams_of_two_links_and_systems_are_their_own() -> None:
    ours, one, two = seal(), seal(link=1), seal(link=2)
    parts = [one.close(frame(1), 7), two.close(frame(2), 7), one.close(frame(3, system=8), 7)]
    assert [bool(ours.open(part)) for part in parts[::-1]] == [True, True, True]


def test_a_system_without_a_key_gets_nothing_and_is_not_heard() -> None:
    keys = Keyring({7: KEY})
    ours = Seal(keys, lambda: NOW_US)
    assert ours.close(frame(), 8) == b""
    assert ours.open(seal().close(frame(system=8), 7)) == b""
    assert ours.refused == Refused(wrong=1)


@given(st.binary(max_size=300))
def test_any_bytes_are_refused_without_a_word(data: bytes) -> None:
    assert seal().open(data) == b""


def test_keys_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "keys.txt"
    path.write_text(f"# fleet\n7 {KEY.hex()}  # ours\npassphrase: my words \n")
    keys = read_keys(path)
    assert keys.key(7) == KEY
    assert keys.key(8) == hashlib.sha256(b"my words").digest()


@pytest.mark.parametrize(
    ("text", "words"),
    [("7 abcdef\n", "keys.txt:1: no key"), ("", "no key in it"), (f"300 {KEY.hex()}", ":1: no key"),
     (f"{KEY.hex()}\n0 {KEY.hex()}", ":2: a second key")],
)  # fmt: skip
def test_a_wrong_file_is_named(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "keys.txt"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"keys\.txt") as caught:
        read_keys(path)
    assert words in str(caught.value)
    with pytest.raises(ValueError, match="No such file"):
        read_keys(tmp_path / "none")
