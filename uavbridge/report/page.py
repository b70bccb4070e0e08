"""``report.html``: one page that stands alone, on screen and on paper.

Every text that comes from a mission, an agent or a vehicle goes through
``escape``; the page forbids scripts and the network to itself.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from uavbridge.report.quantity import count, data_size, duration, number
from uavbridge.report.result import AgentResult, MissionResult
from uavbridge.report.summary import summary_json

if TYPE_CHECKING:
    from uavbridge.report.drawn import Drawn

REPORT_NAME, SUMMARY_NAME, FIGURES_NAME = "report.html", "summary.json", "figures"
MOST_EVENTS = 500  # on paper
FIGURES = ("map", "progress", "separation", "radio")  # as ``drawn.drawings`` makes them


def write_report(
    result: MissionResult, folder: Path, progress: Callable[[str], None] = lambda _name: None
) -> Path:
    """Write ``report.html``, ``summary.json`` and the figures; the path of the page.

    Args:
        result: of the mission.
        folder: to write to.
        progress: told the name of each figure before it is drawn.
    """
    # Half a second of matplotlib, spared to everything that imports this and draws nothing.
    from uavbridge.report.drawn import drawings, write_files

    (folder / SUMMARY_NAME).write_bytes(summary_json(result))
    made = drawings(result, progress)
    write_files(made, folder / FIGURES_NAME)
    path = folder / REPORT_NAME
    path.write_text(report_page(result, made), encoding="utf-8", errors="replace")
    return path


def report_page(result: MissionResult, drawn: Mapping[str, Drawn]) -> str:
    """The page as text, with the figures in it."""
    sections = (
        _section("Map", _figure(drawn["map"].svg, _map_caption(result))),
        _section("Progress", _figure(drawn["progress"].svg, _progress_caption(result))),
        _section("Layers", _layers(drawn)),
        _section("Suballiances", _alliances(drawn)),
        _section("Flight", _flight(drawn)),
        _section("Targets", _targets(result)),
        _section("Separation", _figure(drawn["separation"].svg, _SEPARATION_CAPTION)),
        _section("Radio", _figure(drawn["radio"].svg, _RADIO_CAPTION) + _accounts(result.agents)),
        _section("Agents", _agents(result.agents)),
        _section("Events", _events(result)),
        _section("How to repeat", _repeat(result)),
        _section("Mission file", _mission_file(result)),
    )
    return _PAGE.format(
        title=escape(result.mission),
        style=files("uavbridge.report").joinpath("report.css").read_text(encoding="utf-8"),
        head=_head(result),
        sections="\n".join(section for section in sections if section),
    )


_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; style-src 'unsafe-inline'; img-src data:">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}: mission report</title>
<style>
{style}</style>
</head>
<body>
{head}
{sections}
</body>
</html>
"""

_PROGRESS_CAPTION = (
    "Over the union of all agents' maps. Entropy counts both outcomes of each cell; the one-sided "
    "sum of Liu 2022 (−Σ P log₂ P) rises at first visits. Dotted: a target is declared."
)
_FOUND_CAPTION = "Targets that some vehicle came to by their signals."
_LAYERS_CAPTION = (
    "Numbers over the area that agents or place agents keep beside the belief, as they were last."
)
_ALLIANCES_CAPTION = (
    "Robots on the roster of each target's leader, those of class I (who hear the target "
    "themselves) dark; a star marks when the target was found."
)
_SEPARATION_CAPTION = (
    "True distance between the two closest vehicles that fly or drive, in all phases."
)
_SPACE_CAPTION = "Tracks in space over the terrain; heights are drawn larger than distances."
_MOTION_CAPTION = (
    "Yaw from east, counter-clockwise, and pitch of the flight path, upwards, once a second, of "
    "all aircraft."
)
_RADIO_CAPTION = "Frames on the emulated radio, as offered by and delivered to each agent."


def _head(result: MissionResult) -> str:
    kind, verdict = (
        ("reached", "goal reached") if result.reached_goal else ("missed", "goal missed")
    )
    speed = (
        f" in {result.wall_s:.1f} s, {result.duration_s / result.wall_s:.1f} times real time"
        if result.wall_s > 0
        else ""
    )
    facts = (
        f"seed {result.seed} · {escape(result.clock)} clock · {len(result.agents)} agents · "
        f"{duration(result.duration_s)} min of mission time{speed}"
    )
    failures = "".join(f"<li>{escape(text)}</li>" for text in result.failures)
    return (
        f'<h1>{escape(result.mission)} <span class="verdict {kind}">{verdict}</span></h1>\n'
        f'<p class="facts">{facts}</p>\n'
        + "".join(f'<p class="facts">{escape(text)}</p>\n' for text in result.notes)
        + (f'<ul class="failures">{failures}</ul>\n' if failures else "")
        + f'<div class="tiles">{"".join(_tiles(result))}</div>'
    )


def _tiles(result: MissionResult) -> Iterable[str]:
    goal = "" if math.isnan(result.coverage_goal) else f", goal {result.coverage_goal:.0%}"
    limit = result.separation_limit_m
    beyond = "" if math.isnan(limit) else f", limit {limit:g} m"
    false = len(result.false_targets)
    sent = sum(agent.bytes_sent for agent in result.agents)
    frames = sum(agent.frames_sent for agent in result.agents)
    flown = sum(agent.distance_m for agent in result.agents)
    found = f"{result.found} / {len(result.targets)}"
    if result.by_signal:
        yield _tile(found, "targets found by their signals")
    else:
        yield _tile(found, f"targets declared, {false} false")
        yield _tile(number(result.coverage * 100, "%"), f"coverage{goal}")
        yield _tile(
            number(result.entropy, "bits"), f"entropy; one-sided {number(result.uncertainty, '')}"
        )
    yield _tile(number(result.min_separation_m, "m"), f"closest pair{beyond}")
    yield _tile(data_size(sent), f"sent in {count(frames)} frames")
    yield _tile(f"{flown / 1000:.1f} km", "travelled together")


def _tile(value: str, label: str) -> str:
    return f'<div class="tile"><b>{escape(value)}</b><span>{escape(label)}</span></div>'


def _map_caption(result: MissionResult) -> str:
    grid = result.grid
    area = f"{grid.columns} × {grid.rows} cells of {grid.cell_m:g} m"
    stars = " Targets are numbered as below." if result.by_signal else ""
    return (
        f"{area}, numbered (column, row) from the south-west; a number marks where an agent began."
        + stars
    )


def _progress_caption(result: MissionResult) -> str:
    return _FOUND_CAPTION if result.by_signal else _PROGRESS_CAPTION


def _flight(drawn: Mapping[str, Drawn]) -> str:
    """Tracks in space and motion over time, of fixed-wing aircraft."""
    captions = {"space": _SPACE_CAPTION, "motion": _MOTION_CAPTION}
    return "".join(
        _figure(drawn[name].svg, text) for name, text in captions.items() if name in drawn
    )


def _layers(drawn: Mapping[str, Drawn]) -> str:
    return _figure(drawn["layers"].svg, _LAYERS_CAPTION) if "layers" in drawn else ""


def _alliances(drawn: Mapping[str, Drawn]) -> str:
    return _figure(drawn["alliances"].svg, _ALLIANCES_CAPTION) if "alliances" in drawn else ""


def _targets(result: MissionResult) -> str:
    """By signal, targets have the numbers of the map and of the suballiances."""
    word = "found" if result.by_signal else "declared"
    rows: list[tuple[str, ...]] = [
        (
            f"({target.cell[0]}, {target.cell[1]})",
            f"not {word}" if target.found_at_s is None else duration(target.found_at_s),
            "-" if target.by is None else str(target.by),
        )
        for target in result.targets
    ]
    rows += [(f"({c}, {r})", "false: nothing there", "-") for c, r in result.false_targets]
    head: tuple[str, ...] = ("cell", f"{word} at (min:s)", "by agent")
    if result.by_signal:
        head = ("target", *head)
        rows = [(str(number), *row) for number, row in enumerate(rows, 1)]
    return _table(head, rows, numeric=False)


def _agents(agents: Sequence[AgentResult]) -> str:
    head = ("agent", "state", "flown (m)", "frames sent", "frames heard", "sent", "heard")
    rows = [
        (
            str(agent.id), agent.state, f"{agent.distance_m:,.0f}", count(agent.frames_sent),
            count(agent.frames_heard), data_size(agent.bytes_sent), data_size(agent.bytes_heard),
        )
        for agent in agents
    ]  # fmt: skip
    return _table(head, rows, numeric=True)


def _accounts(agents: Sequence[AgentResult]) -> str:
    """What became of the frames: offered, sent, heard, and by reason what was not."""
    frames, sizes = Counter[str](), Counter[str]()
    rejected = Counter[str]()
    for agent in agents:
        frames.update(agent.dropped)
        sizes.update(agent.dropped_bytes)
        rejected |= Counter(agent.rejected)  # agents of one process have one count
    sent, heard = sum(a.frames_sent for a in agents), sum(a.frames_heard for a in agents)
    offered = sum(a.bytes_offered for a in agents)
    rows = [
        ("offered by the agents", "", data_size(offered)) if offered else None,
        ("sent", count(sent), data_size(sum(a.bytes_sent for a in agents))),
        ("heard, once for each that heard it", count(heard), data_size(_heard(agents))),
        *(
            (f"not heard: {why}", count(n), data_size(sizes[why]))
            for why, n in frames.most_common()
        ),
        *((f"rejected: {why}", count(n), "") for why, n in rejected.most_common()),
    ]
    return _table(("frames", "number", "bytes"), [row for row in rows if row], numeric=True)


def _heard(agents: Sequence[AgentResult]) -> int:
    return sum(agent.bytes_heard for agent in agents)


def _events(result: MissionResult) -> str:
    rows = [
        (duration(event.t_s), "-" if event.agent is None else str(event.agent), event.text)
        for event in result.events[:MOST_EVENTS]
    ]
    if more := len(result.events) - len(rows):
        rows.append(("", "", f"and {count(more)} more: in the recording"))
    return _table(("time (min:s)", "agent", "what"), rows, numeric=False) if rows else ""


def _repeat(result: MissionResult) -> str:
    facts = [
        ("seed", str(result.seed)),
        ("clock", result.clock),
        ("digest", result.digest or "-"),
        ("output", result.out or "-"),
        *result.versions.items(),
    ]
    body = "".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in facts)
    command = f"<pre>{escape(result.repeat)}</pre>\n" if result.repeat else ""
    return f"{command}<dl>{body}</dl>"


def _mission_file(result: MissionResult) -> str:
    return f"<pre>{escape(result.mission_text) or '-'}</pre>"


def _section(title: str, body: str) -> str:
    return f"<section>\n<h2>{title}</h2>\n{body}\n</section>" if body else ""


def _figure(svg: str, caption: str) -> str:
    return f"<figure>\n{svg}\n<figcaption>{caption}</figcaption>\n</figure>"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]], *, numeric: bool) -> str:
    """A table; ``numeric``: all columns after the second are numbers."""

    def line(tag: str, cells: Sequence[str]) -> str:
        classes = [' class="n"' if numeric and place > 1 else "" for place in range(len(cells))]
        pairs = zip(classes, cells, strict=True)
        return "".join(f"<{tag}{kind}>{escape(cell)}</{tag}>" for kind, cell in pairs)

    body = "\n".join(f"<tr>{line('td', row)}</tr>" for row in rows)
    return (
        f'<div class="wide"><table>\n<thead><tr>{line("th", head)}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody></table></div>"
    )
