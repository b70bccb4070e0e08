"""The link seam: bytes to and from one peer, never blocking."""

from __future__ import annotations

from collections import deque
from typing import Protocol


class Link(Protocol):
    """Carries datagrams. A middleware wraps a link and is a link."""

    def send(self, data: bytes) -> None:
        """Hand over one datagram; what can not be sent is lost, as on a radio."""
        ...

    def receive(self) -> list[bytes]:
        """Datagrams that arrived since the last call, oldest first."""
        ...

    def close(self) -> None:
        """Let go of the port."""
        ...


class MemoryLink:
    """One end of a pair in one process; see ``memory_pair``."""

    def __init__(self, outbox: deque[bytes], inbox: deque[bytes]) -> None:
        self._outbox, self._inbox = outbox, inbox

    def send(self, data: bytes) -> None:
        self._outbox.append(data)

    def receive(self) -> list[bytes]:
        datagrams = list(self._inbox)
        self._inbox.clear()
        return datagrams

    def close(self) -> None:
        self._inbox.clear()


def memory_pair() -> tuple[MemoryLink, MemoryLink]:
    """Two ends joined in memory: what one sends, the other receives, in order."""
    there: deque[bytes] = deque()
    back: deque[bytes] = deque()
    return MemoryLink(there, back), MemoryLink(back, there)
