"""What a UAV with a copy of the pheromone maps adds to its frames' payload: its newest words.

After the planner's own payload: the words, each after its length, then the length of all of
them and two bytes that no planner's payload ends in by chance alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from struct import Struct

_LENGTH = Struct("<H")
_END = b"\xf0\x9c"
_MOST = 0xFFFF


def joined(payload: bytes, words: Sequence[bytes]) -> bytes:
    """The payload with words after it; the oldest are left out where they do not fit."""
    parts = [_LENGTH.pack(len(word)) + word for word in words]
    while parts and len(payload) + sum(map(len, parts)) + _LENGTH.size + len(_END) > _MOST:
        del parts[0]
    body = b"".join(parts)
    return payload + body + _LENGTH.pack(len(body)) + _END


def own(payload: bytes) -> bytes:
    """The planner's own part of a payload."""
    return payload[: _begin(payload)]


def words(payload: bytes) -> list[bytes]:
    """The words behind it."""
    at, end, found = _begin(payload), len(payload) - _LENGTH.size - len(_END), []
    while at + _LENGTH.size <= end:
        (size,) = _LENGTH.unpack_from(payload, at)
        at += _LENGTH.size
        if at + size > end:
            break
        found.append(payload[at : at + size])
        at += size
    return found


def _begin(payload: bytes) -> int:
    tail = _LENGTH.size + len(_END)
    if len(payload) < tail or not payload.endswith(_END):
        return len(payload)
    (size,) = _LENGTH.unpack_from(payload, len(payload) - tail)
    begin = len(payload) - tail - int(size)
    return begin if begin >= 0 else len(payload)
