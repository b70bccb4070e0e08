"""Serves the page and feeds it: one websocket a page, one loop that takes in the mission."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from importlib.resources import files

import msgspec
import uvicorn
from starlette.applications import Starlette
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from uavbridge.agent.orders import Verb
from uavbridge.bus.text import read
from uavbridge.clock import to_us, wall_s
from uavbridge.errors import LinkError, UavbridgeError
from uavbridge.monitor.source import Source
from uavbridge.monitor.web.feed import Feed
from uavbridge.monitor.web.guard import Guard, check_token
from uavbridge.monitor.web.messages import Answer, Ask

STEP_S = 0.1  # between two looks at the bus
TELL_S = 0.2  # between two updates of a page
LOOPBACK = "127.0.0.1"
LARGEST_ASK = 4096  # bytes
SPEEDS = (0.1, 1000.0)

_ASKED = msgspec.json.Decoder(Ask)
_log = logging.getLogger(__name__)


def serve(
    source: Source,
    *,
    host: str = LOOPBACK,
    port: int = 0,
    token: str | None = None,
    ready: Callable[[str], None] = _log.info,
    stop: Callable[[], bool] = lambda: False,
) -> None:
    """Serve until Ctrl-C or SIGTERM.

    Args:
        source: of the mission.
        host: address to listen on.
        port: 0: any free one.
        token: that everybody must know; needed where ``host`` is not loopback.
        ready: is told the page's address.
        stop: asked ten times a second; True ends it.

    Raises:
        ConfigError: no token for a host that is not loopback, or too short a one.
        LinkError: the port cannot be listened on.
    """
    faults: list[BaseException] = []  # of taking in the mission, raised where people see them
    listening = listen(host, port, token)
    with listening:
        ready(address(listening, token))

        def end() -> None:
            server.should_exit = True

        def ended(task: asyncio.Task[None]) -> None:
            if not task.cancelled() and (fault := task.exception()) is not None:
                faults.append(fault)
                end()

        # what our own page is told fits websockets' defaults; asks are short
        config = uvicorn.Config(
            application(source, token, lambda: end() if stop() else None, ended),
            log_config=None,
            access_log=False,
            server_header=False,
            ws="websockets-sansio",
            ws_max_size=LARGEST_ASK,
            ws_ping_interval=5.0,
            ws_ping_timeout=5.0,
            timeout_graceful_shutdown=1,
        )
        server = uvicorn.Server(config)
        server.run(sockets=[listening])
    if faults:
        raise faults[0]


def listen(host: str, port: int, token: str | None) -> socket.socket:
    """A listening socket. Raises as ``serve`` does."""
    check_token(host, token)
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        return socket.create_server((host, port), family=family)
    except (OSError, OverflowError) as fault:
        reason = getattr(fault, "strerror", None) or fault
        raise LinkError(f"cannot listen on {host}, port {port}: {reason}") from None


def address(listening: socket.socket, token: str | None) -> str:
    """The page's address."""
    host, port = listening.getsockname()[:2]
    name = f"[{host}]" if ":" in host else host
    return f"http://{name}:{port}/" + (f"?token={token}" if token else "")


def application(
    source: Source,
    token: str | None = None,
    each_step: Callable[[], None] = lambda: None,
    ended: Callable[[asyncio.Task[None]], None] = lambda _task: None,
) -> ASGIApp:
    """The ASGI application.

    Args:
        source: of the mission.
        token: that everybody must know; None: loopback alone.
        each_step: called ten times a second.
        ended: told when the mission is taken in no more.
    """

    @asynccontextmanager
    async def running(_app: Starlette) -> AsyncIterator[None]:
        task = asyncio.create_task(_take_in(source, each_step))
        task.add_done_callback(ended)
        yield
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    async def page(websocket: WebSocket) -> None:
        await _Session(websocket, source).run()

    folder = str(files("uavbridge.monitor.web") / "page")
    app = Starlette(
        routes=[
            WebSocketRoute("/feed", page),
            Mount("/", StaticFiles(directory=folder, html=True)),
        ],
        lifespan=running,
    )
    return Guard(app, token)


async def _take_in(source: Source, each_step: Callable[[], None]) -> None:
    while True:
        source.step()
        each_step()
        await asyncio.sleep(STEP_S)


class _Session:
    """One page."""

    def __init__(self, websocket: WebSocket, source: Source) -> None:
        self._websocket, self._source = websocket, source
        self._feed = Feed(source)
        self._answers: list[str] = []
        self._orders: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        await self._websocket.accept()
        telling = asyncio.create_task(self._tell())
        try:
            while True:
                self._asked(await self._websocket.receive_text())
        except (WebSocketDisconnect, KeyError):  # KeyError: it sent bytes, as no page of ours does
            _log.debug("a page is gone")
        finally:
            for task in (telling, *self._orders):
                task.cancel()
            await asyncio.gather(telling, *self._orders, return_exceptions=True)

    async def _tell(self) -> None:
        while True:
            answers, self._answers = self._answers, []
            for message in [*answers, *self._feed.next()]:
                if isinstance(message, str):
                    await self._websocket.send_text(message)
                else:
                    await self._websocket.send_bytes(message)
            await asyncio.sleep(TELL_S)

    def _asked(self, text: str) -> None:
        try:
            ask = read(_ASKED, text.encode(errors="replace"))
        except msgspec.DecodeError as fault:
            _log.debug("malformed wish of a page dropped: %s", fault)
            return
        player = self._source.player
        if ask.seen_by is not None:
            self._feed.look(ask.seen_by)
        if ask.layer is not None:
            self._feed.show(ask.layer)
        if ask.order is not None:
            task = asyncio.create_task(self._order(ask, ask.order))
            self._orders.add(task)
            task.add_done_callback(self._orders.discard)
        if player is None:
            return
        if ask.seek_s is not None:
            player.seek(to_us(ask.seek_s))
        if ask.speed is not None:
            player.speed = min(max(ask.speed, SPEEDS[0]), SPEEDS[1])
        if ask.play is not None:
            player.play(ask.play)

    async def _order(self, ask: Ask, order: str) -> None:
        began_s = wall_s()
        try:
            verb = Verb(order)
            if (verb is Verb.GOTO) != (ask.to is not None):
                raise ValueError("goto needs a place, and nothing else takes one")
            replies = await asyncio.to_thread(self._source.order, verb, ask.agent, ask.to)
        except (ValueError, UavbridgeError) as fault:
            answer = Answer(ask.ask, order[:40], [], [], fault=str(fault))
        else:
            answer = Answer(
                ask.ask,
                order,
                done=[reply.agent for reply in replies if reply.ok],
                refused=[(reply.agent, reply.reason) for reply in replies if not reply.ok],
                took_s=round(wall_s() - began_s, 3),
            )
        self._answers.append(msgspec.json.encode(answer).decode())
