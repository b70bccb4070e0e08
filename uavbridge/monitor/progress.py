"""Shows a mission while it flies: a live screen on a terminal, plain lines elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType

from rich.console import Console
from rich.live import Live
from rich.text import Text

from uavbridge.clock import wall_s
from uavbridge.monitor.screen import one_line, screen
from uavbridge.monitor.snapshot import MissionFacts, Snapshot, VehicleLine
from uavbridge.report.quantity import plain

__all__ = ["MissionFacts", "ProgressView", "Snapshot", "VehicleLine"]

_REDRAW_S = 0.2  # wall time between two pictures
_LINE_S = 5.0  # wall time between two plain lines
_SETTLE_S = 0.5  # wall time before the speed is worth telling


class ProgressView:
    """A context manager; ``update`` may be called as often as there is news.

    Args:
        console: where to show; one on standard error when standard output carries JSON.
        facts: the mission.
        headless: plain lines even on a terminal.
        wall: tells wall time in seconds.
    """

    def __init__(
        self,
        console: Console,
        facts: MissionFacts,
        *,
        headless: bool = False,
        wall: Callable[[], float] = wall_s,
    ) -> None:
        self._console, self._facts, self._wall = console, facts, wall
        self._live: Live | None = None
        if console.is_terminal and not console.is_dumb_terminal and not headless:
            self._live = Live(console=console, auto_refresh=False)
        self._period_s = _REDRAW_S if self._live else _LINE_S
        self._shown_s = float("-inf")
        self._first: tuple[float, float] | None = None  # wall and mission time of the first news
        self._latest: Snapshot | None = None
        self._shown: Snapshot | None = None
        self._told: set[str] = set()  # alerts, in plain lines

    def update(self, now: Snapshot) -> None:
        """Show where the mission is, unless something was shown a moment ago."""
        wall = self._wall()
        if self._first is None:
            self._first = wall, now.t_s
        self._latest = now
        if self._live is None:
            self._tell_alerts(now)
        if wall - self._shown_s >= self._period_s:
            self._shown_s = wall
            self._show(now, wall)

    def __enter__(self) -> ProgressView:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._latest is not None and self._latest is not self._shown:
            self._show(self._latest, self._wall())
        if self._live is not None:
            self._live.stop()

    def _show(self, now: Snapshot, wall: float) -> None:
        self._shown = now
        factor = self._factor(now, wall)
        if self._live is None:
            self._line(one_line(self._facts, now, factor=factor))
            return
        width, height = self._console.size
        lines = screen(self._facts, now, factor=factor, width=width, height=height)
        picture = Text("\n", no_wrap=True, overflow="crop").join(lines)
        self._live.update(picture, refresh=True)

    def _factor(self, now: Snapshot, wall: float) -> float:
        if self._first is None or wall - self._first[0] < _SETTLE_S:
            return float("nan")
        return (now.t_s - self._first[1]) / (wall - self._first[0])

    def _tell_alerts(self, now: Snapshot) -> None:
        for text in now.alerts:
            if text not in self._told:
                self._told.add(text)
                self._line(f"! {text}")

    def _line(self, text: str) -> None:
        self._console.print(Text(plain(text)), soft_wrap=True)
