"""A zenoh router in a process of its own: ``uavbridge router``.

A launcher whose agents fly in other processes has its router there too, so that they go on
hearing each other when it dies.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import IO, Self

from uavbridge.bus import keys
from uavbridge.bus.refusals import Refusal, RefusalLog
from uavbridge.bus.security import Identity
from uavbridge.bus.zenoh_bus import Router, log_refusals
from uavbridge.clock import pause, wall_s
from uavbridge.errors import BusError
from uavbridge.recording.topics import EventRecord, encode
from uavbridge.runner.child import end, spawn

GOODBYE = "end"
IDLE_S = 5.0  # without a parent it ends when no client was there for so long
_LOOK_S = 0.2


class RouterProcess:
    """A router as a child process.

    Args:
        listen: as for ``Router``.
        identity: likewise.

    Attributes:
        endpoint: where clients find it.

    Raises:
        BusError: as ``Router``.
    """

    def __init__(self, listen: str = "auto", identity: Identity | None = None) -> None:
        guarded = [] if identity is None else [f"--keys={identity.folder}"]
        self._process: subprocess.Popen[bytes] = spawn(
            ["uavbridge", "router", f"--listen={listen}", "--lingers", *guarded],
            errors=subprocess.PIPE,
        )
        assert self._process.stdout is not None
        self.endpoint = self._process.stdout.readline().decode().strip()
        if not self.endpoint:
            assert self._process.stderr is not None
            said = self._process.stderr.read().decode().strip().removeprefix("error: ")
            self.close()
            raise BusError(said or "the router could not start")

    def close(self) -> None:
        """Stop routing; clients wait for another."""
        end(self._process, f"{GOODBYE}\n".encode())
        assert self._process.stderr is not None
        self._process.stderr.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def route(
    listen: str,
    connect: Sequence[str],
    *,
    identity: Identity | None,
    lingers: bool,
    stop: Callable[[], bool],
    ready: Callable[[str], None],
) -> None:
    """Route until ``stop``, or for a parent until it says goodbye or everybody has left.

    Args:
        listen: as for ``Router``.
        connect: other routers to link to.
        identity: as for ``Router``; whom it refuses is told on ``world/refused``.
        lingers: it has a parent, on standard input.
        stop: asked a few times a second.
        ready: told the endpoint, and whom it refuses.
    """
    parent = _Parent() if lingers else None
    with (
        _refusals(identity) as refused,
        Router(listen, connect=connect, identity=identity) as router,
    ):
        ready(router.endpoint)
        busy_s = wall_s()
        while not stop() and not (parent and parent.said_goodbye):
            for text in refused.news():
                ready(text)
                if identity is not None:
                    record = EventRecord("refused", text)
                    router.tell(identity.access().mission, keys.REFUSED, encode(record))
            if router.clients:
                busy_s = wall_s()
            if parent and parent.gone and wall_s() - busy_s > IDLE_S:
                return
            pause(_LOOK_S)


class _Parent:
    """Who started this process, by its standard input."""

    def __init__(self) -> None:
        self.gone = False
        self.said_goodbye = False
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        for line in sys.stdin:
            if line.strip() == GOODBYE:
                self.said_goodbye = True
        self.gone = True


class _Refused:
    """Reads zenoh's log as it is written."""

    def __init__(self) -> None:
        self._log = RefusalLog()
        self._told: Counter[Refusal] = Counter()
        self._lock = threading.Lock()

    def read(self, stream: IO[str]) -> None:
        """Until its end; on a thread of its own."""
        for line in stream:
            with self._lock:
                self._log.feed(line)

    def news(self) -> list[str]:
        """What was refused since the last call, a line for each kind."""
        with self._lock:
            counts = self._log.counts.copy()
        fresh = [refusal for refusal in counts if counts[refusal] != self._told[refusal]]
        self._told = counts
        return [_line(refusal, counts[refusal]) for refusal in sorted(fresh)]


def _line(refusal: Refusal, count: int) -> str:
    who, what, key = refusal
    tried = f"{who}: {what} on {key}" if key else f"a session: {what}"
    return f"refused {tried} ({count} in all)"


@contextmanager
def _refusals(identity: Identity | None) -> Iterator[_Refused]:
    """Zenoh's log goes to standard output: it gets a pipe there, and what we say goes past it."""
    refused = _Refused()
    if identity is None:
        yield refused
        return
    log_refusals()
    ours = os.dup(sys.stdout.fileno())
    reading, writing = os.pipe()
    os.dup2(writing, sys.stdout.fileno())
    os.close(writing)
    sys.stdout = os.fdopen(ours, "w", buffering=1)
    threading.Thread(
        target=refused.read, args=(os.fdopen(reading, errors="replace"),), daemon=True
    ).start()
    yield refused
