"""TCP client link: a byte stream cut into frames."""

from __future__ import annotations

import errno
import logging
import os
import socket

from sim_vehicles.codec import Counts, StreamDecoder

logger = logging.getLogger(__name__)

_CHUNK = 1 << 16
_MOST_PER_CALL = 64
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
        self._unsent = b""
        self._decoder = StreamDecoder()
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
        self._unsent = b""
        self._decoder = StreamDecoder()
        if code not in _STARTED:
            self._drop(os.strerror(code))

    def _drop(self, why: str) -> None:
        self.trouble = f"TCP {self._host}:{self._port}: {why}"
        logger.debug("%s", self.trouble)
        if self._socket is not None:
            self._socket.close()
        self._socket = None
        self._connected = False

    def _ready(self) -> socket.socket | None:
        """The connected socket, or None while there is no connection."""
        if self._socket is None and not self._closed:
            self._connect()
        opened = self._socket
        if opened is None or self._connected:
            return opened
        code = opened.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            self._drop(os.strerror(code))
            return None
        try:
            opened.getpeername()
        except OSError:  # still on its way
            return None
        self._connected = True
        self.trouble = ""
        return opened

    def send(self, data: bytes) -> None:
        opened = self._ready()
        if opened is None or len(self._unsent) > _MOST_UNSENT:
            self.lost += 1
            return
        self._unsent += data
        self._flush(opened)

    def _flush(self, opened: socket.socket) -> None:
        try:
            sent = opened.send(self._unsent)
        except BlockingIOError:
            return
        except OSError as error:
            self._drop(error.strerror or str(error))
            return
        self._unsent = self._unsent[sent:]

    def receive(self) -> list[bytes]:
        opened = self._ready()
        if opened is None:
            return []
        if self._unsent:
            self._flush(opened)
        frames: list[bytes] = []
        for _ in range(_MOST_PER_CALL):
            try:
                data = opened.recv(_CHUNK)
            except BlockingIOError:
                break
            except OSError as error:
                self._drop(error.strerror or str(error))
                break
            if not data:
                self._drop("closed by the other side")
                break
            frames += [packet.raw for packet in self._decoder.feed(data, self.counts)]
        return frames

    def close(self) -> None:
        self._closed = True
        self._drop("closed")
