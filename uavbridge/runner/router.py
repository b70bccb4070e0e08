"""A zenoh router in a process of its own: ``uavbridge router``.

A launcher whose agents fly in other processes has its router there too, so that they go on
hearing each other when it dies.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from typing import Self

from uavbridge.bus.zenoh_bus import Router
from uavbridge.clock import pause, wall_s
from uavbridge.errors import BusError
from uavbridge.runner.child import end, spawn

GOODBYE = "end"
IDLE_S = 5.0  # without a parent it ends when no client was there for so long
_LOOK_S = 0.2


class RouterProcess:
    """A router as a child process.

    Args:
        listen: as for ``Router``.

    Attributes:
        endpoint: where clients find it.

    Raises:
        BusError: as ``Router``.
    """

    def __init__(self, listen: str = "auto") -> None:
        self._process: subprocess.Popen[bytes] = spawn(
            ["uavbridge", "router", f"--listen={listen}", "--lingers"], errors=subprocess.PIPE
        )
        assert self._process.stdout is not None
        self.endpoint = self._process.stdout.readline().decode().strip()
        if not self.endpoint:
            assert self._process.stderr is not None
            said = self._process.stderr.read().decode().strip().removeprefix("error: ")
            end(self._process)
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
    lingers: bool,
    stop: Callable[[], bool],
    ready: Callable[[str], None],
) -> None:
    """Route until ``stop``, or for a parent until it says goodbye or everybody has left.

    Args:
        listen: as for ``Router``.
        connect: other routers to link to.
        lingers: it has a parent, on standard input.
        stop: asked a few times a second.
        ready: told the endpoint.
    """
    parent = _Parent() if lingers else None
    with Router(listen, connect=connect) as router:
        ready(router.endpoint)
        busy_s = wall_s()
        while not stop() and not (parent and parent.said_goodbye):
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
