"""Vehicles as TCP servers: clients connect, bytes stream both ways."""

from __future__ import annotations

import asyncio
import errno
import socket
from collections import defaultdict
from collections.abc import Sequence
from functools import partial
from typing import Final, cast

from sim_vehicles.codec import Counts, StreamDecoder
from sim_vehicles.ports import Seat, ServerError, resolve
from sim_vehicles.transport import Receive, Traffic

_FULL: Final = 1 << 20  # bytes a client may leave unread before datagrams are dropped


class TcpPorts:
    """One listening port a vehicle, or one for many; any number of clients on each.

    A client hears every vehicle of its port. What it sends goes to the vehicle that the
    message is addressed to, or to all of the port.

    Args:
        host: address to listen on.
        seats: (n,) id and port of each vehicle; those of one port differ in id.

    Raises:
        ServerError: a port is in use, or there is no such host.
    """

    def __init__(self, host: str, seats: Sequence[Seat]) -> None:
        address = resolve(host)
        self._groups: dict[int, dict[int, int]] = defaultdict(dict)  # port -> system -> index
        for index, seat in enumerate(seats):
            self._groups[seat.port][seat.system] = index
        self._port_of = [seat.port for seat in seats]
        self._clients: dict[int, set[_Client]] = {port: set() for port in self._groups}
        self._listening: dict[int, socket.socket] = {}
        self._servers: list[asyncio.Server] = []
        self.traffic = Traffic()
        try:
            for port in self._groups:
                self._listening[port] = _listen(address, port)
        except ServerError:
            self.close()
            raise

    async def start(self, loop: asyncio.AbstractEventLoop, receive: Receive) -> None:
        for port, opened in self._listening.items():
            group = self._groups[port]
            clients = self._clients[port]
            self._servers.append(
                await loop.create_server(
                    partial(_Client, self, group, clients, receive), sock=opened
                )
            )

    def send(self, index: int, datagram: bytes) -> None:
        for client in self._clients[self._port_of[index]]:
            client.write(datagram)

    def close(self) -> None:
        for server in self._servers:
            server.close()
        for clients in self._clients.values():
            for client in list(clients):
                client.close()
        for opened in self._listening.values():
            opened.close()


class _Client(asyncio.Protocol):
    """One connection."""

    def __init__(
        self, ports: TcpPorts, group: dict[int, int], others: set[_Client], receive: Receive
    ) -> None:
        self._ports = ports
        self._group = group
        self._others = others
        self._receive = receive
        self._decoder = StreamDecoder()
        self._transport: asyncio.Transport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        self._others.add(self)

    def connection_lost(self, exc: Exception | None) -> None:
        self._others.discard(self)

    def data_received(self, data: bytes) -> None:
        traffic = self._ports.traffic
        traffic.datagrams_in += 1
        traffic.bytes_in += len(data)
        counts = Counts()
        packets = self._decoder.feed(data, counts)
        traffic.garbage += counts.garbage
        for packet in packets:
            index = self._group.get(getattr(packet.message, "target_system", 0))
            for vehicle in self._group.values() if index is None else (index,):
                self._receive(vehicle, packet.raw)

    def write(self, datagram: bytes) -> None:
        """Send, unless the client has not read for too long."""
        transport, traffic = self._transport, self._ports.traffic
        if transport is None or transport.get_write_buffer_size() > _FULL:
            traffic.dropped += 1
            return
        transport.write(datagram)
        traffic.datagrams_out += 1
        traffic.bytes_out += len(datagram)

    def close(self) -> None:
        """Hang up."""
        if self._transport is not None:
            self._transport.abort()


def _listen(address: str, port: int) -> socket.socket:
    opened = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        opened.bind((address, port))
        opened.listen()
        opened.setblocking(False)
    except OSError as error:
        opened.close()
        if error.errno == errno.EADDRINUSE:
            raise ServerError(f"TCP port {port} on {address} is in use") from error
        raise ServerError(f"TCP port {port} on {address}: {error.strerror}") from error
    return opened
