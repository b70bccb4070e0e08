"""Vehicles on UDP: each sends from a port of its own, as real ones do."""

from __future__ import annotations

import asyncio
import logging
import resource
import socket
from collections.abc import Sequence
from typing import Final

from sim_vehicles.codec import Counts, decode
from sim_vehicles.ports import Address, ServerError, resolve
from sim_vehicles.transport import Receive, Traffic

_log = logging.getLogger(__name__)
_LARGEST: Final = 65535
_MOST_PER_TURN: Final = 200  # one flooding client must not stop the rest
_MOST_PEERS: Final = 8
_PEER_S: Final = 30.0  # a client that is silent for so long is forgotten
_OTHER_FILES: Final = 64  # descriptors left for everything else


class UdpPorts:
    """One socket a vehicle; telemetry goes to the vehicle's target and to who spoke to it.

    Args:
        host: where telemetry goes to. On loopback only this machine can reach the vehicles.
        ports: (n,) of each vehicle's target; None: it speaks to nobody who has not spoken to it.

    Raises:
        ServerError: no such host, or too many sockets for this machine.
    """

    def __init__(self, host: str, ports: Sequence[int | None]) -> None:
        address = resolve(host)
        local = "127.0.0.1" if address.startswith("127.") else ""
        self._targets: list[Address | None] = [
            None if port is None else (address, port) for port in ports
        ]
        self._peers: list[dict[Address, float]] = [{} for _ in ports]  # -> when heard last
        self._sockets: list[socket.socket] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self.traffic = Traffic()
        _allow_files(len(ports) + _OTHER_FILES)
        try:
            for _ in ports:
                opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                self._sockets.append(opened)
                opened.setblocking(False)
                opened.bind((local, 0))
        except OSError as error:
            self.close()
            raise ServerError(f"UDP socket {len(self._sockets)}: {error.strerror}") from error

    @property
    def local_ports(self) -> list[int]:
        """The port that each vehicle sends from."""
        return [int(opened.getsockname()[1]) for opened in self._sockets]

    async def start(self, loop: asyncio.AbstractEventLoop, receive: Receive) -> None:
        self._loop = loop
        for index, opened in enumerate(self._sockets):
            loop.add_reader(opened, self._drain, index, opened, receive)

    def _drain(self, index: int, opened: socket.socket, receive: Receive) -> None:
        traffic = self.traffic
        for _ in range(_MOST_PER_TURN):
            try:
                data, sender = opened.recvfrom(_LARGEST)
            except BlockingIOError:
                return
            except OSError as error:  # news of an earlier send
                _log.debug("vehicle %d: %s", index, error)
                continue
            traffic.datagrams_in += 1
            traffic.bytes_in += len(data)
            if sender != self._targets[index]:
                self._heard(index, sender, data)
            receive(index, data)

    def _heard(self, index: int, sender: Address, data: bytes) -> None:
        """Remember who speaks MAVLink; the one silent for longest makes room."""
        peers = self._peers[index]
        if sender not in peers and not decode(data, Counts()):
            return
        if self._loop is not None:
            peers[sender] = self._loop.time()
        if len(peers) > _MOST_PEERS:
            del peers[min(peers, key=peers.__getitem__)]

    def send(self, index: int, datagram: bytes) -> None:
        target = self._targets[index]
        if target is not None:
            self._send(index, datagram, target)
        peers = self._peers[index]
        if peers and self._loop is not None:
            oldest = self._loop.time() - _PEER_S
            for peer, heard in list(peers.items()):
                if heard < oldest:
                    del peers[peer]
                else:
                    self._send(index, datagram, peer)

    def _send(self, index: int, datagram: bytes, target: Address) -> None:
        try:
            self._sockets[index].sendto(datagram, target)
        except OSError as error:  # full, unreachable, forbidden: lost, as on a radio
            self.traffic.dropped += 1
            _log.debug("vehicle %d to %s:%d: %s", index, *target, error)
        else:
            self.traffic.datagrams_out += 1
            self.traffic.bytes_out += len(datagram)

    def close(self) -> None:
        for opened in self._sockets:
            if self._loop is not None:
                self._loop.remove_reader(opened)
            opened.close()
        self._sockets.clear()


def _allow_files(wanted: int) -> None:
    """Raise this process' own limit of open files as far as ``wanted``, if it may."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY or soft >= wanted:
        return
    if hard != resource.RLIM_INFINITY and hard < wanted:
        raise ServerError(f"{wanted} open files are needed, the limit is {hard} (ulimit -n)")
    resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
