"""TCP server: vehicles, or routers with many behind them, connect to us."""

from __future__ import annotations

import errno
import logging
import socket
from collections.abc import Callable
from functools import partial

from sim_vehicles.codec import Counts
from uavbridge.errors import LinkError
from uavbridge.mavlink.byte_stream import ByteStream
from uavbridge.mavlink.peer import Address

logger = logging.getLogger(__name__)

_CHUNK = 1 << 16
_MOST_UNSENT = 1 << 18  # a client that does not read loses what comes next, as on a radio
_MOST_CLIENTS = 256


class _Client:
    def __init__(self, opened: socket.socket, end: Callable[[str], None], counts: Counts) -> None:
        self.socket = opened
        self.stream = ByteStream(
            lambda: opened.recv(_CHUNK),
            opened.send,
            end,
            ended="closed by the other side",
            counts=counts,
            most_unsent=_MOST_UNSENT,
        )


class TcpGate:
    """Listens; each client's stream is cut into frames.

    Args:
        host: local address.
        port: 0: any free one.

    Raises:
        LinkError: the port is in use, or the address is none of ours.
    """

    def __init__(self, host: str, port: int) -> None:
        self._clients: dict[Address, _Client] = {}
        self.counts = Counts()
        self._server = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            self._server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._server.setblocking(False)
            self._server.bind((host, port))
            self._server.listen()
        except OSError as error:
            self._server.close()
            if error.errno == errno.EADDRINUSE:
                raise LinkError(f"TCP port {port} on {host} is in use") from error
            raise LinkError(f"TCP {host}:{port}: {error.strerror or error}") from error

    @property
    def port(self) -> int:
        return int(self._server.getsockname()[1])

    def receive(self) -> list[tuple[bytes, Address | None]]:
        self._accept()
        frames: list[tuple[bytes, Address | None]] = []
        for address, client in list(self._clients.items()):
            frames += [(frame, address) for frame in client.stream.receive()]
        return frames

    def _accept(self) -> None:
        while len(self._clients) < _MOST_CLIENTS:
            try:
                opened, address = self._server.accept()
            except BlockingIOError:
                return
            except OSError as error:  # it went away again
                logger.debug("not accepted: %s", error)
                return
            opened.setblocking(False)
            opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._clients[address] = _Client(opened, partial(self._drop, address), self.counts)

    def _drop(self, address: Address, why: str) -> None:
        logger.debug("TCP client %s:%d: %s", *address, why)
        client = self._clients.pop(address, None)
        if client is not None:
            client.socket.close()

    def send(self, data: bytes, address: Address | None) -> bool:
        client = None if address is None else self._clients.get(address)
        return client is not None and client.stream.send(data) and address in self._clients

    def close(self) -> None:
        for client in self._clients.values():
            client.socket.close()
        self._clients.clear()
        self._server.close()
