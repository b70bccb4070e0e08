"""Writes a mission down while it flies: ``mission.mcap`` and a .tlog a vehicle.

Chunks are handed to the operating system every second of mission time, so that
a killed process leaves a file that reads to within that second. Not for use by
several threads at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from types import TracebackType

from msgspec import Struct

from uavbridge.recording.digest import StreamDigest, combine, prefix
from uavbridge.recording.parts import (
    FORMAT,
    MCAP_NAME,
    METADATA_NAME,
    ONE_FILE,
    PartWriter,
    Rotation,
)
from uavbridge.recording.tlog import TlogWriter, tlog_name
from uavbridge.recording.topics import encode, topic_kind

__all__ = ["MCAP_NAME", "METADATA_NAME", "Recorder"]

FLIGHT, BUS = "flight", "bus"  # where a recording is from


@dataclass(frozen=True, slots=True)
class _Channel:
    prefix: bytes
    digested: bool


class Recorder:
    """Takes every message and frame of one mission.

    Args:
        folder: where the files go; it must be there. None: keep the digest only.
        mission_name: for people; part of the file, not of the digest.
        epoch_ns: Unix date of mission start, for absolute times. Give a fixed one where
            the files shall be equal byte for byte.
        mcap: False: no mission.mcap.
        source: ``FLIGHT``, or ``BUS`` where it holds only what the bus carries.
        rotation: when a new part of mission.mcap begins.
        part: number of the first part to write; above 1 to go on with a recording.

    A file that can be written no more, on a full disk say, is told of in a warning and left
    as it is: the flight goes on.
    """

    def __init__(
        self,
        folder: Path | None,
        *,
        mission_name: str,
        epoch_ns: int,
        mcap: bool = True,
        source: str = FLIGHT,
        rotation: Rotation = ONE_FILE,
        part: int = 1,
    ) -> None:
        self.folder = folder
        self.messages = 0
        self.epoch_ns = epoch_ns
        self._part = part
        self._digest = StreamDigest()
        self._channels: dict[str, _Channel] = {}
        self._tlogs: dict[int, TlogWriter] = {}
        self._parts: PartWriter | None = None
        if mcap and folder is not None:
            metadata = {
                "mission": mission_name,
                "epoch_ns": str(epoch_ns),
                "source": source,
                "version": version("uavbridge"),
                "format": str(FORMAT),
            }
            self._parts = PartWriter(folder, metadata, epoch_ns, rotation, part)

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
            channel = _Channel(prefix(topic), topic_kind(topic).digested)
            self._channels[topic] = channel
        self.messages += 1
        if channel.digested:
            self._digest.add(channel.prefix, t_us, data)
        if self._parts is not None:
            self._parts.write(topic, t_us, data)

    def record(self, topic: str, t_us: int, record: Struct) -> None:
        """Record one of the structs of ``recording.topics``."""
        self.write(topic, t_us, encode(record))

    def tlog(self, vehicle: int) -> TlogWriter:
        """The log of one vehicle, made at the first call."""
        if vehicle not in self._tlogs:
            path = None if self.folder is None else self.folder / tlog_name(vehicle)
            self._tlogs[vehicle] = TlogWriter(
                path, vehicle, self.epoch_ns // 1000, goes_on=self._part > 1
            )
        return self._tlogs[vehicle]

    def digest(self) -> str:
        """SHA-256 in hex over everything so far, as docs/reference/recording.md defines it."""
        tlogs = {vehicle: log.digest() for vehicle, log in self._tlogs.items() if log.frames}
        return combine(self._digest.value(), tlogs)

    def close(self) -> None:
        """Write the index and let go of all files. A second call does nothing."""
        for log in self._tlogs.values():
            log.close()
        if self._parts is not None:
            self._parts.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
