"""Reads recordings back, whole ones and those of a process that was killed."""

from __future__ import annotations

import logging
import re
import struct
from collections.abc import Iterator
from importlib.metadata import version
from io import SEEK_END, BytesIO
from pathlib import Path
from typing import NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

from uavbridge.errors import ConfigError
from uavbridge.recording.digest import StreamDigest, combine, prefix
from uavbridge.recording.older import upgraded
from uavbridge.recording.parts import FORMAT, HEAD, MCAP_NAME, METADATA_NAME, parts_of
from uavbridge.recording.recorder import BUS
from uavbridge.recording.tlog import TLOG_PATTERN, tlog_digest
from uavbridge.recording.topics import TOPICS

_RECORD = struct.Struct("<BQ")  # opcode, length of what follows
_HEAD_BYTES = 64 * 1024  # more than enough for what stands before the first chunk
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time

log = logging.getLogger(__name__)


class Message(NamedTuple):
    """One recorded message."""

    topic: str
    t_us: int
    data: bytes


class Recording:
    """A ``mission.mcap`` on disk, with the parts that go on where it ends.

    Args:
        path: the file, one of its parts, or the folder it lies in.

    Attributes:
        path: of the first part.
        parts: by number; all are read as one.
        metadata: what the recorder said of the file.

    Raises:
        ConfigError: there is no such file, or it is not a recording that this version reads.
    """

    def __init__(self, path: Path) -> None:
        path = path / MCAP_NAME if path.is_dir() else path
        self.parts = _parts(path)
        self.path = next(iter(self.parts.values()))
        self.metadata = _metadata(self.path)
        self.mission_name = self.metadata["mission"]
        self.epoch_ns = int(self.metadata["epoch_ns"])

    @property
    def complete(self) -> bool:
        """False where the writer was killed, or a part is missing; what is there still reads."""
        whole = (_ends_well(path) for path in self.parts.values())
        return not self._gap and all(whole)

    @property
    def from_bus(self) -> bool:
        """Somebody listened in: what radios delivered and planners decided is not in it."""
        return self.metadata.get("source") == BUS

    @property
    def from_start(self) -> bool:
        """False for what is left of a recording whose first part is gone."""
        return int(self.metadata.get("part", "1")) == 1

    @property
    def _gap(self) -> int:
        """The first part that is missing; 0: none before the last that is there."""
        numbers = range(1, max(self.parts) + 1)
        return next((number for number in numbers if number not in self.parts), 0)

    def messages(self) -> Iterator[Message]:
        """All messages in recording order, up to the last chunk that is whole.

        Those of an older wire format are turned into today's; see ``recording.older``.
        """
        for topic, t_us, data in self._raw():
            yield Message(topic, t_us, upgraded(topic.partition("/")[0], data))

    def _raw(self) -> Iterator[Message]:
        """The messages as they were recorded."""
        first = min(self.parts)
        for number, path in self.parts.items():
            if 0 < self._gap < number and number != first:
                log.warning("%s: part %d is missing; the rest is left out", self.path, self._gap)
                return
            for message in self._part_messages(path):
                if message.topic != HEAD or number == first:
                    yield message
            if not _ends_well(path) and number != max(self.parts):
                log.warning(
                    "%s: cut short; what was said until part %d is not known", path, number + 1
                )

    def _part_messages(self, path: Path) -> Iterator[Message]:
        topics: dict[int, str] = {}
        for code, body in _records(path.read_bytes()):
            if code == Opcode.DATA_END:
                return
            if code != Opcode.CHUNK:
                continue
            records = _chunk_records(Chunk.read(_stream(body)))
            if records is None:
                log.warning("%s: a damaged chunk; the rest is left out", path)
                return
            yield from self._chunk_messages(records, topics)

    def digest(self) -> str:
        """The digest, computed anew from this file and the .tlog files beside it."""
        digest = StreamDigest()
        for topic, t_us, data in self._raw():
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


def _parts(path: Path) -> dict[int, Path]:
    """The files of one recording: others may have such names too."""
    found = parts_of(path)
    if len(found) < 2:
        return found or {1: path}
    heads = {number: _metadata(part) for number, part in found.items()}
    own = next((heads[number] for number, part in found.items() if part == path), None)
    epoch = (own or heads[min(heads)])["epoch_ns"]
    kept = {
        number: found[number]
        for number, head in heads.items()
        if head["epoch_ns"] == epoch and int(head.get("part", "1")) == number
    }
    return kept if path in kept.values() or own is None else {1: path}


def _metadata(path: Path) -> dict[str, str]:
    """What stands at the beginning of a file. Raises ConfigError as ``Recording`` does."""
    try:
        with path.open("rb") as file:
            data = file.read(_HEAD_BYTES)
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror or error}") from error
    if not data.startswith(MCAP0_MAGIC):
        raise ConfigError(f"{path}: not an MCAP file")
    header = next((body for code, body in _records(data) if code == Opcode.METADATA), None)
    record = None if header is None else Metadata.read(_stream(header))
    if record is None or record.name != METADATA_NAME:
        raise ConfigError(f"{path}: an MCAP file, but not a recording of a mission")
    known: dict[str, str] = record.metadata
    if int(known.get("format", "0")) > FORMAT:
        raise ConfigError(
            f"{path}: recorded by uavbridge {known.get('version')} in format {known['format']}; "
            f"uavbridge {version('uavbridge')} reads up to {FORMAT}"
        )
    return known


def _ends_well(path: Path) -> bool:
    """Whether its writer came to the end."""
    with path.open("rb") as file:
        size = file.seek(0, SEEK_END)
        file.seek(max(size - len(MCAP0_MAGIC), 0))
        return file.read() == MCAP0_MAGIC and size > 2 * len(MCAP0_MAGIC)


def _records(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Opcode and body of each whole record of a file."""
    at = len(MCAP0_MAGIC)
    while at + _RECORD.size <= len(data):
        code, length = _RECORD.unpack_from(data, at)
        at += _RECORD.size
        if at + length > len(data):
            return
        yield code, data[at : at + length]
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
