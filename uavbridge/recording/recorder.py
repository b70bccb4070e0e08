"""Writes a mission down while it flies: ``mission.mcap`` and a .tlog a vehicle.

Chunks are handed to the operating system every second of mission time, so that
a killed process leaves a file that reads to within that second. Not for use by
several threads at once.
"""

from __future__ import annotations

import logging
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from io import BufferedWriter
from pathlib import Path
from types import TracebackType

from mcap.writer import CompressionType, Writer
from msgspec import Struct

from uavbridge.clock import SECOND_US
from uavbridge.recording.digest import StreamDigest, combine, prefix
from uavbridge.recording.tlog import TlogWriter, tlog_name
from uavbridge.recording.topics import encode, topic_kind

MCAP_NAME = "mission.mcap"
METADATA_NAME = "uavbridge"
_CHUNK_BYTES = 512 * 1024

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class _Channel:
    prefix: bytes
    digested: bool
    id: int  # in the file; 0 where there is none


class Recorder:
    """Takes every message and frame of one mission.

    Args:
        folder: where the files go; it must be there. None: keep the digest only.
        mission_name: for people; part of the file, not of the digest.
        epoch_ns: Unix date of mission start, for absolute times. Give a fixed one where
            the files shall be equal byte for byte.
        mcap: False: no mission.mcap.

    A file that can be written no more, on a full disk say, is told of in a warning and left
    as it is: the flight goes on.
    """

    def __init__(
        self, folder: Path | None, *, mission_name: str, epoch_ns: int, mcap: bool = True
    ) -> None:
        self.folder = folder
        self.messages = 0
        self._epoch_ns = epoch_ns
        self._digest = StreamDigest()
        self._channels: dict[str, _Channel] = {}
        self._schemas: dict[str, int] = {}
        self._tlogs: dict[int, TlogWriter] = {}
        self._flush_us = 0
        self._stream: BufferedWriter | None = None
        if mcap and folder is not None:
            self._stream = (folder / MCAP_NAME).open("wb")
            self._writer = Writer(
                self._stream, chunk_size=_CHUNK_BYTES, compression=CompressionType.LZ4
            )
            self._writer.start(library=f"uavbridge {version('uavbridge')}")
            self._writer.add_metadata(
                METADATA_NAME, {"mission": mission_name, "epoch_ns": str(epoch_ns)}
            )

    def write(self, topic: str, t_us: int, data: bytes) -> None:
        """Record one message.

        Args:
            topic: as in ``recording.topics.TOPICS``, with ``/<agent>`` where it has one.
            t_us: mission time.
            data: the message as its topic's encoding says.

        Raises:
            KeyError: the table has no such topic.
        """
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._register(topic)
        self.messages += 1
        if channel.digested:
            self._digest.add(channel.prefix, t_us, data)
        if self._stream is None:
            return
        date_ns = self._epoch_ns + t_us * 1000
        try:
            self._writer.add_message(channel.id, date_ns, data, date_ns)
            if t_us >= self._flush_us:
                self._writer.flush()  # type: ignore[no-untyped-call]
                self._flush_us = t_us + SECOND_US
        except OSError as fault:
            self._lose(fault)

    def record(self, topic: str, t_us: int, record: Struct) -> None:
        """Record one of the structs of ``recording.topics``."""
        self.write(topic, t_us, encode(record))

    def tlog(self, vehicle: int) -> TlogWriter:
        """The log of one vehicle, made at the first call."""
        if vehicle not in self._tlogs:
            path = None if self.folder is None else self.folder / tlog_name(vehicle)
            self._tlogs[vehicle] = TlogWriter(path, vehicle, self._epoch_ns // 1000)
        return self._tlogs[vehicle]

    def digest(self) -> str:
        """SHA-256 in hex over everything so far, as docs/reference/recording.md defines it."""
        tlogs = {vehicle: log.digest() for vehicle, log in self._tlogs.items() if log.frames}
        return combine(self._digest.value(), tlogs)

    def close(self) -> None:
        """Write the index and let go of all files. A second call does nothing."""
        for log in self._tlogs.values():
            log.close()
        if self._stream is None:
            return
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.close()
        except OSError as fault:
            self._lose(fault)
        self._stream = None

    def _lose(self, fault: OSError) -> None:
        """Write no further."""
        _log.warning("%s: %s; the recording ends here", MCAP_NAME, fault.strerror)
        stream, self._stream = self._stream, None
        if stream is not None:
            with suppress(OSError):  # said already
                stream.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _register(self, topic: str) -> _Channel:
        kind = topic_kind(topic)
        if self._stream is None:
            return _Channel(prefix(topic), kind.digested, 0)
        if kind.name not in self._schemas:
            self._schemas[kind.name] = self._writer.register_schema(*kind.schema())
        number = self._writer.register_channel(topic, kind.encoding, self._schemas[kind.name])
        return _Channel(prefix(topic), kind.digested, number)
