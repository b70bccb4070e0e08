"""Where one MAVLink frame ends and the next begins, by the header alone.

Enough to route, record and lose frames without decoding them; the checksum is
the codec's business.
"""

from __future__ import annotations

from typing import Final

V2: Final = 0xFD
V1: Final = 0xFE
_V2_OVERHEAD = 12  # header 10, checksum 2
_V1_OVERHEAD = 8  # header 6, checksum 2
_SIGNED = 0x01
_SIGNATURE = 13


def frame_end(data: bytes, start: int) -> int:
    """Index after the frame that starts at ``start``; -1 if no whole frame does."""
    left = len(data) - start
    if left < _V1_OVERHEAD:
        return -1
    if data[start] == V2 and left >= _V2_OVERHEAD:
        length = _V2_OVERHEAD + data[start + 1]
        if data[start + 2] & _SIGNED:
            length += _SIGNATURE
    elif data[start] == V1:
        length = _V1_OVERHEAD + data[start + 1]
    else:
        return -1
    return start + length if length <= left else -1


def is_signed(frame: bytes) -> bool:
    """Whether a whole frame carries a signature."""
    return frame[0] == V2 and bool(frame[2] & _SIGNED)


def system_of(data: bytes, start: int = 0) -> int:
    """System id of the whole frame that starts at ``start``."""
    return data[start + 5] if data[start] == V2 else data[start + 3]


def split(datagram: bytes) -> list[bytes]:
    """The whole frames of a datagram; stops at the first byte that begins none."""
    end = frame_end(datagram, 0)
    if end == len(datagram):
        return [datagram]
    frames, start = [], 0
    while end > 0:
        frames.append(datagram[start:end])
        start, end = end, frame_end(datagram, end)
    return frames


def by_system(datagram: bytes) -> list[tuple[int, bytes]]:
    """(system id, frames of it joined) in order of first appearance.

    What follows the last whole frame goes with that frame's system, so that its
    decoder counts it. Empty if the datagram does not begin with a frame.
    """
    end = frame_end(datagram, 0)
    if end < 0:
        return []
    first = system_of(datagram)
    if end == len(datagram):
        return [(first, datagram)]
    parts: dict[int, list[bytes]] = {first: []}
    start, system = 0, first
    while end > 0:
        system = system_of(datagram, start)
        parts.setdefault(system, []).append(datagram[start:end])
        start, end = end, frame_end(datagram, end)
    if len(parts) == 1:
        return [(first, datagram)]
    parts[system].append(datagram[start:])
    return [(each, b"".join(frames)) for each, frames in parts.items()]
