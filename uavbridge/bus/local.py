"""The bus within one process: a hub that hands bytes on at once, in a fixed order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Self

from uavbridge.bus.api import Sample
from uavbridge.bus.matching import check, intersects
from uavbridge.errors import BusError

Answer = Callable[[str], bytes | None]


class LocalHub:
    """What the sessions of one mission share. Subscribers are served in order of subscribing."""

    def __init__(self) -> None:
        self.mailboxes: list[LocalMailbox] = []
        self.watchers: list[LocalMailbox] = []
        self.servers: list[tuple[LocalBus, str, Answer]] = []
        self.tokens: list[tuple[LocalBus, str]] = []
        self._routes: dict[str, list[LocalMailbox]] = {}

    def bus(self) -> LocalBus:
        """A new session."""
        return LocalBus(self)

    def join(self, mailbox: LocalMailbox) -> LocalMailbox:
        """Deliver to a mailbox from now on."""
        self.mailboxes.append(mailbox)
        self._routes.clear()
        return mailbox

    def leave(self, mailbox: LocalMailbox) -> None:
        """Deliver to a mailbox no more."""
        self.mailboxes = [m for m in self.mailboxes if m is not mailbox]
        self.watchers = [m for m in self.watchers if m is not mailbox]
        self._routes.clear()

    def route(self, key: str) -> list[LocalMailbox]:
        """Who gets what is published on ``key``."""
        route = self._routes.get(key)
        if route is None:
            check(key)
            route = [m for m in self.mailboxes if intersects(m.pattern, key)]
            self._routes[key] = route
        return route

    def announce(self, key: str, data: bytes) -> None:
        """Tell the watchers of a token."""
        for watcher in self.watchers:
            if intersects(watcher.pattern, key):
                watcher.samples.append(Sample(key, data))


class LocalMailbox:
    """One subscription's samples."""

    def __init__(self, hub: LocalHub, pattern: str) -> None:
        self.pattern = check(pattern)
        self.samples: list[Sample] = []
        self._hub = hub

    def drain(self) -> list[Sample]:
        samples, self.samples = self.samples, []
        return samples

    def close(self) -> None:
        self._hub.leave(self)


class LocalBus:
    """A session of a ``LocalHub``."""

    def __init__(self, hub: LocalHub) -> None:
        self._hub = hub
        self._mine: list[LocalMailbox] = []
        self._closed = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def publish(self, key: str, data: bytes) -> None:
        sample = Sample(key, data)
        for mailbox in self._open().route(key):
            mailbox.samples.append(sample)

    def subscribe(self, pattern: str) -> LocalMailbox:
        mailbox = self._open().join(LocalMailbox(self._hub, pattern))
        self._mine.append(mailbox)
        return mailbox

    def serve(self, key: str, answer: Answer) -> None:
        self._open().servers.append((self, check(key), answer))

    def query(self, pattern: str, timeout_s: float = 1.0) -> list[Sample]:
        check(pattern)
        answers = []
        for _, key, answer in self._open().servers:
            if intersects(pattern, key) and (data := answer(key)) is not None:
                answers.append(Sample(key, data))
        return sorted(answers)

    def declare(self, key: str) -> None:
        self._open().tokens.append((self, check(key)))
        self._hub.announce(key, b"1")

    def watch(self, pattern: str) -> LocalMailbox:
        mailbox = LocalMailbox(self._open(), pattern)
        mailbox.samples = [Sample(k, b"1") for _, k in self._hub.tokens if intersects(pattern, k)]
        self._hub.watchers.append(mailbox)
        self._mine.append(mailbox)
        return mailbox

    def close(self) -> None:
        if self._closed:
            return
        self._closed = True
        hub = self._hub
        for mailbox in self._mine:
            hub.leave(mailbox)
        hub.servers = [server for server in hub.servers if server[0] is not self]
        gone = [key for bus, key in hub.tokens if bus is self]
        hub.tokens = [token for token in hub.tokens if token[0] is not self]
        for key in gone:
            hub.announce(key, b"")

    def _open(self) -> LocalHub:
        if self._closed:
            raise BusError("the session is closed")
        return self._hub
