"""``uavbridge monitor`` in the terminal: one screen of a mission that flies anywhere.

What is shown is made by ``picture`` from a ``MissionWatch``; keys become ``Press`` values.
Reading keys and drawing are in ``run`` alone.
"""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import isfinite, nan

import numpy as np
from rich.console import Console
from rich.live import Live
from rich.text import Text

from uavbridge.agent.orders import Verb
from uavbridge.clock import pause, to_s, wall_s
from uavbridge.monitor.watch import Happening, MissionWatch, Point, Watched
from uavbridge.report.quantity import count, data_size, duration, number, plain

DRAW_S = 0.2
POLL_S = 0.02
LOST_S = 3.0  # no sign of life for so long: the link is shown as lost
SHADES = " ░▒▓█"
LEAST_EVENTS = 3
TABLE_WIDTH = 45  # without the note

KEYS: dict[str, Verb] = {
    "p": Verb.PAUSE,
    "r": Verb.RESUME,
    "h": Verb.HOLD,
    "t": Verb.RETURN,
    "l": Verb.LAND,
    "a": Verb.ABORT,
}
DANGEROUS = frozenset({Verb.HOLD, Verb.RETURN, Verb.LAND, Verb.ABORT})
HELP = "p pause r resume h hold t return l land a abort ↑↓ choose q quit"

Send = Callable[[Verb, int | None], str]
"""Gives an order to one agent or to all; tells in a line what came of it."""


@dataclass(slots=True)
class Choice:
    """What the keys have chosen."""

    chosen: int | None = None  # agent; None: all
    asked: Verb | None = None  # waits for y
    said: str = ""  # what came of the last order
    done: bool = False


def press(state: Choice, key: str, agents: list[int], send: Send) -> None:
    """One key: choose, order, answer a question, quit."""
    if state.asked is not None:
        verb, state.asked = state.asked, None
        state.said = send(verb, state.chosen) if key in "yY" else f"{verb.value}: not sent"
    elif key in ("q", "\x03", "\x04"):
        state.done = True
    elif key in ("up", "down"):
        ring: list[int | None] = [None, *agents]
        at = ring.index(state.chosen) if state.chosen in ring else 0
        state.chosen = ring[(at + (1 if key == "down" else -1)) % len(ring)]
    elif (order := KEYS.get(key)) is not None:
        if order in DANGEROUS:
            state.asked = order
        else:
            state.said = send(order, state.chosen)


def picture(watch: MissionWatch, state: Choice, width: int, height: int) -> list[Text]:
    """The screen: at most ``height`` lines of at most ``width`` columns."""
    head = [_title(watch, width), *_scores(watch)]
    agents = [watch.agents[agent] for agent in sorted(watch.agents)]
    foot = [_question(state)]
    room = height - len(head) - len(foot) - LEAST_EVENTS - 1
    chart = _map(watch, max(room, 4), max(width - TABLE_WIDTH - 10, 12))
    rows = max(min(len(agents) + 1, room), len(chart))
    table = _table(watch, agents, state, rows, width - (len(chart[0]) + 2 if chart else 0))
    body = _beside(table, chart, width, rows)
    left = height - len(head) - len(body) - len(foot)
    events = [_event(happening) for happening in list(watch.events)[-max(left - 1, 0) :]]
    lines = [*head, *body, Text(""), *events][: height - len(foot)] + foot
    for line in lines:
        line.truncate(width, overflow="ellipsis")
    return lines


def _title(watch: MissionWatch, width: int) -> Text:
    facts = watch.facts
    name = "waiting for a mission" if facts is None else f"{facts.name}  {facts.planner}"
    limit = "" if facts is None else f" of {duration(facts.duration)}"
    clock = f"{duration(to_s(max(watch.t_us, 0)))}{limit}"
    ended = "  ended" if watch.ended else ""
    title = Text(f"{plain(name)}{ended}", style="bold")
    title.append(" " * max(width - len(title) - len(clock), 1))
    title.append(clock)
    return title


def _scores(watch: MissionWatch) -> list[Text]:
    last = watch.series[-1] if watch.series else Point(0, nan, nan, nan, 0, 0, nan, 0, 0, 0, 0)
    goal = "" if watch.facts is None else f" of {watch.facts.coverage_goal:.0%}"
    share = f"{last.coverage:.0%}" if isfinite(last.coverage) else "-"
    targets = len(watch.declared)
    known = "" if watch.found is None else f", {watch.found} true"
    return [
        Text(
            f"coverage {share}{goal}   entropy {number(last.entropy, 'bits')}   "
            f"targets {targets} declared{known}"
        ),
        Text(
            f"closest {number(watch.separation.closest, 'm')}   radio {count(last.frames_sent)} "
            f"frames {data_size(last.bytes_sent)} sent, {data_size(last.bytes_heard)} heard"
        ),
        Text(""),
    ]


def _table(
    watch: MissionWatch, agents: list[Watched], state: Choice, rows: int, width: int
) -> list[Text]:
    lines = [Text(" id phase    mode       x    y   z bat hrd", style="dim")]
    for agent in agents[: rows - 1 if len(agents) < rows else rows - 2]:
        line = _row(watch, agent)
        if agent.id == state.chosen:
            line.stylize("reverse")
        line.truncate(width, overflow="ellipsis")
        lines.append(line)
    if len(agents) > len(lines) - 1:
        lines.append(Text(f"    and {len(agents) - len(lines) + 1} more", style="dim"))
    return lines


def _row(watch: MissionWatch, agent: Watched) -> Text:
    report = agent.report
    phase, mode, note = (report.phase, report.mode, report.note) if report else ("-", "-", "")
    x, y, z = agent.position or (nan, nan, nan)
    battery = nan if report is None or report.battery is None else report.battery * 100
    heard_by = sum(agent.id in watch.hears(other) for other in watch.agents)
    lost = agent.alive is False or to_s(watch.t_us - agent.seen_us) > LOST_S
    line = Text(
        f"{agent.id:3d} {plain(phase)[:8]:<8} {plain(mode)[:8]:<8}"
        f"{_whole(x, 5)}{_whole(y, 5)}{_whole(z, 4)}{_whole(battery, 4)} {heard_by:2d} "
    )
    line.append("LINK LOST " if lost and not watch.ended else "", style="bold red")
    line.append(plain(note))
    if phase == "failed":
        line.stylize("red")
    return line


def _whole(value: float, width: int) -> str:
    return f"{value:z{width}.0f}" if isfinite(value) else "-".rjust(width)


def _map(watch: MissionWatch, rows: int, columns: int) -> list[Text]:
    """The merged map, north up, two columns a cell; coarser where there is no room."""
    merged = watch.merged()
    if merged is None or watch.grid is None:
        return []
    probability, seen = merged
    step = max(-(-probability.shape[0] * 2 // columns), -(-probability.shape[1] // rows), 1)
    shape = [-(-size // step) for size in probability.shape]
    shades: list[list[str]] = [[" ·"] * shape[1] for _ in range(shape[0])]
    for column, row in zip(*np.nonzero(seen), strict=True):
        at = column // step, row // step
        shade = SHADES[min(int(probability[column, row] * len(SHADES)), len(SHADES) - 1)]
        shades[at[0]][at[1]] = max(shades[at[0]][at[1]].replace(" ·", "  "), shade * 2)
    for column, row in watch.declared:
        shades[column // step][row // step] = "()"
    for agent in watch.agents.values():
        if agent.position is not None and agent.flying:
            column, row = (watch.grid.cell_of(agent.position) // step).tolist()
            if 0 <= column < shape[0] and 0 <= row < shape[1]:
                shades[column][row] = f"{agent.id % 100:2d}"
    lines = []
    for row in reversed(range(shape[1])):
        line = Text("│")
        for column in range(shape[0]):
            cell = shades[column][row]
            line.append(cell, style="bold" if cell.strip().isdigit() or cell == "()" else "yellow")
        line.append("│")
        lines.append(line)
    return lines


def _beside(table: list[Text], chart: list[Text], width: int, rows: int) -> list[Text]:
    lines = []
    for i in range(max(len(table), len(chart))):
        line = table[i].copy() if i < len(table) else Text("")
        if i < len(chart):
            at = width - len(chart[i])
            line.truncate(at - 1)
            line.append(" " * (at - len(line)))
            line.append_text(chart[i])
        lines.append(line)
    return lines[:rows]


def _event(happening: Happening) -> Text:
    who = "" if happening.agent is None else f"agent {happening.agent}: "
    style = "bold red" if happening.kind == "failure" else "dim"
    return Text(f"{duration(to_s(happening.t_us))}  {who}{plain(happening.text)}", style=style)


def _question(state: Choice) -> Text:
    whom = "ALL agents" if state.chosen is None else f"agent {state.chosen}"
    if state.asked is not None:
        return Text(f"{state.asked.value} {whom}? y/n", style="bold reverse")
    return Text(f"[{whom}] {state.said or HELP}", style="dim")


def run(watch: MissionWatch, send: Send, console: Console) -> None:
    """Show a mission until q, or Ctrl-C, or standard input ends."""
    state = Choice()
    drawn_s = 0.0
    with _keyboard() as keys, Live(console=console, screen=True, auto_refresh=False) as live:
        while not state.done:
            watch.poll()
            for key in keys():
                press(state, key, sorted(watch.agents), send)
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
