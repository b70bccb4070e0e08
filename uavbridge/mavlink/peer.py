"""Where a system is heard from, and who else speaks with its id."""

from __future__ import annotations

from typing import TypeAlias

from sim_vehicles.codec import Counts, decode

Address: TypeAlias = tuple[str, int]


class Peer:
    """Where one system is heard from: the newest address wins, as after a restart.

    Only a good frame counts, so that garbage from anywhere cannot draw our answers to itself.
    Of two that speak in turns the one that was there first stays.

    Args:
        system: whose frames count; None: any.
        patience: datagrams in a row by which a new address wins.
    """

    __slots__ = ("_former", "_newcomer", "_patience", "_system", "address", "rivals")

    def __init__(self, system: int | None = None, *, patience: int = 1) -> None:
        self._system = system
        self._patience = patience
        self.address: Address | None = None
        self._former: set[Address] = set()
        self._newcomer: tuple[Address, int] | None = None
        self.rivals: frozenset[Address] = frozenset()
        """Addresses that speak in turns: two vehicles use one system id."""

    def heard(self, address: Address, data: bytes) -> bool:
        """A datagram came from an address; False: it is not to be taken, a rival sent it."""
        if address == self.address:
            if self._newcomer is not None:
                self.rivals = frozenset({address, self._newcomer[0]})
                self._newcomer = None
            return True
        if not self._is_theirs(data):
            return not self.rivals
        if self.rivals:
            self.rivals |= {address}
            return False
        if self.address is not None:
            return self._moves(self.address, address)
        self.address = address
        return True

    def _moves(self, old: Address, new: Address) -> bool:
        """Whether it is heard from ``new`` now."""
        known, count = self._newcomer or (new, 0)
        count = count + 1 if known == new else 1
        self._newcomer = (new, count)
        if count < self._patience:
            return False
        self._newcomer = None
        self._former.add(old)
        if new in self._former:
            self.rivals = frozenset({old, new})
        self.address = new
        return True

    def _is_theirs(self, data: bytes) -> bool:
        return any(
            self._system is None or packet.system == self._system
            for packet in decode(data, Counts())
        )
