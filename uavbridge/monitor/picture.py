"""The terminal monitor's screen, made from a ``MissionWatch``: lines of text, nothing else."""

from __future__ import annotations

from math import isfinite, nan

import numpy as np
from rich.text import Text

from uavbridge.clock import to_s
from uavbridge.config.radio import radio_of
from uavbridge.monitor import timeline
from uavbridge.monitor.choice import HELP, Choice
from uavbridge.monitor.replayed import Player
from uavbridge.monitor.snapshot import unheard
from uavbridge.monitor.watch import Happening, MissionWatch, Point, Watched
from uavbridge.report.quantity import count, data_size, duration, number, plain

LOST_S = 3.0  # no sign of life for so long: the link is shown as lost
SHADES = " ░▒▓█"
LEAST_EVENTS = 3
TABLE_WIDTH = 45  # without the note
HEARD_WIDTH = 18  # of the ids of those who hear an agent, where there is room
_NAMED = TABLE_WIDTH + HEARD_WIDTH + 25  # columns of the table from which on there is


def picture(
    watch: MissionWatch, state: Choice, width: int, height: int, player: Player | None = None
) -> list[Text]:
    """The screen, of recordings with the time line: so many lines and columns at most."""
    head = [_title(watch, width), *_scores(watch)]
    agents = [watch.agents[agent] for agent in sorted(watch.agents)]
    heard_by = watch.heard_by()
    foot = [*_details(watch, state, heard_by), *_keys(state, player, width)]
    room = height - len(head) - len(foot) - LEAST_EVENTS - 1
    chart = _map(watch, max(room, 4), max(width - TABLE_WIDTH - 10, 12))
    rows = max(min(len(agents) + 1, room), len(chart))
    beside = width - (len(chart[0]) + 2 if chart else 0)
    table = _table(watch, agents, state, rows, beside, heard_by)
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
    return [
        Text(_searched(watch, last)),
        Text(
            f"closest {number(watch.separation.closest, 'm')}   radio {count(last.frames_sent)} "
            f"frames {data_size(last.bytes_sent)} sent, {data_size(last.bytes_heard)} heard"
        ),
        *(
            [Text(f"radio emulated: {radio}", style="yellow")]
            if (radio := _emulated(watch))
            else []
        ),
        Text(unheard(watch.dropped(), watch.rejected())),
        *([Text(clocks)] if (clocks := watch.clocks()) else []),
    ]


def _emulated(watch: MissionWatch) -> str:
    return "" if watch.facts is None else radio_of(watch.facts).words()


def _searched(watch: MissionWatch, last: Point) -> str:
    facts, finds = watch.facts, len(watch.finds.all())
    if facts is not None and facts.signals is not None:
        return f"targets {finds} of {len(facts.targets)} found by their signals"
    goal = "" if facts is None else f" of {facts.coverage_goal:.0%}"
    share = f"{last.coverage:.0%}" if isfinite(last.coverage) else "-"
    known = "" if watch.found is None else f", {watch.found} true"
    entropy = number(last.entropy, "bits")
    return f"coverage {share}{goal}   entropy {entropy}   targets {finds} declared{known}"


def _table(
    watch: MissionWatch,
    agents: list[Watched],
    state: Choice,
    rows: int,
    width: int,
    heard_by: dict[int, list[int]],
) -> list[Text]:
    named = width >= _NAMED
    who = "heard by".ljust(HEARD_WIDTH) if named else ""
    lines = [Text(f" id phase    mode       x    y   z bat hrd {who}", style="dim")]
    for agent in agents[: rows - 1 if len(agents) < rows else rows - 2]:
        line = _row(watch, agent, heard_by.get(agent.id, []), named=named)
        if agent.id == state.chosen:
            line.stylize("reverse")
        line.truncate(width, overflow="ellipsis")
        lines.append(line)
    if len(agents) > len(lines) - 1:
        lines.append(Text(f"    and {len(agents) - len(lines) + 1} more", style="dim"))
    return lines


def _row(watch: MissionWatch, agent: Watched, heard_by: list[int], *, named: bool) -> Text:
    report = agent.report
    phase, mode, note = (report.phase, report.mode, report.note) if report else ("-", "-", "")
    x, y, z = agent.position or (nan, nan, nan)
    battery = nan if report is None or report.battery is None else report.battery * 100
    lost = agent.alive is False or to_s(watch.t_us - agent.seen_us) > LOST_S
    line = Text(
        f"{agent.id:3d} {plain(phase)[:8]:<8} {plain(mode)[:8]:<8}"
        f"{_whole(x, 5)}{_whole(y, 5)}{_whole(z, 4)}{_whole(battery, 4)} {len(heard_by):3d} "
    )
    if named:
        line.append(_ids(heard_by, HEARD_WIDTH).ljust(HEARD_WIDTH), style="dim")
    line.append("LINK LOST " if lost and not watch.ended else "", style="bold red")
    line.append(plain(note))
    if phase == "failed":
        line.stylize("red")
    return line


def _ids(ids: list[int], width: int) -> str:
    """Ids in so many columns, cut with an ellipsis."""
    text = " ".join(map(str, ids))
    return text if len(text) < width else f"{text[: width - 2].rpartition(' ')[0]}…"


def _details(watch: MissionWatch, state: Choice, heard_by: dict[int, list[int]]) -> list[Text]:
    """What there is no room for in the table, of the agent that is chosen."""
    agent = watch.agents.get(-1 if state.chosen is None else state.chosen)
    if agent is None:
        return []
    hears = [other for other, receivers in heard_by.items() if agent.id in receivers]
    links = (
        f"hears {_ids(hears, 40) or '-'}, heard by {_ids(heard_by.get(agent.id, []), 40) or '-'}"
    )
    report = agent.report
    if report is None:
        return [Text(f"agent {agent.id}: {links}")]
    sent = f"sent {data_size(report.bytes_sent)}, heard {data_size(report.bytes_heard)}"
    note = plain(report.failure or report.note)
    flown = f"flown {report.distance_m:.0f} m"
    return [Text(f"agent {agent.id}: {note or '-'}"), Text(f"{links}; {sent}; {flown}")]


def _whole(value: float, width: int) -> str:
    return f"{value:z{width}.0f}" if isfinite(value) else "-".rjust(width)


def _map(watch: MissionWatch, rows: int, columns: int) -> list[Text]:
    """The merged map, north up, two columns a cell; coarser or larger as there is room."""
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
    times = max(min(rows // shape[1], columns // (2 * shape[0])), 1) if step == 1 else 1
    lines = []
    for row in reversed(range(shape[1])):
        for copy in range(times):
            line = Text("│")
            for column in range(shape[0]):
                cell = shades[column][row]
                marked = cell.strip().isdigit() or cell == "()"
                again = " " * 2 if marked else cell
                drawn = (again if copy else cell) + again * (times - 1)
                line.append(drawn, style="bold" if marked else "yellow")
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


def _keys(state: Choice, player: Player | None, width: int) -> list[Text]:
    if player is None:
        return [_question(state)]
    return [timeline.line(player, width), Text(timeline.HELP, style="dim")]


def _question(state: Choice) -> Text:
    whom = "ALL agents" if state.chosen is None else f"agent {state.chosen}"
    if state.asked is not None:
        return Text(f"{state.asked.value} {whom}? y/n", style="bold reverse")
    return Text(f"[{whom}] {state.said or HELP}", style="dim")
