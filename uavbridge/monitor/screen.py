"""The live view as lines of text: fits a terminal of 80 x 24 with ten vehicles."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from itertools import zip_longest

from rich.text import Text

from uavbridge.monitor.snapshot import MissionFacts, Snapshot, VehicleLine, unheard
from uavbridge.report.quantity import count, data_size, duration, number, plain

_FIXED = 8  # lines above the vehicles, the table's head included
_ALERTS = 3
_LOW_BATTERY, _EMPTY_BATTERY = 0.3, 0.15
_BAR_LEAST = 10

_PHASE_STYLES = {
    "search": "green",
    "return": "cyan",
    "land": "cyan",
    "landed": "dim",
    "failed": "bold red",
    "lost": "bold red",
    "yielded": "yellow",
}


def screen(
    facts: MissionFacts, now: Snapshot, *, factor: float, width: int, height: int
) -> list[Text]:
    """The lines to show.

    Args:
        facts: the mission.
        now: where it is.
        factor: mission seconds per wall second; NaN when not known yet.
        width: columns of the terminal.
        height: its lines; one is left for the cursor.

    Returns:
        At most ``height - 1`` lines, none wider than ``width``.
    """
    alerts = [Text(f"! {plain(text)}", style="bold red") for text in now.alerts[-_ALERTS:]]
    room = max(height - 1 - _FIXED - len(alerts), 1)
    lines = [
        _title(facts, now, factor, width),
        *([] if facts.by_signal else [_coverage_bar(facts, now, width)]),
        _scores(facts, now),
        _separation(facts, now),
        _radio(now),
        Text(f"{'':10}{lost}" if (lost := unheard(now.dropped, now.rejected)) else ""),
        *([Text(f"{'':10}{now.clocks}")] if now.clocks else []),
        *_vehicles(now.vehicles, width, room + 1),
        Text(""),
        *alerts,
    ]
    while lines and not lines[-1].plain:
        lines.pop()
    for line in lines:
        line.truncate(width, overflow="ellipsis")
    return lines[: max(height - 1, 1)]


def one_line(facts: MissionFacts, now: Snapshot, *, factor: float) -> str:
    """The same in one line, for logs and pipes."""
    scores = [f"coverage {now.coverage:.0%}", f"entropy {number(now.entropy, 'bits')}"]
    parts = [
        f"{duration(now.t_s)} min",
        *([] if facts.by_signal else scores),
        f"targets {now.declared}/{facts.targets}",
        f"closest pair {number(now.closest_m, 'm')}",
        f"{count(now.frames_sent)} frames {data_size(now.bytes_sent)}",
        unheard(now.dropped, now.rejected),
        _phases(now.vehicles),
    ]
    if math.isfinite(factor):
        parts.append(f"{factor:.1f}x")
    return ", ".join(part for part in parts if part)


def _title(facts: MissionFacts, now: Snapshot, factor: float, width: int) -> Text:
    status = plain(now.status)
    right = f"{duration(now.t_s)} of {duration(facts.duration_s)}"
    if math.isfinite(factor):
        right += f"  {factor:.1f}x"
    left = Text(plain(facts.name), style="bold")
    left.append(f"  {plain(facts.planner)}, seed {facts.seed}, {facts.clock}", style="dim")
    if status:
        left.append(f"  {status}", style="green" if status.startswith("goal") else "")
    left.truncate(max(width - len(right) - 2, 0), overflow="ellipsis")
    left.pad_right(max(width - left.cell_len - len(right), 0))
    return left.append(right)


def _coverage_bar(facts: MissionFacts, now: Snapshot, width: int) -> Text:
    share = min(max(now.coverage, 0.0), 1.0) if math.isfinite(now.coverage) else 0.0
    figures = f" {share:4.0%} of {facts.coverage_goal:.0%}"
    length = max(width - len("coverage  ") - len(figures), _BAR_LEAST)
    full = round(share * length)
    goal = min(round(facts.coverage_goal * length), length - 1)
    done = share >= facts.coverage_goal
    bar = Text("━" * full + "─" * (length - full))
    bar.stylize("green" if done else "cyan", 0, full)
    bar.stylize("dim", full)
    if not done:
        bar = Text.assemble(bar[:goal], ("┃", "bold"), bar[goal + 1 :])
    return Text.assemble("coverage  ", bar, figures)


def _scores(facts: MissionFacts, now: Snapshot) -> Text:
    found = facts.targets > 0 and now.declared >= facts.targets
    return Text.assemble(
        "targets   ",
        (f"{now.declared} of {facts.targets}", "bold green" if found else "bold"),
        " found" if facts.by_signal else f" declared, entropy {number(now.entropy, 'bits')}",
    )


def _separation(facts: MissionFacts, now: Snapshot) -> Text:
    limit = facts.separation_limit_m
    near = math.isfinite(limit) and now.separation_m < 2 * limit
    return Text.assemble(
        "closest   ",
        (number(now.separation_m, "m"), "bold red" if near else "bold"),
        f" now, {number(now.closest_m, 'm')} so far",
        "" if math.isnan(limit) else f", limit {limit:g} m",
    )


def _radio(now: Snapshot) -> Text:
    sent = f"{count(now.frames_sent)} frames sent, {data_size(now.bytes_sent)}"
    heard = f"{count(now.frames_heard)} heard, {data_size(now.bytes_heard)}"
    return Text(f"radio     {sent}; {heard}")


def _vehicles(vehicles: Sequence[VehicleLine], width: int, room: int) -> list[Text]:
    """The table with its head; two columns, then a summary, where one would be too long."""
    if len(vehicles) < room or width < 78:
        shown = vehicles if len(vehicles) < room else vehicles[: max(room - 2, 0)]
        lines = [_head(note=True), *(_vehicle(one, note=True) for one in shown)]
    else:
        rows = max(room - 2, 1)
        shown = vehicles[: 2 * rows]
        half = -(-len(shown) // 2)
        lines = [Text.assemble(_head(note=False), "    ", _head(note=False))]
        for one, two in zip_longest(shown[:half], shown[half:]):
            pair = _vehicle(one, note=False)
            lines.append(Text.assemble(pair, "    ", _vehicle(two, note=False)) if two else pair)
    if rest := vehicles[len(shown) :]:
        lines.append(Text(f"and {len(rest)} more: {_phases(rest)}", style="dim"))
    return lines


def _head(*, note: bool) -> Text:
    head = " id phase    mode        m    % heard"
    return Text(head + "  note" if note else head, style="dim")


def _vehicle(line: VehicleLine, *, note: bool) -> Text:
    # z: nobody flies at -0 m
    height = f"{line.height_m:z4.0f}" if math.isfinite(line.height_m) else "   -"
    battery = f"{line.battery * 100:4.0f}" if math.isfinite(line.battery) else "   -"
    phase = plain(line.phase)
    text = Text.assemble(
        f"{line.id:>3} ",
        (f"{phase[:8]:<8} ", _PHASE_STYLES.get(phase, "")),
        f"{plain(line.mode)[:8]:<8} {height} ",
        (battery, _battery_style(line.battery)),
        f" {line.neighbours:>5}",
    )
    return text.append(f"  {plain(line.note)}", style="dim") if note and line.note else text


def _battery_style(battery: float) -> str:
    if battery < _EMPTY_BATTERY:
        return "bold red"
    return "yellow" if battery < _LOW_BATTERY else ""


def _phases(vehicles: Sequence[VehicleLine]) -> str:
    totals = Counter(plain(one.phase) for one in vehicles)
    return ", ".join(f"{total} {phase}" for phase, total in totals.most_common())
