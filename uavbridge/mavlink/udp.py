"""UDP: a link to one vehicle, and a gate that several share."""

from __future__ import annotations

import errno
import logging
import socket
from collections.abc import Iterator

from uavbridge.errors import LinkError
from uavbridge.mavlink.peer import Address, Peer

logger = logging.getLogger(__name__)

_RECEIVE_BUFFER = 4 << 20  # a busy second of fifty vehicles; the kernel may give less
_LARGEST_DATAGRAM = 65535
_MOST_PER_CALL = 2000  # one flooding sender must not stop the rest


def _open(host: str, port: int, *, bind: bool) -> socket.socket:
    """A non-blocking socket. Raises LinkError naming the port."""
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        opened.setblocking(False)
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
        if bind:
            opened.bind((host, port))
        else:
            opened.connect((host, port))
    except OSError as error:
        opened.close()
        if error.errno == errno.EADDRINUSE:
            raise LinkError(f"UDP port {port} on {host} is in use") from error
        raise LinkError(f"UDP {host}:{port}: {error.strerror or error}") from error
    return opened


def drain(opened: socket.socket) -> Iterator[tuple[bytes, Address]]:
    """Datagrams that arrived at a non-blocking socket, with their senders, oldest first."""
    for _ in range(_MOST_PER_CALL):
        try:
            yield opened.recvfrom(_LARGEST_DATAGRAM)
        except BlockingIOError:
            return
        except ConnectionRefusedError:  # nobody there yet: news of an earlier send
            continue


class UdpLink:
    """One vehicle on one socket.

    ``UdpLink.bind`` waits for the vehicle and answers to where it was last heard;
    ``UdpLink.connect`` speaks first, and listens to that address alone.
    """

    def __init__(
        self, opened: socket.socket, *, connected: bool, system: int | None = None
    ) -> None:
        self._socket = opened
        self._connected = connected
        self.peer = Peer(system)
        self.lost = 0
        """Datagrams that could not be sent: no peer yet, buffer full, nobody there."""

    @classmethod
    def bind(cls, host: str, port: int, system: int | None = None) -> UdpLink:
        """Listen on a port (0: any free one), for a system or for any. Raises LinkError."""
        return cls(_open(host, port, bind=True), connected=False, system=system)

    @classmethod
    def connect(cls, host: str, port: int) -> UdpLink:
        """Speak to an address. Raises LinkError if there is no way to it."""
        return cls(_open(host, port, bind=False), connected=True)

    @property
    def port(self) -> int:
        """The local port."""
        return int(self._socket.getsockname()[1])

    def send(self, data: bytes) -> None:
        try:
            if self._connected:
                self._socket.send(data)
            elif self.peer.address is not None:
                self._socket.sendto(data, self.peer.address)
            else:
                self.lost += 1
        except OSError as error:
            self.lost += 1
            logger.debug("not sent: %s", error)

    def receive(self) -> list[bytes]:
        datagrams = []
        for data, address in drain(self._socket):
            self.peer.heard(address, data)
            datagrams.append(data)
        return datagrams

    def close(self) -> None:
        self._socket.close()


class UdpGate:
    """One bound socket that hears many.

    Args:
        host: local address.
        port: 0: any free one.

    Raises:
        LinkError: the port is in use, or the address is none of ours.
    """

    def __init__(self, host: str, port: int) -> None:
        self._socket = _open(host, port, bind=True)

    @property
    def port(self) -> int:
        return int(self._socket.getsockname()[1])

    def receive(self) -> list[tuple[bytes, Address | None]]:
        return list(drain(self._socket))

    def send(self, data: bytes, address: Address | None) -> bool:
        if address is None:
            return False
        try:
            self._socket.sendto(data, address)
        except OSError as error:
            logger.debug("not sent to %s:%d: %s", *address, error)
            return False
        return True

    def close(self) -> None:
        self._socket.close()
