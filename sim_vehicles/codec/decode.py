"""Bytes to packets: whatever arrives, nothing is raised; what is wrong is counted.

A frame counts only if its checksum is right, so noise can not become a message.
Frames of messages outside the dialect can not be checked: they are dropped.
"""

from __future__ import annotations

import logging
import re
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from fastcrc import crc16

from sim_vehicles.codec.tables import BY_ID

_log = logging.getLogger(__name__)
_crc = crc16.mcrf4xx
_STX2: Final = 0xFD
_STX1: Final = 0xFE
_next_start = re.compile(rb"[\xfd\xfe]").search
_SIGNED: Final = 0x01
_SIGNATURE_BYTES: Final = 13
_ZEROS: Final = bytes(255)
_new = tuple.__new__


class Packet(NamedTuple):
    """One good frame.

    ``message`` is a named tuple of the message's fields in wire order, under pymavlink's
    names; its class is named as the message and has ``msgname`` and ``msgid``. Texts are
    str up to the first NUL, arrays are tuples.
    """

    system: int
    component: int
    sequence: int
    message: Any
    raw: bytes  # the whole frame


@dataclass(slots=True)
class Counts:
    """What came in on one link; counts only grow."""

    packets: int = 0  # good frames
    bad_crc: int = 0  # frames whose checksum is wrong
    truncated: int = 0  # frames that end before they should
    unknown: int = 0  # frames of unknown messages, or with flags we do not understand
    noise: int = 0  # bytes outside any frame

    def add(self, other: Counts) -> None:
        """Add another link's counts to these."""
        self.packets += other.packets
        self.bad_crc += other.bad_crc
        self.truncated += other.truncated
        self.unknown += other.unknown
        self.noise += other.noise

    @property
    def garbage(self) -> int:
        """Frames dropped for any reason, plus one for each stray byte."""
        return self.bad_crc + self.truncated + self.unknown + self.noise


def decode(datagram: bytes, counts: Counts) -> list[Packet]:
    """All good frames of one datagram, MAVLink 2 and 1, in order. Never raises."""
    packets: list[Packet] = []
    at = 0
    end = len(datagram)
    while at < end:
        step = _frame(datagram, at, packets, counts)
        if step == 0:  # the frame is longer than the datagram
            counts.truncated += 1
            step = 1
        at += step
    return packets


class StreamDecoder:
    """Finds frames in a byte stream whose reads may end anywhere (TCP, serial)."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes, counts: Counts) -> list[Packet]:
        """All frames that ``data`` completes. Never raises."""
        buffer = self._rest + data
        packets: list[Packet] = []
        at = 0
        end = len(buffer)
        while at < end:
            step = _frame(buffer, at, packets, counts)
            if step == 0:
                break
            at += step
        self._rest = buffer[at:]
        return packets


def _frame(data: bytes, at: int, packets: list[Packet], counts: Counts) -> int:
    """Try a frame at ``at``: bytes to go on by, 0 if its end is not there yet."""
    marker = data[at]
    if marker == _STX2:
        return _frame2(data, at, packets, counts)
    if marker == _STX1:
        return _frame1(data, at, packets, counts)
    start = _next_start(data, at)
    stray = (start.start() if start else len(data)) - at
    counts.noise += stray
    return stray


def _frame2(data: bytes, at: int, packets: list[Packet], counts: Counts) -> int:
    have = len(data) - at
    if have < 12:
        return 0
    length = data[at + 1]
    flags = data[at + 2]
    size = length + (12 + _SIGNATURE_BYTES if flags & _SIGNED else 12)
    if have < size:
        return 0
    layout = BY_ID[data[at + 7] | data[at + 8] << 8 | data[at + 9] << 16]
    if layout is None:
        return _skip_unknown(data, at, size, counts)
    end = at + 10 + length
    if _crc(data[at + 1 : end] + layout.crc_extra) != data[end] | data[end + 1] << 8:
        counts.bad_crc += 1
        return 1
    if flags > _SIGNED:
        counts.unknown += 1
        return size
    payload = data[at + 10 : end]
    full = layout.struct.size
    if length != full:
        payload = payload + _ZEROS[: full - length] if length < full else payload[:full]
    message = layout.make(layout.struct.unpack(payload))
    raw = data if have == size and not at else data[at : at + size]
    counts.packets += 1
    packets.append(_new(Packet, (data[at + 5], data[at + 6], data[at + 4], message, raw)))
    return size


def _frame1(data: bytes, at: int, packets: list[Packet], counts: Counts) -> int:
    have = len(data) - at
    if have < 8:
        return 0
    length = data[at + 1]
    size = length + 8
    if have < size:
        return 0
    layout = BY_ID[data[at + 5]]
    if layout is None:
        return _skip_unknown(data, at, size, counts)
    end = at + 6 + length
    if _crc(data[at + 1 : end] + layout.crc_extra) != data[end] | data[end + 1] << 8:
        counts.bad_crc += 1
        return 1
    full = layout.struct.size
    payload = (data[at + 6 : end] + _ZEROS)[:full]
    message = layout.make(layout.struct.unpack(payload))
    counts.packets += 1
    packets.append(Packet(data[at + 3], data[at + 4], data[at + 2], message, data[at : at + size]))
    return size


def _skip_unknown(data: bytes, at: int, size: int, counts: Counts) -> int:
    """Go past an unknown message if a frame or nothing follows it; else it was noise."""
    end = at + size
    if end == len(data) or data[end] in (_STX1, _STX2):
        counts.unknown += 1
        _log.debug("dropped a frame of an unknown message: %s", data[at : at + 10].hex())
        return size
    counts.noise += 1
    return 1
