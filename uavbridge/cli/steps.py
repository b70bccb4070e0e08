"""How far a command is that takes its time: one line that is written over, or one now and then."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from uavbridge.clock import to_s, wall_s

PATIENCE_S = 1.5  # what is over sooner says nothing
REDRAW_S, LINE_S = 0.3, 10.0


@contextmanager
def told() -> Iterator[Callable[[str], None]]:
    """Tells on standard error what a command is at.

    Yields:
        A function to call with a short text, as often as one likes.
    """
    live = sys.stderr.isatty()
    next_s, drawn = wall_s() + PATIENCE_S, False

    def tell(text: str) -> None:
        nonlocal next_s, drawn
        now_s = wall_s()
        if now_s < next_s:
            return
        next_s, drawn = now_s + (REDRAW_S if live else LINE_S), True
        click.echo(f"\r{text}\x1b[K" if live else text, err=True, nl=not live)

    try:
        yield tell
    finally:
        if live and drawn:
            click.echo("\r\x1b[K", err=True, nl=False)


@contextmanager
def steps(what: str) -> Iterator[Callable[[int], None]]:
    """Tells on standard error the mission time that a command has come to.

    Args:
        what: it does, such as ``verifying``.

    Yields:
        A function to call with the mission time in microseconds, as often as one likes.
    """
    from uavbridge.report.quantity import duration

    with told() as tell:
        yield lambda t_us: tell(f"{what}: {duration(to_s(max(t_us, 0)))} of mission time")
