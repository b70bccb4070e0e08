"""One number for a whole recording.

A *stream digest* is SHA-256 over its records in recording order, each as

    uint32 length of topic, topic (UTF-8), int64 mission time (us), uint32 length of data, data

with integers little-endian. The *digest* of a recording is SHA-256 over the
stream digest (32 bytes) of its messages, then, for each vehicle in ascending
id, its id (uint32 little-endian) and the stream digest of its .tlog, whose
records bear the topic ``tlog/<id>`` and one MAVLink frame each. Mission time is
in it and the date is not, so that two flights of one seed can agree.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterable, Mapping

_TIME_LENGTH = struct.Struct("<qI")
_U32 = struct.Struct("<I")
_BATCH = 6000  # parts to join before hashing; bounds memory, not correctness


def prefix(topic: str) -> bytes:
    """A topic with its length, as every record of it starts."""
    name = topic.encode()
    return _U32.pack(len(name)) + name


class StreamDigest:
    """Running SHA-256 over records."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        self._parts: list[bytes] = []

    def add(self, topic_prefix: bytes, t_us: int, data: bytes) -> None:
        """Take in one record; ``topic_prefix`` comes from ``prefix``."""
        parts = self._parts
        parts += (topic_prefix, _TIME_LENGTH.pack(t_us, len(data)), data)
        if len(parts) > _BATCH:
            self._drain()

    def extend(self, topic_prefix: bytes, t_us: int, records: Iterable[bytes]) -> None:
        """Take in several records of one time."""
        parts, pack = self._parts, _TIME_LENGTH.pack
        for data in records:
            parts += (topic_prefix, pack(t_us, len(data)), data)
        if len(parts) > _BATCH:
            self._drain()

    def value(self) -> bytes:
        """The 32 bytes over everything so far."""
        self._drain()
        return self._hash.digest()

    def _drain(self) -> None:
        self._hash.update(b"".join(self._parts))
        self._parts.clear()


def combine(messages: bytes, tlogs: Mapping[int, bytes]) -> str:
    """Digest in hex of a recording with these stream digests (32 bytes each)."""
    whole = hashlib.sha256(messages)
    for vehicle in sorted(tlogs):
        whole.update(_U32.pack(vehicle) + tlogs[vehicle])
    return whole.hexdigest()
