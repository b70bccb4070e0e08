"""One socket or device shared by several vehicles, told apart by system id."""

from __future__ import annotations

from collections import deque
from typing import Final, Protocol

from sim_vehicles.codec.signing import Seal
from uavbridge.errors import LinkError
from uavbridge.mavlink.frames import by_system
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.peer import Address, Peer

_KEPT: Final = 512  # parts of a datagram kept for a system that nobody has asked for yet
_STEADY: Final = 3  # datagrams in a row that show that a vehicle moved, and has no twin
_OURS: Final = range(251, 256)  # system ids of ground stations, which we do not listen to


class Gate(Protocol):
    """Carries datagrams to and from many, where there are addresses with the sender's."""

    @property
    def port(self) -> int:
        """The local port; 0 where there is none."""
        ...

    def receive(self) -> list[tuple[bytes, Address | None]]:
        """What arrived since the last call, oldest first."""
        ...

    def send(self, data: bytes, address: Address | None) -> bool:
        """Send to an address, for None to all that need none; False: it could not be sent."""
        ...

    def close(self) -> None:
        """Let go of it."""
        ...


class LinkGate:
    """A link to one place (UDP or TCP client, serial device) behind which there may be many."""

    def __init__(self, link: Link) -> None:
        self.link = link

    @property
    def port(self) -> int:
        return 0

    def receive(self) -> list[tuple[bytes, Address | None]]:
        return [(data, None) for data in self.link.receive()]

    def send(self, data: bytes, address: Address | None) -> bool:
        self.link.send(data)
        return True

    def close(self) -> None:
        self.link.close()


class Hub:
    """A gate shared by several vehicles.

    ``channel(system)`` gives the link of one of them. Any channel's ``receive`` reads the
    gate for all. What comes from systems without a channel waits, a little of it, for
    ``take``.

    Args:
        gate: what carries the datagrams; closed with the last channel.
        name: of it, for messages.
        seal: signs what goes out and lets in only what is signed; None: neither.
    """

    def __init__(self, gate: Gate, name: str, seal: Seal | None = None) -> None:
        self.name = name
        self.seal = seal
        self._gate = gate
        self._inboxes: dict[int, list[bytes]] = {}
        self._unasked: dict[int, deque[bytes]] = {}
        self._peers: dict[int, Peer] = {}
        self.noise = 0
        """Datagrams that begin with no whole frame."""

    @property
    def port(self) -> int:
        """The local port."""
        return self._gate.port

    @property
    def trouble(self) -> str:
        """Why there is no connection; empty where there is one, or where nothing is known."""
        link = self._gate.link if isinstance(self._gate, LinkGate) else None
        return str(getattr(link, "trouble", ""))

    @property
    def peers(self) -> dict[int, Peer]:
        """Who was heard, by system id; those without a channel too."""
        return dict(self._peers)

    def channel(self, system: int) -> HubChannel:
        """The link of one system; one channel for each. Raises LinkError for a second."""
        if system in self._inboxes:
            raise LinkError(f"{self.name}: system {system} has a link already")
        self._inboxes[system] = list(self._unasked.pop(system, ()))
        return HubChannel(self, system)

    def send(self, system: int, data: bytes) -> bool:
        """Send to where a system was last heard; False if it could not be sent."""
        peer = self._peers.get(system)
        if self.seal is not None:
            data = self.seal.close(data, system)
        return bool(data) and self._gate.send(data, None if peer is None else peer.address)

    def call(self, data: bytes) -> None:
        """Send to everybody who was heard, and to where nobody has to be heard first."""
        if not self._peers:
            self._gate.send(data if self.seal is None else self.seal.close(data, 0), None)
        for system in self._peers:
            self.send(system, data)

    def read(self) -> None:
        """Read the gate and sort what came."""
        for data, address in self._gate.receive():
            parts = by_system(data)
            if not parts:
                self.noise += 1
            for sender, part in parts:
                good = part if self.seal is None else self.seal.open(part)
                if good:
                    self._sort(sender, good, address)

    def _sort(self, sender: int, part: bytes, address: Address | None) -> None:
        if sender in _OURS:
            return
        peer = self._peers.get(sender)
        if peer is None:
            peer = self._peers[sender] = Peer(sender, patience=_STEADY)
        if address is not None and not peer.heard(address, part):
            return
        inbox = self._inboxes.get(sender)
        if inbox is not None:
            inbox.append(part)
        else:
            self._unasked.setdefault(sender, deque(maxlen=_KEPT)).append(part)

    def receive(self, system: int) -> list[bytes]:
        """Read the gate, sort what came, and give what is for one system's channel."""
        self.read()
        collected = self._inboxes.get(system)
        if not collected:
            return []
        self._inboxes[system] = []
        return collected

    def take(self) -> dict[int, list[bytes]]:
        """What waits of systems without a channel, by system id; it waits no longer."""
        unasked, self._unasked = self._unasked, {}
        return {system: list(parts) for system, parts in unasked.items()}

    def release(self, system: int) -> None:
        """Forget a channel; the last one closes the gate."""
        if self._inboxes.pop(system, None) is not None and not self._inboxes:
            self._gate.close()

    def close(self) -> None:
        """Close the gate under all channels."""
        self._inboxes.clear()
        self._gate.close()


class HubChannel:
    """One system's link on a shared gate."""

    def __init__(self, hub: Hub, system: int) -> None:
        self._hub = hub
        self._system = system
        self._open = True
        self.lost = 0

    @property
    def peer(self) -> Peer:
        """Where this system is heard from."""
        return self._hub.peers.get(self._system, Peer())

    def twins(self) -> tuple[str, ...]:
        """Where this system is heard from, if from more than one place."""
        return tuple(f"{host}:{port}" for host, port in sorted(self.peer.rivals))

    def send(self, data: bytes) -> None:
        if not (self._open and self._hub.send(self._system, data)):
            self.lost += 1

    def receive(self) -> list[bytes]:
        return self._hub.receive(self._system) if self._open else []

    def close(self) -> None:
        if self._open:
            self._open = False
            self._hub.release(self._system)
