"""Reads recordings back, whole ones and those of a process that was killed."""

from __future__ import annotations

import logging
import re
import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

from uavbridge.errors import ConfigError
from uavbridge.recording.digest import StreamDigest, combine, prefix
from uavbridge.recording.recorder import MCAP_NAME, METADATA_NAME
from uavbridge.recording.tlog import TLOG_PATTERN, tlog_digest
from uavbridge.recording.topics import TOPICS

_RECORD = struct.Struct("<BQ")  # opcode, length of what follows
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time

log = logging.getLogger(__name__)


class Message(NamedTuple):
    """One recorded message."""

    topic: str
    t_us: int
    data: bytes


class Recording:
    """A ``mission.mcap`` on disk.

    Args:
        path: the file, or the folder it lies in.

    Raises:
        ConfigError: there is no such file, or it is not a recording of ours.
    """

    def __init__(self, path: Path) -> None:
        self.path = path / MCAP_NAME if path.is_dir() else path
        try:
            self._data = self.path.read_bytes()
        except OSError as error:
            raise ConfigError(f"{self.path}: {error.strerror or error}") from error
        if not self._data.startswith(MCAP0_MAGIC):
            raise ConfigError(f"{self.path}: not an MCAP file")
        header = next((body for code, body in self._records() if code == Opcode.METADATA), None)
        metadata = None if header is None else Metadata.read(_stream(header))
        if metadata is None or metadata.name != METADATA_NAME:
            raise ConfigError(f"{self.path}: an MCAP file, but not a recording of a mission")
        self.mission_name = metadata.metadata["mission"]
        self.epoch_ns = int(metadata.metadata["epoch_ns"])

    @property
    def complete(self) -> bool:
        """False where the writer was killed; what is there still reads."""
        return self._data.endswith(MCAP0_MAGIC) and len(self._data) > 2 * len(MCAP0_MAGIC)

    def messages(self) -> Iterator[Message]:
        """All messages in recording order, up to the last chunk that is whole."""
        topics: dict[int, str] = {}
        for code, body in self._records():
            if code == Opcode.DATA_END:
                return
            if code != Opcode.CHUNK:
                continue
            records = _chunk_records(Chunk.read(_stream(body)))
            if records is None:
                log.warning("%s: a damaged chunk; the rest is left out", self.path)
                return
            yield from self._chunk_messages(records, topics)

    def digest(self) -> str:
        """The digest, computed anew from this file and the .tlog files beside it."""
        digest = StreamDigest()
        for topic, t_us, data in self.messages():
            kind = TOPICS.get(topic.partition("/")[0])
            if kind is None or kind.digested:
                digest.add(prefix(topic), t_us, data)
        epoch_us = self.epoch_ns // 1000
        tlogs = {
            vehicle: tlog_digest(path, vehicle, epoch_us)
            for vehicle, path in self.tlogs().items()
            if path.stat().st_size
        }
        return combine(digest.value(), tlogs)

    def tlogs(self) -> dict[int, Path]:
        """The .tlog files beside it, by vehicle."""
        found = {}
        for path in self.path.parent.glob(TLOG_PATTERN):
            if match := re.fullmatch(r"vehicle_(\d+)\.tlog", path.name):
                found[int(match[1])] = path
        return dict(sorted(found.items()))

    def _records(self) -> Iterator[tuple[int, bytes]]:
        """Opcode and body of each whole record of the file."""
        data, at = self._data, len(MCAP0_MAGIC)
        while at + _RECORD.size <= len(data):
            code, length = _RECORD.unpack_from(data, at)
            at += _RECORD.size
            if at + length > len(data):
                return
            yield code, data[at : at + length]
            at += length

    def _chunk_messages(self, records: bytes, topics: dict[int, str]) -> Iterator[Message]:
        at, epoch_ns = 0, self.epoch_ns
        while at < len(records):
            code, length = _RECORD.unpack_from(records, at)
            at += _RECORD.size
            if code == Opcode.MESSAGE:
                channel, _, date_ns, _ = _MESSAGE.unpack_from(records, at)
                data = records[at + _MESSAGE.size : at + length]
                yield Message(topics[channel], (date_ns - epoch_ns) // 1000, data)
            elif code == Opcode.CHANNEL:
                record = Channel.read(_stream(records[at : at + length]))
                topics[record.id] = record.topic
            at += length


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(data))


def _chunk_records(chunk: Chunk) -> bytes | None:
    """What a chunk holds; None where it is damaged."""
    try:
        stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    except (ValueError, RuntimeError):  # wrong checksum; lz4 cannot read it
        return None
    return stream.read(length)
