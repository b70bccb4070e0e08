"""Telemetry logs as autopilot people know them: a .tlog a vehicle.

Each frame that went either way, after its date: 8 bytes, big-endian, Unix
microseconds. MAVProxy, Mission Planner, QGroundControl and pymavlink read it.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from uavbridge.clock import SECOND_US
from uavbridge.recording.digest import StreamDigest, prefix

_DATE = struct.Struct(">Q")
_MAGIC_1, _MAGIC_2 = 0xFE, 0xFD
_SIGNED = 0x01  # incompatibility flag of MAVLink 2: 13 bytes of signature follow

TLOG_PATTERN = "vehicle_*.tlog"

log = logging.getLogger(__name__)


def tlog_name(vehicle: int) -> str:
    """File name of a vehicle's log."""
    return f"vehicle_{vehicle}.tlog"


def frame_length(data: bytes, at: int = 0) -> int:
    """Bytes of the MAVLink frame that starts at ``at`` by its header; 0 where none does."""
    left = len(data) - at
    if left >= 12 and data[at] == _MAGIC_2:
        length = 12 + data[at + 1] + (13 if data[at + 2] & _SIGNED else 0)
    elif left >= 8 and data[at] == _MAGIC_1:
        length = 8 + data[at + 1]
    else:
        return 0
    return length if length <= left else 0


class TlogWriter:
    """Writes one vehicle's log, and keeps its digest.

    Args:
        path: file to write; None: only the digest.
        vehicle: system id, part of the digest.
        epoch_us: Unix date of mission start in microseconds.
        goes_on: keep what the file has; the digest is of what comes now.
    """

    def __init__(
        self, path: Path | None, vehicle: int, epoch_us: int, *, goes_on: bool = False
    ) -> None:
        mode: Literal["ab", "wb"] = "ab" if goes_on else "wb"
        self._file = None if path is None else path.open(mode, buffering=0)
        self._epoch_us = epoch_us
        self._prefix = prefix(f"tlog/{vehicle}")
        self._digest = StreamDigest()
        self._parts: list[bytes] = []
        self._flush_us = 0
        self.frames = 0
        self.noise_bytes = 0  # handed over but not part of any frame, so not written

    def write(self, t_us: int, data: bytes) -> None:
        """Log one frame, or a datagram of several, sent or received at mission time ``t_us``."""
        frames = [data] if data and frame_length(data) == len(data) else self._split(data)
        self.frames += len(frames)
        self._digest.extend(self._prefix, t_us, frames)
        if self._file is not None:
            date = _DATE.pack(self._epoch_us + t_us)
            for frame in frames:
                self._parts += (date, frame)
        if t_us >= self._flush_us:
            self.flush()
            self._flush_us = t_us + SECOND_US

    def flush(self) -> None:
        """Hand everything to the operating system."""
        if self._file is not None and self._parts:
            try:
                self._file.write(b"".join(self._parts))
            except OSError as fault:
                log.warning("%s: %s; the log ends here", self._file.name, fault.strerror)
                self._file.close()
                self._file = None
        self._parts.clear()

    def digest(self) -> bytes:
        """Stream digest (32 bytes) of the frames so far."""
        return self._digest.value()

    def close(self) -> None:
        """Flush and let go of the file."""
        self.flush()
        if self._file is not None:
            self._file.close()
            self._file = None

    def _split(self, data: bytes) -> list[bytes]:
        """The frames of a datagram."""
        at, frames = 0, []
        while length := frame_length(data, at):
            frames.append(data[at : at + length])
            at += length
        if at < len(data):
            self.noise_bytes += len(data) - at
            log.debug("tlog: %d bytes are no MAVLink frame", len(data) - at)
        return frames


def read_tlog(path: Path, epoch_us: int) -> Iterator[tuple[int, bytes]]:
    """Mission times (us) and frames of a log, up to the last whole frame."""
    data = path.read_bytes()
    at = 0
    while length := frame_length(data, at + _DATE.size):
        (date_us,) = _DATE.unpack_from(data, at)
        at += _DATE.size
        yield date_us - epoch_us, data[at : at + length]
        at += length


def tlog_digest(path: Path, vehicle: int, epoch_us: int) -> bytes:
    """Stream digest (32 bytes) of a log on disk."""
    digest = StreamDigest()
    topic = prefix(f"tlog/{vehicle}")
    for t_us, frame in read_tlog(path, epoch_us):
        digest.add(topic, t_us, frame)
    return digest.value()
