"""``uavbridge monitor`` in the terminal: one screen of a mission that flies anywhere.

What is shown is made by ``picture`` from a ``MissionWatch``; keys go to ``choice``. Reading keys
and drawing are here alone.
"""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.live import Live
from rich.text import Text

from uavbridge.bus.api import Bus
from uavbridge.clock import pause, wall_s
from uavbridge.monitor.choice import Choice, Send, press
from uavbridge.monitor.picture import picture
from uavbridge.monitor.watch import MissionWatch

DRAW_S = 0.2
POLL_S = 0.02


def run(bus: Bus, send: Callable[[MissionWatch], Send], console: Console) -> None:
    """Show a mission until q, or Ctrl-C, or standard input ends.

    Args:
        bus: the mission's.
        send: makes what gives orders to the agents of a watch.
        console: to draw on.
    """
    state, watch = Choice(), MissionWatch(bus)
    drawn_s = 0.0
    with _keyboard() as keys, Live(console=console, screen=True, auto_refresh=False) as live:
        while not state.done:
            watch.poll()
            if watch.restarted:  # the same name, another flight
                watch.close()
                watch = MissionWatch(bus)
            for key in keys():
                press(state, key, sorted(watch.agents), send(watch))
                drawn_s = 0.0
            if wall_s() - drawn_s >= DRAW_S:
                drawn_s = wall_s()
                width, height = console.size
                lines = picture(watch, state, width, height)
                live.update(Text("\n", no_wrap=True, overflow="crop").join(lines), refresh=True)
            pause(POLL_S)


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
    except KeyboardInterrupt:
        return
    finally:
        termios.tcsetattr(stream, termios.TCSADRAIN, before)


def _keys(stream: int) -> list[str]:
    if not select.select([stream], [], [], 0)[0]:
        return []
    text = os.read(stream, 64).decode(errors="ignore")
    if not text:
        return ["q"]
    for code, name in (("\x1b[A", "up"), ("\x1b[B", "down"), ("\x1bOA", "up"), ("\x1bOB", "down")):
        text = text.replace(code, f"\0{name}\0")
    return [
        key for i, part in enumerate(text.split("\0")) for key in ([part] if i % 2 else list(part))
    ]
