"""The transport seam: datagrams between vehicles and whoever listens."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Protocol, TypeAlias

Receive: TypeAlias = Callable[[int, bytes], None]
"""Takes what arrived for a vehicle: its index and the datagram."""


@dataclass(slots=True)
class Traffic:
    """What went over the wire; numbers only grow."""

    datagrams_in: int = 0
    bytes_in: int = 0
    datagrams_out: int = 0
    bytes_out: int = 0
    dropped: int = 0  # datagrams that a full buffer or the network refused
    garbage: int = 0  # pieces of streams that never became a frame


class Transport(Protocol):
    """Carries datagrams for all vehicles; never blocks."""

    @property
    def traffic(self) -> Traffic:
        """Counts so far."""
        ...

    async def start(self, loop: asyncio.AbstractEventLoop, receive: Receive) -> None:
        """Begin to hand what arrives to ``receive``, in the loop's thread."""
        ...

    def send(self, index: int, datagram: bytes) -> None:
        """Send for vehicle ``index``; what can not be sent now is dropped and counted."""
        ...

    def close(self) -> None:
        """Let go of all ports. May be called twice."""
        ...


class Both:
    """Two transports as one: what vehicles send goes out on both, and they hear both."""

    def __init__(self, first: Transport, second: Transport) -> None:
        self._parts = first, second

    @property
    def traffic(self) -> Traffic:
        """Sums of both."""
        first, second = (part.traffic for part in self._parts)
        names = [each.name for each in fields(Traffic)]
        return Traffic(**{name: getattr(first, name) + getattr(second, name) for name in names})

    async def start(self, loop: asyncio.AbstractEventLoop, receive: Receive) -> None:
        for part in self._parts:
            await part.start(loop, receive)

    def send(self, index: int, datagram: bytes) -> None:
        for part in self._parts:
            part.send(index, datagram)

    def close(self) -> None:
        for part in self._parts:
            part.close()
