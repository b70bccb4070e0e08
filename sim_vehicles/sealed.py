"""A transport whose datagrams are signed, and that lets in none that are not."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from sim_vehicles.codec.signing import Keyring, Refused, Seal
from sim_vehicles.transport import Receive, Traffic, Transport


class SealedTransport:
    """Wraps a transport.

    Args:
        transport: what carries the datagrams.
        systems: (n,) system id of each vehicle.
        keyring: each vehicle signs, and is spoken to, with its own system's key.
        now_us: tells the date, microseconds since 1970.
    """

    def __init__(
        self,
        transport: Transport,
        systems: Sequence[int],
        keyring: Keyring,
        now_us: Callable[[], int],
    ) -> None:
        self._transport, self._systems = transport, tuple(systems)
        self._seals = [Seal(keyring, now_us) for _ in systems]

    @property
    def traffic(self) -> Traffic:
        return self._transport.traffic

    @property
    def refused(self) -> Refused:
        """What was not let in, of all vehicles."""
        parts = [seal.refused for seal in self._seals]
        return Refused(
            sum(part.unsigned for part in parts),
            sum(part.wrong for part in parts),
            sum(part.replayed for part in parts),
        )

    async def start(self, loop: asyncio.AbstractEventLoop, receive: Receive) -> None:
        def opened(index: int, datagram: bytes) -> None:
            good = self._seals[index].open(datagram, self._systems[index])
            if good:
                receive(index, good)

        await self._transport.start(loop, opened)

    def send(self, index: int, datagram: bytes) -> None:
        sealed = self._seals[index].close(datagram, self._systems[index])
        if sealed:
            self._transport.send(index, sealed)

    def close(self) -> None:
        self._transport.close()
