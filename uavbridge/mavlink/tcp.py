"""TCP client link: a byte stream cut into frames."""

from __future__ import annotations

import errno
import logging
import os
import socket

from sim_vehicles.codec import Counts
from uavbridge.mavlink.byte_stream import ByteStream

logger = logging.getLogger(__name__)

_CHUNK = 1 << 16
_MOST_UNSENT = 1 << 18  # a peer that does not read loses what comes next, as on a radio
_STARTED = (0, errno.EINPROGRESS, errno.EWOULDBLOCK, errno.EISCONN)


class TcpLink:
    """Connects without waiting, and again whenever the connection ends.

    ``trouble`` says why there is no connection; empty while there is one. Each
    datagram of ``receive`` is one whole frame.
    """

    def __init__(self, host: str, port: int) -> None:
        self._host, self._port = host, port
        self._socket: socket.socket | None = None
        self._connected = False
        self._closed = False
        self.counts = Counts()
        self.lost = 0
        self.trouble = "not connected yet"
        self._connect()

    def _connect(self) -> None:
        opened = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        opened.setblocking(False)
        opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            code = opened.connect_ex((self._host, self._port))
        except OSError as error:  # a name that does not resolve
            opened.close()
            self.trouble = f"TCP {self._host}:{self._port}: {error.strerror or error}"
            return
        self._socket = opened
        self._connected = False
        self._stream = ByteStream(
            lambda: opened.recv(_CHUNK),
            opened.send,
            self._drop,
            ended="closed by the other side",
            counts=self.counts,
            most_unsent=_MOST_UNSENT,
        )
        if code not in _STARTED:
            self._drop(os.strerror(code))

    def _drop(self, why: str) -> None:
        self.trouble = f"TCP {self._host}:{self._port}: {why}"
        logger.debug("%s", self.trouble)
        if self._socket is not None:
            self._socket.close()
        self._socket = None
        self._connected = False

    def _ready(self) -> bool:
        """There is a connection."""
        if self._socket is None and not self._closed:
            self._connect()
        opened = self._socket
        if opened is None or self._connected:
            return self._connected
        code = opened.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            self._drop(os.strerror(code))
            return False
        try:
            opened.getpeername()
        except OSError:  # still on its way
            return False
        self._connected = True
        self.trouble = ""
        return True

    def send(self, data: bytes) -> None:
        if not self._ready() or not self._stream.send(data):
            self.lost += 1

    def receive(self) -> list[bytes]:
        return self._stream.receive() if self._ready() else []

    def close(self) -> None:
        self._closed = True
        self._drop("closed")
