"""The transport seam: datagrams between vehicles and whoever listens."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
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
