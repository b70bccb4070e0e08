"""Serial devices: a telemetry radio or a flight controller on USB."""

from __future__ import annotations

import logging
import os
import re
import termios
from functools import cache

from sim_vehicles.codec import Counts
from uavbridge.errors import LinkError
from uavbridge.mavlink.byte_stream import ByteStream

logger = logging.getLogger(__name__)

_CHUNK = 1 << 14
_MOST_UNSENT = 1 << 14  # two seconds at 57600 baud; what comes next is lost, as on a radio


@cache
def speeds() -> dict[int, int]:
    """Baud rates of this system -> termios's constants, ascending."""
    names = (re.fullmatch(r"B(\d+)", name) for name in dir(termios))
    found = {int(match[1]): int(getattr(termios, match[0])) for match in names if match}
    return dict(sorted(found.items()))


class SerialLink:
    """One serial device, 8N1 without flow control; opened again when it was unplugged.

    Each datagram of ``receive`` is one whole frame.

    Args:
        device: such as /dev/ttyUSB0.
        baud: one of ``speeds``.

    Raises:
        LinkError: it is not there, or may not be opened.
    """

    def __init__(self, device: str, baud: int) -> None:
        self._device, self._baud = device, baud
        self._closed = False
        self.counts = Counts()
        self.lost = 0
        self.trouble = ""
        self._file = self._open()
        if self._file < 0:
            raise LinkError(self.trouble)

    def _open(self) -> int:
        """A descriptor; -1 with the reason in ``trouble``."""
        try:
            opened = os.open(self._device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            self.trouble = f"serial {self._device}: {error.strerror}"
            return -1
        try:
            self._make_raw(opened)
        except termios.error as error:
            os.close(opened)
            self.trouble = f"serial {self._device}: no serial device ({error.args[-1]})"
            return -1
        self.trouble = ""
        self._stream = ByteStream(
            lambda: os.read(opened, _CHUNK),
            lambda data: os.write(opened, data),
            self._drop,
            ended="unplugged",
            counts=self.counts,
            most_unsent=_MOST_UNSENT,
        )
        return opened

    def _make_raw(self, opened: int) -> None:
        speed = speeds()[self._baud]
        control = termios.tcgetattr(opened)[6]
        # nothing there is then an error, and an empty read means: unplugged
        control[termios.VMIN], control[termios.VTIME] = 1, 0
        flags = termios.CS8 | termios.CREAD | termios.CLOCAL
        termios.tcsetattr(opened, termios.TCSANOW, [0, 0, flags, 0, speed, speed, control])

    def _ready(self) -> bool:
        if self._file < 0 and not self._closed:
            self._file = self._open()
        return self._file >= 0

    def _drop(self, why: str) -> None:
        self.trouble = f"serial {self._device}: {why}"
        logger.debug("%s", self.trouble)
        if self._file >= 0:
            os.close(self._file)
        self._file = -1

    def send(self, data: bytes) -> None:
        if not self._ready() or not self._stream.send(data):
            self.lost += 1

    def receive(self) -> list[bytes]:
        return self._stream.receive() if self._ready() else []

    def close(self) -> None:
        self._closed = True
        self._drop("closed")
