"""The MCAP files of a recording: one, or a row of parts that are read as one.

``mission.mcap``, then ``mission-2.mcap`` and so on. Each stands for itself: it has its schemas, its
index, and the mission as its first message.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from io import BufferedWriter
from pathlib import Path

from uavbridge.clock import SECOND_US
from uavbridge.recording.chunks import ChunkedFile
from uavbridge.recording.topics import topic_kind

MCAP_NAME = "mission.mcap"
METADATA_NAME = "uavbridge"
FORMAT = 1  # of recordings; those without this number are older and read the same
HEAD = "mission"  # the topic that every part begins with

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Rotation:
    """When a new part begins; zero: never for that reason."""

    part_bytes: int = 0
    part_us: int = 0  # of mission time

    def due(self, size: int, lasted_us: int) -> bool:
        """Whether a part of this size and length is enough."""
        return 0 < self.part_bytes <= size or 0 < self.part_us <= lasted_us


ONE_FILE = Rotation()


def begun(folder: Path) -> bool:
    """Whether a recording was begun there; a file that its writer was killed before is none."""
    first = folder / MCAP_NAME
    return first.exists() and first.stat().st_size > 0


def part_path(first: Path, number: int) -> Path:
    """Where part ``number`` (from 1) goes, beside the first."""
    return first if number == 1 else first.with_name(f"{first.stem}-{number}{first.suffix}")


def parts_of(path: Path) -> dict[int, Path]:
    """The parts that are there of the recording that a file belongs to, ascending."""
    stem, suffix = path.stem, path.suffix
    if not path.exists() or (match := re.fullmatch(r"(.+)-[1-9]\d*", stem)) is None:
        first = path
    else:
        first = path.with_name(match[1] + suffix)
        if not first.exists():
            return {1: path}  # a name of its own, or what is left of a recording
    found = {1: first} if first.exists() else {}
    for other in first.parent.glob(f"{first.stem}-*{suffix}"):
        if match := re.fullmatch(re.escape(first.stem) + r"-([1-9]\d*)", other.stem):
            found[int(match[1])] = other
    return dict(sorted(found.items()))


class PartWriter:
    """Writes messages to the part that is due, chunk by chunk.

    Args:
        folder: where the files go.
        metadata: of every part.
        epoch_ns: Unix date of mission start.
        rotation: when a new part begins.
        first: number of the first part to write.

    A file that can be written no more, on a full disk say, is told of in a warning and left
    as it is.
    """

    def __init__(
        self,
        folder: Path,
        metadata: Mapping[str, str],
        epoch_ns: int,
        rotation: Rotation,
        first: int = 1,
    ) -> None:
        self._first, self._metadata = folder / MCAP_NAME, metadata
        self._epoch_ns, self._rotation = epoch_ns, rotation
        self._number = first
        self._began_us = self._flush_us = 0
        self._head: tuple[int, bytes] | None = None
        self._stream: BufferedWriter | None = None
        self._open()

    def write(self, topic: str, t_us: int, data: bytes) -> None:
        """One message; at the first of each second of mission time, all before is handed over."""
        if self._stream is None:
            return
        try:
            self._add(topic, t_us, data)
            if t_us >= self._flush_us:
                self._file.flush()
                self._flush_us = t_us + SECOND_US
                if self._rotation.due(self._stream.tell(), t_us - self._began_us):
                    self._rotate(t_us)
        except OSError as fault:
            self._lose(fault)

    def close(self) -> None:
        """Write the index and let go of the file."""
        if self._stream is None:
            return
        try:
            self._finish(self._stream)
        except OSError as fault:
            self._lose(fault)
        self._stream = None

    def _open(self) -> None:
        stream = part_path(self._first, self._number).open("wb")
        self._stream = stream
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        facts = {**self._metadata, "part": str(self._number)}
        library = f"uavbridge {self._metadata['version']}"
        self._file = ChunkedFile(stream, library, METADATA_NAME, facts)

    def _add(self, topic: str, t_us: int, data: bytes) -> None:
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._register(topic)
            if topic == HEAD:
                self._head = t_us, data
        self._file.add(channel, self._epoch_ns + t_us * 1000, data)

    def _register(self, topic: str) -> int:
        kind = topic_kind(topic)
        if kind.name not in self._schemas:
            self._schemas[kind.name] = self._file.schema(*kind.schema())
        return self._file.channel(topic, kind.encoding, self._schemas[kind.name])

    def _rotate(self, t_us: int) -> None:
        if self._stream is not None:
            self._finish(self._stream)
        self._number += 1
        self._began_us = t_us
        self._open()
        if self._head is not None:
            self._add(HEAD, *self._head)

    def _finish(self, stream: BufferedWriter) -> None:
        self._file.finish()
        stream.close()

    def _lose(self, fault: OSError) -> None:
        """Write no further."""
        name = part_path(self._first, self._number).name
        _log.warning("%s: %s; the recording ends here", name, fault.strerror)
        stream, self._stream = self._stream, None
        if stream is not None:
            with suppress(OSError):  # said already
                stream.close()
