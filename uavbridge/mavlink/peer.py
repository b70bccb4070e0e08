"""Where a system is heard from, and who else speaks with its id."""

from __future__ import annotations

from typing import TypeAlias

from sim_vehicles.codec import Counts, decode

Address: TypeAlias = tuple[str, int]


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
