"""MAVLink 2 signing: frames that only those with the key could have made, each taken once.

A signature is the first six bytes of SHA-256 over key, frame, link id and a timestamp
(https://mavlink.io/en/guide/message_signing.html). Timestamps only grow, so a frame that
comes again is known: each stream (system, component, link) has its newest one, and a new
stream may not begin more than a minute behind the newest of all.
"""

from __future__ import annotations

import hashlib
import logging
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from hmac import compare_digest
from pathlib import Path
from typing import Final

from fastcrc import crc16

from sim_vehicles.codec.tables import BY_ID

_log = logging.getLogger(__name__)
_crc = crc16.mcrf4xx
_STX2: Final = 0xFD
_STX1: Final = 0xFE
_SIGNED: Final = 0x01
_TAIL: Final = 13  # bytes of link id, timestamp and signature
_EPOCH_US: Final = 1_420_070_400_000_000  # 2015-01-01, where timestamps begin
_UNIT_US: Final = 10
_MINUTE: Final = 60_000_000 // _UNIT_US
_KEY_BYTES: Final = 32
_LARGEST_FILE: Final = 1_000_000

Key = bytes


@dataclass(slots=True)
class Refused:
    """Frames that were not let in; counts only grow."""

    unsigned: int = 0
    wrong: int = 0  # signed with another key, or changed on the way
    replayed: int = 0  # seen before, or older than one seen before

    @property
    def total(self) -> int:
        """All of them."""
        return self.unsigned + self.wrong + self.replayed


class Keyring:
    """Keys by system id, and one for all others.

    Args:
        keys: 32 bytes each; 0 stands for every system without a key of its own.

    Raises:
        ValueError: a key of another length, or a system id out of range.
    """

    def __init__(self, keys: Mapping[int, Key]) -> None:
        for system, key in keys.items():
            if not 0 <= system <= 255:
                raise ValueError(f"a system id is 1..255, not {system}")
            if len(key) != _KEY_BYTES:
                raise ValueError(f"a key has {_KEY_BYTES} bytes, not {len(key)}")
        self._keys = dict(keys)

    def key(self, system: int) -> Key | None:
        """The key of a system; None: it has none, and nothing to do with it is let through."""
        return self._keys.get(system, self._keys.get(0))


def read_keys(path: Path) -> Keyring:
    """Keys from a file.

    A line is ``SYSTEM KEY``, or ``KEY`` alone for every system that has none of its own. A key
    is 64 hexadecimal digits, or ``passphrase:`` and words, of which the key is the SHA-256, as
    in MAVProxy and Mission Planner. What follows a # is left out.

    Raises:
        ValueError: it can not be read, or a line of it is wrong; the message names both.
    """
    try:
        text = path.read_text(encoding="utf-8")[:_LARGEST_FILE]
    except (OSError, UnicodeDecodeError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else "is no text"
        raise ValueError(f"{path}: {reason}") from None
    keys: dict[int, Key] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].strip()
        if not words:
            continue
        match = re.fullmatch(r"(?:(\d{1,3})\s+)?(?:([0-9a-fA-F]{64})|passphrase:(.+))", words)
        if match is None or int(match[1] or 0) > 255:
            raise ValueError(
                f"{path}:{number}: no key; write SYSTEM and 64 hexadecimal digits or "
                "passphrase:WORDS"
            )
        system = int(match[1] or 0)
        if system in keys:
            raise ValueError(f"{path}:{number}: a second key for the same system")
        phrase = match[3]
        keys[system] = (
            bytes.fromhex(match[2])
            if phrase is None
            else hashlib.sha256(phrase.strip().encode()).digest()
        )
    if not keys:
        raise ValueError(f"{path}: no key in it")
    return Keyring(keys)


class Seal:
    """Signs what goes out, and lets in what is signed: one end of one link.

    Args:
        keyring: the keys.
        now_us: tells the date, microseconds since 1970.
        link: its number, told apart from others of the same sender.
    """

    def __init__(self, keyring: Keyring, now_us: Callable[[], int], link: int = 0) -> None:
        self._keyring, self._now_us, self._link = keyring, now_us, link
        self._newest = 0
        self._streams: dict[tuple[int, int, int], int] = {}
        self.refused = Refused()

    def _now(self) -> int:
        return max((self._now_us() - _EPOCH_US) // _UNIT_US, 0)

    def close(self, data: bytes, system: int) -> bytes:
        """The frames of a datagram, signed with the key of a system; without one: nothing.

        Args:
            data: whole MAVLink 2 frames, not signed.
            system: whose key: the vehicle's, on both of its ends.
        """
        key = self._keyring.key(system)
        if key is None:
            return b""
        return b"".join(self._sign(frame, key) for frame in frames(data))

    def _sign(self, frame: bytes, key: Key) -> bytes:
        layout = BY_ID[frame[7] | frame[8] << 8 | frame[9] << 16] if frame[0] == _STX2 else None
        if layout is None or frame[2] & _SIGNED:
            return frame
        self._newest = max(self._newest + 1, self._now())
        body = bytes((frame[1], frame[2] | _SIGNED)) + frame[3:-2]
        packet = frame[:1] + body + _crc(body + layout.crc_extra).to_bytes(2, "little")
        packet += bytes((self._link,)) + self._newest.to_bytes(6, "little")
        return packet + _signature(key, packet)

    def open(self, data: bytes, system: int | None = None) -> bytes:
        """The frames of a datagram that are rightly signed, and new.

        Args:
            data: as it arrived.
            system: whose key; None: that of each frame's sender.
        """
        return b"".join(frame for frame in frames(data) if self._good(frame, system))

    def _good(self, frame: bytes, system: int | None) -> bool:
        if frame[0] != _STX2 or not frame[2] & _SIGNED:
            self.refused.unsigned += 1
            return False
        key = self._keyring.key(frame[5] if system is None else system)
        if key is None or not compare_digest(_signature(key, frame[:-6]), frame[-6:]):
            self.refused.wrong += 1
            _log.debug("a wrong signature of system %d", frame[5])
            return False
        stamp = int.from_bytes(frame[-12:-6], "little")
        stream = (frame[5], frame[6], frame[-13])
        newest = self._streams.get(stream)
        oldest = max(self._newest, self._now()) - _MINUTE if newest is None else newest + 1
        if stamp < oldest:
            self.refused.replayed += 1
            return False
        self._streams[stream] = stamp
        self._newest = max(self._newest, stamp)
        return True


def _signature(key: Key, signed: bytes) -> bytes:
    return hashlib.sha256(key + signed).digest()[:6]


def frames(data: bytes) -> Iterator[bytes]:
    """The whole frames of a datagram by their headers; stops at what begins none."""
    at = 0
    while len(data) - at >= 8:
        marker, length = data[at], data[at + 1]
        if marker == _STX2:
            size = length + 12 + (_TAIL if data[at + 2] & _SIGNED else 0)
        elif marker == _STX1:
            size = length + 8
        else:
            return
        if at + size > len(data) or (marker == _STX2 and size < 12):
            return
        yield data[at : at + size]
        at += size
