"""The bus seam: keys, bytes, mailboxes. Nothing here blocks but ``query``."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol


class Sample(NamedTuple):
    """One thing that was published."""

    key: str
    data: bytes


class Mailbox(Protocol):
    """What a subscription has collected."""

    def drain(self) -> list[Sample]:
        """All samples since the last call, in order of arrival."""
        ...

    def close(self) -> None:
        """Collect no more; what is left may still be drained."""
        ...


class Bus(Protocol):
    """Publish, subscribe, answer and ask, by key expressions in zenoh's syntax.

    Keys are given relative to the mission's prefix (``uavbridge/<mission>/``).
    """

    def publish(self, key: str, data: bytes) -> None:
        """Send to every matching subscription, this process's own included."""
        ...

    def subscribe(self, pattern: str) -> Mailbox:
        """Collect everything that matches, from now on."""
        ...

    def serve(self, key: str, answer: Callable[[str], bytes | None]) -> None:
        """Answer queries on ``key``, which names one key.

        ``answer`` gets the key, may run on another thread, and must return quickly;
        None is no answer.
        """
        ...

    def query(self, pattern: str, timeout_s: float = 1.0) -> list[Sample]:
        """Ask everybody who serves a matching key; the answers, by key."""
        ...

    def declare(self, key: str) -> None:
        """A liveliness token that dies with this session."""
        ...

    def watch(self, pattern: str) -> Mailbox:
        """Collect the comings and goings of liveliness tokens.

        A sample ``b"1"`` for each that is there or comes, ``b""`` for each that is gone.
        """
        ...

    def close(self) -> None:
        """End the session and everything declared on it."""
        ...
