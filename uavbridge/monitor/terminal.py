"""``uavbridge monitor`` in the terminal: one screen of a mission, flying anywhere or recorded.

What is shown is made by ``picture``; keys go to ``choice``, those of recordings to ``timeline``.
Reading keys and drawing are here alone.
"""

from __future__ import annotations

import os
import re
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager

from rich.console import Console
from rich.live import Live
from rich.text import Text

from uavbridge.agent.orders import Verb
from uavbridge.clock import pause, wall_s
from uavbridge.command import Reply
from uavbridge.errors import UavbridgeError
from uavbridge.monitor import timeline
from uavbridge.monitor.choice import Choice, moved, press
from uavbridge.monitor.picture import picture
from uavbridge.monitor.source import Source
from uavbridge.report.quantity import plain

DRAW_S = 0.2
POLL_S = 0.02
_AT_ONCE = 8  # orders that wait for answers
_NAMES = {
    "A": "up", "B": "down", "C": "right", "D": "left", "H": "home", "F": "end",
    "1~": "home", "4~": "end", "5~": "pgup", "6~": "pgdn", "7~": "home", "8~": "end",
}  # fmt: skip
_KEY = re.compile(r"\x1b[\[O]([0-9;]*[A-Za-z~])|\x1b|(.)", re.DOTALL)


def run(source: Source, console: Console, stop: Callable[[], bool] = lambda: False) -> None:
    """Show a mission until q, or ``stop``, or standard input ends.

    Args:
        source: of the mission.
        console: to draw on.
        stop: asked fifty times a second.
    """
    state, orders = Choice(), _Orders(source)
    drawn_s = 0.0
    with (
        orders,
        _keyboard() as keys,
        Live(console=console, screen=True, auto_refresh=False) as live,
    ):
        while not (state.done or stop()):
            source.step()
            for key in keys():
                _press(source, state, key, orders)
                drawn_s = 0.0
            state.said = orders.told() or state.said
            if wall_s() - drawn_s >= DRAW_S:
                drawn_s = wall_s()
                width, height = console.size
                lines = picture(source.watch, state, width, height, source.player)
                live.update(Text("\n", no_wrap=True, overflow="crop").join(lines), refresh=True)
            pause(POLL_S)


def _press(source: Source, state: Choice, key: str, orders: _Orders) -> None:
    agents = sorted(source.watch.agents)
    if source.player is None:
        press(state, key, agents, orders.send)
    elif not moved(state, key, agents):
        timeline.turn(source.player, key)


class _Orders:
    """Orders on their way: the screen stays alive while agents take their time to answer."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._threads = ThreadPoolExecutor(_AT_ONCE)
        self._waiting: list[tuple[Verb, Future[list[Reply]]]] = []

    def __enter__(self) -> _Orders:
        return self

    def __exit__(self, *_: object) -> None:
        self._threads.shutdown()

    def send(self, verb: Verb, agent: int | None) -> str:
        """Give an order; what to show until there are answers."""
        self._waiting.append((verb, self._threads.submit(self._source.order, verb, agent, None)))
        return f"{verb.value}: sent"

    def told(self) -> str:
        """What came of an order since the last call; empty: nothing."""
        for one in self._waiting:
            if one[1].done():
                self._waiting.remove(one)
                return _outcome(*one)
        return ""


def _outcome(verb: Verb, waited: Future[list[Reply]]) -> str:
    try:
        replies = waited.result()
    except UavbridgeError as fault:
        return f"{verb.value}: {fault}"
    refused = [f"agent {reply.agent}: {reply.reason}" for reply in replies if not reply.ok]
    done = f"{verb.value}: {len(replies) - len(refused)} of {len(replies)} done"
    took_s = max((reply.took_s for reply in replies), default=0.0)
    return plain("; ".join([f"{done} in {took_s:.2f} s", *refused]))


@contextmanager
def _keyboard() -> Iterator[Callable[[], list[str]]]:
    """Keys pressed since the last call, without waiting and without echo."""
    stream = sys.stdin.fileno()
    if not os.isatty(stream):
        yield list
        return
    before = termios.tcgetattr(stream)
    tty.setcbreak(stream)
    try:
        yield lambda: _keys(stream)
    finally:
        termios.tcsetattr(stream, termios.TCSADRAIN, before)


def _keys(stream: int) -> list[str]:
    if not select.select([stream], [], [], 0)[0]:
        return []
    text = os.read(stream, 64).decode(errors="ignore")
    return named(text) if text else ["q"]


def named(text: str) -> list[str]:
    """Keys by what a terminal sends for them; those without a name that matters are left out."""
    keys = [_NAMES.get(code, "") if code else key for code, key in _KEY.findall(text)]
    return [key for key in keys if key]
