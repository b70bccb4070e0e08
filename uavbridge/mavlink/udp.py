"""UDP links: one socket for one vehicle, or one socket shared by several."""

from __future__ import annotations

import errno
import logging
import socket
from collections.abc import Iterator
from typing import TypeAlias

from sim_vehicles.codec import Counts, decode
from uavbridge.errors import LinkError
from uavbridge.mavlink.frames import by_system

logger = logging.getLogger(__name__)

Address: TypeAlias = tuple[str, int]

_RECEIVE_BUFFER = 4 << 20  # a busy second of fifty vehicles; the kernel may give less
_LARGEST_DATAGRAM = 65535
_MOST_PER_CALL = 2000  # one flooding sender must not stop the rest


class Peer:
    """Where one system is heard from: the newest address wins, as after a restart.

    Only a good frame counts, so that garbage from anywhere cannot draw our answers to itself.

    Args:
        system: whose frames count; None: any.
    """

    __slots__ = ("_former", "_system", "address", "rivals")

    def __init__(self, system: int | None = None) -> None:
        self._system = system
        self.address: Address | None = None
        self._former: set[Address] = set()
        self.rivals: frozenset[Address] = frozenset()
        """Addresses that speak in turns: two vehicles use one system id."""

    def heard(self, address: Address, data: bytes) -> None:
        """A datagram came from an address."""
        if address == self.address or not self._is_theirs(data):
            return
        if self.address is not None:
            self._former.add(self.address)
            if address in self._former:
                self.rivals |= {address, self.address}
        self.address = address

    def _is_theirs(self, data: bytes) -> bool:
        return any(
            self._system is None or packet.system == self._system
            for packet in decode(data, Counts())
        )


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


def _drain(opened: socket.socket) -> Iterator[tuple[bytes, Address]]:
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
        for data, address in _drain(self._socket):
            self.peer.heard(address, data)
            datagrams.append(data)
        return datagrams

    def close(self) -> None:
        self._socket.close()


class UdpHub:
    """One bound socket shared by several vehicles, told apart by system id.

    ``channel(system)`` gives the link of one of them. Any channel's ``receive``
    reads the socket for all.
    """

    def __init__(self, host: str, port: int) -> None:
        self._socket = _open(host, port, bind=True)
        self._inboxes: dict[int, list[bytes]] = {}
        self._peers: dict[int, Peer] = {}
        self._users = 0
        self.noise = 0
        """Datagrams that begin with no whole frame."""

    @property
    def port(self) -> int:
        """The local port."""
        return int(self._socket.getsockname()[1])

    @property
    def peers(self) -> dict[int, Peer]:
        """Who was heard, by system id; those without a channel too."""
        return dict(self._peers)

    def channel(self, system: int) -> UdpChannel:
        """The link of one system; one channel for each. Raises LinkError for a second."""
        if system in self._inboxes:
            raise LinkError(f"UDP port {self.port}: system {system} has a link already")
        self._inboxes[system] = []
        return UdpChannel(self, system)

    def send(self, system: int, data: bytes) -> bool:
        """Send to where a system was last heard; False if it could not be sent."""
        peer = self._peers.get(system)
        if peer is None or peer.address is None:
            return False
        try:
            self._socket.sendto(data, peer.address)
        except OSError as error:
            logger.debug("not sent to system %d: %s", system, error)
            return False
        return True

    def receive(self, system: int) -> list[bytes]:
        """Read the socket, sort what came, and give what is for one system."""
        for data, address in _drain(self._socket):
            parts = by_system(data)
            if not parts:
                self.noise += 1
            for sender, part in parts:
                peer = self._peers.get(sender)
                if peer is None:
                    peer = self._peers[sender] = Peer(sender)
                peer.heard(address, part)
                inbox = self._inboxes.get(sender)
                if inbox is not None:
                    inbox.append(part)
        collected = self._inboxes.get(system)
        if not collected:
            return []
        self._inboxes[system] = []
        return collected

    def release(self, system: int) -> None:
        """Forget a channel; the last one closes the socket."""
        if self._inboxes.pop(system, None) is not None and not self._inboxes:
            self._socket.close()

    def close(self) -> None:
        """Close the socket under all channels."""
        self._inboxes.clear()
        self._socket.close()


class UdpChannel:
    """One system's link on a shared socket."""

    def __init__(self, hub: UdpHub, system: int) -> None:
        self._hub = hub
        self._system = system
        self._open = True
        self.lost = 0

    @property
    def peer(self) -> Peer:
        """Where this system is heard from."""
        return self._hub.peers.get(self._system, Peer())

    def send(self, data: bytes) -> None:
        if not (self._open and self._hub.send(self._system, data)):
            self.lost += 1

    def receive(self) -> list[bytes]:
        return self._hub.receive(self._system) if self._open else []

    def close(self) -> None:
        if self._open:
            self._open = False
            self._hub.release(self._system)
