"""Pages of a mission on a bus, of a recording, and beside a launcher.

Imports neither starlette nor uvicorn before one is served, so that who lacks the extra is told.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from uavbridge.bus.security import Identity
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.errors import ConfigError
from uavbridge.monitor.replayed import Player
from uavbridge.monitor.source import Live, Recorded, Source
from uavbridge.runner.child import end, spawn

LOOPBACK = "127.0.0.1"
TOKEN = "UAVBRIDGE_TOKEN"  # environment: unlike arguments, not for everybody to read
_NEEDED = ("starlette", "uvicorn", "websockets")


@dataclass(frozen=True, slots=True)
class Place:
    """Where a page is served: address, port (0: any free one), and the token to ask for."""

    host: str = LOOPBACK
    port: int = 0
    token: str | None = None


def check_extra() -> None:
    """Raise ConfigError where the extra is not installed."""
    if any(find_spec(name) is None for name in _NEEDED):
        raise ConfigError("--web: needs the extra: pip install 'uavbridge[web]'")


def check(place: Place) -> None:
    """Raise ConfigError where no page can be served, before anything takes its time."""
    check_extra()
    from uavbridge.monitor.web.guard import check_token

    check_token(place.host, place.token)


def serve_live(
    router: str,
    mission: str,
    place: Place,
    ready: Callable[[str], None],
    stop: Callable[[], bool] = lambda: False,
    *,
    identity: Identity | None = None,
) -> None:
    """Serve the page of a mission on a bus until Ctrl-C.

    Raises:
        BusError: no router.
        ConfigError, LinkError: as ``server.serve`` does.
    """
    check_extra()
    with ZenohBus(router, mission, identity=identity) as bus:
        _serve(Live(bus, mission, connected=lambda: bus.connected), place, ready, stop)


def serve_recording(player: Player, place: Place, ready: Callable[[str], None]) -> None:
    """Serve the page of a recording until Ctrl-C.

    Raises:
        ConfigError: as ``server.serve`` does.
        LinkError: the port cannot be listened on.
    """
    check_extra()
    _serve(Recorded(player), place, ready, lambda: False)


@contextmanager
def beside(
    router: str, mission: str, ready: Callable[[str], None], identity: Identity | None = None
) -> Iterator[None]:
    """Serve a mission's page on loopback from a process of its own, as long as the context lasts.

    A page with many vehicles takes time that the launcher's control loop must not lack.

    Args:
        router: its endpoint.
        mission: its name.
        ready: is told the page's address.
        identity: of the page's session, where the router asks for one.

    Raises:
        ConfigError: the page cannot be served; the process has told why on standard error.
    """
    check_extra()
    who = [] if identity is None else [str(identity.folder)]
    process = spawn(["uavbridge.monitor.web", router, mission, *who])
    assert process.stdout is not None
    try:
        address = process.stdout.readline().decode().strip()
        if not address:
            raise ConfigError("--web: the page could not be served")
        ready(address)
        yield
    finally:
        end(process)


def child(arguments: list[str]) -> None:
    """The process behind ``beside``: prints the address, ends when standard input does."""
    router, mission, *who = arguments
    ended = threading.Event()

    def watch() -> None:
        sys.stdin.read()
        ended.set()

    threading.Thread(target=watch, daemon=True).start()
    place = Place(token=os.environ.get(TOKEN))
    identity = Identity(Path(who[0])) if who else None
    serve_live(router, mission, place, _tell, ended.is_set, identity=identity)


def _tell(address: str) -> None:
    sys.stdout.write(address + "\n")
    sys.stdout.flush()


def _serve(
    source: Source, place: Place, ready: Callable[[str], None], stop: Callable[[], bool]
) -> None:
    from uavbridge.monitor.web.server import serve

    serve(source, host=place.host, port=place.port, token=place.token, ready=ready, stop=stop)
