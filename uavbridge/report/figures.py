"""The pictures of the report, as figures that ``drawn`` turns into SVG and PNG.

matplotlib by its objects alone (no pyplot, so no state shared by threads but
the settings of ``drawn``). Colours stay apart for colour-blind eyes and in grey.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

from planners.grid import Grid
from planners.types import F64
from uavbridge.report.overlays import draw_columns
from uavbridge.report.relief import draw_ground, draw_members
from uavbridge.report.result import AgentResult, MissionResult, Series

INK, FAINT, PAPER = "#24303c", "#8b97a3", "#ffffff"
BLUE, ORANGE, RED, TEAL = "#2a6fb0", "#e08a1e", "#c8402f", "#1d8a7a"

# Tol's "muted" scheme in an order that keeps neighbours apart.
_TRACKS = (
    "#332288", "#117733", "#882255", "#44aa99", "#aa4499",
    "#2a6fb0", "#999933", "#cc6677", "#24303c", "#6699cc",
)  # fmt: skip
_NAMED = 20  # more agents than this are not told apart by colour or number
_POINTS = 500  # of a track, at most
_BELIEF = LinearSegmentedColormap.from_list("belief", ["#ffffff", "#fde7c0", "#f6b96b", "#e58a34"])


def map_figure(result: MissionResult) -> Figure:
    """Tracks over the final map: north up, axes in metres from home."""
    grid = result.grid
    tall = 5.6 * grid.rows / grid.columns + 1.1
    figure = Figure(figsize=(7.4, min(max(tall, 3.0), 6.7)), layout="constrained")
    axes = figure.add_subplot()
    if result.belief is not None:
        image = axes.pcolormesh(
            *_edges(grid), result.belief.T, cmap=_BELIEF, vmin=0.0, vmax=1.0, linewidth=0
        )
        bar = figure.colorbar(image, ax=axes, shrink=0.5, aspect=26, pad=0.02)
        bar.set_label("belief: P(target in cell)", color=INK, size=9)
        bar.outline.set_visible(False)
        bar.ax.tick_params(labelsize=8.5, length=3, colors=INK)
    if result.terrain is not None:
        draw_ground(axes, result.terrain, result.climb_rad)
    _unseen(axes, result)
    draw_columns(axes, result.columns)
    if not result.by_signal:
        _grid_lines(axes, grid)
    _tracks(axes, result.tracks)
    _targets(axes, result)
    _frame_map(axes, result)
    handles = _map_legend(result)
    figure.legend(
        handles=handles, loc="outside lower center", ncols=max(len(handles), 1),
        frameon=False, handletextpad=0.4, columnspacing=1.4, fontsize=8.5,
    )  # fmt: skip
    return figure


def progress_figure(result: MissionResult) -> Figure:
    """Coverage, entropy and targets over time."""
    series = result.series
    if result.by_signal:
        return _found_figure(result)
    figure = Figure(figsize=(7.4, 4.8), layout="constrained")
    coverage, entropy, targets = figure.subplots(3, 1, sharex=True, height_ratios=(1, 1, 0.8))
    coverage.plot(series.t_s, series.coverage * 100, color=BLUE, lw=1.8)
    coverage.fill_between(series.t_s, series.coverage * 100, color=BLUE, alpha=0.12, lw=0)
    coverage.set(ylim=(0, 104), ylabel="coverage (%)", yticks=(0, 50, 100))
    if np.isfinite(result.coverage_goal):
        _limit(coverage, result.coverage_goal * 100, f"goal {result.coverage_goal:.0%}", INK)
    entropy.plot(series.t_s, series.entropy, color=ORANGE, lw=1.8, label="entropy")
    entropy.plot(
        series.t_s, series.uncertainty, color=INK, lw=1.1, ls=(0, (4, 2)), label="one-sided (Liu)"
    )
    entropy.set_ylabel("entropy (bits)")
    entropy.set_ylim(bottom=0)
    entropy.legend(frameon=False, loc="upper right", ncols=2, fontsize=8.5)
    _found(targets, result)
    figure.align_ylabels()
    for axes in (coverage, entropy, targets):
        _plain(axes)
    return figure


def _found(axes: Axes, result: MissionResult) -> None:
    """Targets found over time."""
    series = result.series
    axes.step(series.t_s, series.declared, where="post", color=TEAL, lw=1.8)
    for target in result.targets:
        if target.found_at_s is not None:
            axes.axvline(target.found_at_s, color=TEAL, lw=0.8, ls=":", zorder=0)
    total = max(len(result.targets), 1)
    axes.set(ylim=(0, total * 1.15), ylabel="targets found")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=4))
    _time_axis(axes, series)


def _found_figure(result: MissionResult) -> Figure:
    figure = Figure(figsize=(7.4, 2.2), layout="constrained")
    axes = figure.add_subplot()
    _found(axes, result)
    _plain(axes)
    return figure


def alliances_figure(result: MissionResult) -> Figure:
    """Members of each target's suballiance over time."""
    alliances = result.alliances
    figure = Figure(figsize=(7.4, 4.4), layout="constrained")
    axes = figure.add_subplot()
    if alliances is not None:
        found_at = [target.found_at_s for target in result.targets]
        draw_members(axes, alliances.t_s, alliances.members, alliances.first, found_at)
    _time_axis(axes, result.series)
    _plain(axes)
    return figure


def separation_figure(result: MissionResult) -> Figure:
    """Distance of the closest pair over time, with the limit."""
    series = result.series
    figure = Figure(figsize=(7.4, 2.5), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(series.t_s, series.separation_m, color=BLUE, lw=1.4)
    known = series.separation_m[np.isfinite(series.separation_m)]
    limit = result.separation_limit_m
    seen = [float(value) for value in (*known, limit) if value > 0] or [10.0]
    low, high = min(seen) / 1.6, max(seen) * 1.3
    if np.isfinite(limit):
        axes.axhspan(low, limit, color=RED, alpha=0.10, lw=0)
        _limit(axes, limit, f"limit {limit:g} m", RED)
    if known.size:
        place = int(np.nanargmin(series.separation_m))
        _closest(axes, float(series.t_s[place]), float(series.separation_m[place]), series)
    # What matters is near the limit, so a factor takes the same height everywhere.
    axes.set(yscale="log", ylim=(low, high), ylabel="closest pair (m)")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    _time_axis(axes, series)
    _plain(axes)
    return figure


def bytes_figure(agents: Sequence[AgentResult]) -> Figure:
    """Bytes sent and heard, a stacked bar an agent."""
    figure = Figure(figsize=(7.4, 2.6), layout="constrained")
    axes = figure.add_subplot()
    sent = np.array([agent.bytes_sent for agent in agents], dtype=np.float64)
    heard = np.array([agent.bytes_heard for agent in agents], dtype=np.float64)
    most = float((sent + heard).max()) if len(agents) else 0.0
    unit, scale = next(
        ((unit, size) for unit, size in (("MB", 1e6), ("kB", 1e3)) if most >= 2 * size), ("B", 1.0)
    )
    places = np.arange(len(agents))
    axes.bar(places, heard / scale, width=0.72, color="#a9c8e6", label="heard")
    axes.bar(places, sent / scale, bottom=heard / scale, width=0.72, color=BLUE, label="sent")
    every = -(-len(agents) // _NAMED) or 1
    axes.set_xticks(places[::every], [str(agent.id) for agent in agents[::every]])
    axes.set(ylabel=f"bytes ({unit})", xlabel="agent")
    axes.margins(x=0.02, y=0.22)
    axes.legend(frameon=False, loc="upper right", ncols=2, reverse=True, fontsize=8.5)
    _plain(axes)
    axes.grid(visible=False, axis="x")
    axes.tick_params(axis="x", length=0)
    return figure


def _edges(grid: Grid) -> tuple[F64, F64]:
    west, south, east, north = grid.bounds
    return np.linspace(west, east, grid.columns + 1), np.linspace(south, north, grid.rows + 1)


def _unseen(axes: Axes, result: MissionResult) -> None:
    """Hatch the cells that nobody looked at."""
    if result.seen is None:
        return
    paper = "#e9edf1" if result.terrain is None else "none"  # hills are seen through it
    for cell in np.argwhere(~result.seen):
        corner = result.grid.centre_of(cell) - result.grid.cell_m / 2
        axes.add_patch(
            Rectangle(
                (corner[0], corner[1]), result.grid.cell_m, result.grid.cell_m,
                facecolor=paper, edgecolor="#c3ccd5", hatch="////", lw=0,
            )
        )  # fmt: skip


def _grid_lines(axes: Axes, grid: Grid) -> None:
    if max(grid.shape) > 60:
        return
    columns, rows = _edges(grid)
    axes.vlines(columns, rows[0], rows[-1], color="#d5dce3", lw=0.5)
    axes.hlines(rows, columns[0], columns[-1], color="#d5dce3", lw=0.5)


def _tracks(axes: Axes, tracks: Mapping[int, F64]) -> None:
    named = len(tracks) <= _NAMED
    for place, (agent, track) in enumerate(sorted(tracks.items())):
        track = track[np.isfinite(track).all(axis=1)]
        if len(track) == 0:
            continue
        colour = _TRACKS[place % len(_TRACKS)] if named else "#3f5f8a"
        points = track[:: max(1, len(track) // _POINTS), :2]
        lines = LineCollection([points], colors=colour, linewidths=1.0 if named else 0.5)
        lines.set_alpha(0.75 if named else 0.35)
        lines.set_capstyle("round")
        axes.add_collection(lines, autolim=False)
        x, y = (float(value) for value in points[0])
        size = 11.0 if named else 3.0
        axes.plot(x, y, "o", ms=size, mfc=colour, mec=PAPER, mew=0.8, zorder=5)
        if named:
            axes.text(
                x, y, str(agent), color=PAPER, size=6.5, weight="bold", ha="center",
                va="center_baseline", zorder=6,
            )  # fmt: skip


def _targets(axes: Axes, result: MissionResult) -> None:
    grid = result.grid
    for place, target in enumerate(result.targets, 1):
        x, y = target.position or grid.centre_of(target.cell)
        if result.by_signal:
            _number(axes, x, y, place)
        if target.found_at_s is not None and result.by_signal:
            axes.plot(x, y, "o", ms=20, mfc="none", mec=TEAL, mew=2.0, zorder=7)
        elif target.found_at_s is not None:
            _ring(axes, grid, target.cell, TEAL)
        axes.plot(x, y, "*", ms=15, mfc="#ffd23f", mec=INK, mew=1.0, zorder=8)
    for cell in result.false_targets:
        _ring(axes, grid, cell, RED)
        x, y = grid.centre_of(cell)
        axes.plot(x, y, "X", ms=9, mfc=RED, mec=PAPER, mew=0.8, zorder=8)


def _number(axes: Axes, x: float, y: float, place: int) -> None:
    axes.annotate(
        str(place), (x, y), (11, 7), textcoords="offset points", color=INK, size=8, zorder=9,
    )  # fmt: skip


def _ring(axes: Axes, grid: Grid, cell: tuple[int, int], colour: str) -> None:
    x, y = grid.centre_of(cell) - grid.cell_m / 2
    side = grid.cell_m
    axes.add_patch(Rectangle((x, y), side, side, fill=False, ec=colour, lw=2.4, zorder=7))


def _frame_map(axes: Axes, result: MissionResult) -> None:
    """Show the area and every track, both axes to one scale."""
    west, south, east, north = result.grid.bounds
    corners = [np.array([[west, south], [east, north]])]
    corners += [track[:, :2] for track in result.tracks.values() if len(track)]
    points = np.vstack(corners)
    margin = 0.025 * max(east - west, north - south)
    low, high = np.nanmin(points, axis=0) - margin, np.nanmax(points, axis=0) + margin
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_aspect("equal")
    axes.set_xlabel("east of home (m)")
    axes.set_ylabel("north of home (m)")
    _plain(axes)
    axes.grid(visible=False)


def _map_legend(result: MissionResult) -> list[Line2D | Rectangle]:
    def marker(shape: str, size: float, face: str, edge: str, label: str) -> Line2D:
        return Line2D([], [], ls="", marker=shape, ms=size, mfc=face, mec=edge, label=label)

    handles: list[Line2D | Rectangle] = []
    if result.tracks:
        handles.append(marker("o", 8, INK, PAPER, "start and track"))
    if result.targets:
        handles.append(marker("*", 12, "#ffd23f", INK, "target"))
        shape, word = ("o", "found") if result.by_signal else ("s", "declared")
        handles.append(marker(shape, 9, "none", TEAL, word))
    if result.false_targets:
        handles.append(marker("X", 8, RED, PAPER, "declared, but nothing there"))
    if result.terrain is not None and result.terrain.steepest() > result.climb_rad + 1e-9:
        label = f"slopes above {math.degrees(result.climb_rad):g}°"
        handles.append(Rectangle((0, 0), 1, 1, fc="#d9483b", alpha=0.55, lw=0, label=label))
    if len(result.columns):
        handles.append(
            Rectangle((0, 0), 1, 1, fc="none", ec=RED, hatch="xxxx", lw=0.5, label="no-fly column")
        )
    if result.seen is not None and not result.seen.all():
        handles.append(
            Rectangle(
                (0, 0), 1, 1, fc="#e9edf1", ec="#a9b4bf", hatch="////", lw=0.5, label="never seen"
            )
        )
    return handles


def _closest(axes: Axes, at: float, low: float, series: Series) -> None:
    """Mark the closest approach, with room for its number on either side."""
    late = at > series.t_s[-1] * 0.7
    axes.plot(at, low, "o", ms=5, mfc=PAPER, mec=BLUE, mew=1.6, zorder=5)
    axes.annotate(
        f"{low:.1f} m", (at, low), (-8 if late else 8, -4), textcoords="offset points",
        ha="right" if late else "left", va="top", color=BLUE, weight="bold", size=9,
    )  # fmt: skip


def _limit(axes: Axes, value: float, text: str, colour: str) -> None:
    axes.axhline(value, color=colour, lw=1.0, ls=(0, (5, 3)))
    axes.annotate(
        text, (0.006, value), (0, 2), xycoords=("axes fraction", "data"),
        textcoords="offset points", ha="left", va="bottom", color=colour, size=8,
    )  # fmt: skip


def _time_axis(axes: Axes, series: Series) -> None:
    if series.t_s.size:
        axes.set_xlim(0, max(float(series.t_s[-1]), 1.0))
    axes.set_xlabel("mission time (s)")


def _plain(axes: Axes) -> None:
    """Light lines, no box."""
    axes.grid(visible=True, color="#e6eaee", lw=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK, length=3, color=FAINT, labelsize=8.5)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(FAINT)
    for label in (axes.xaxis.label, axes.yaxis.label):
        label.set_color(INK)
        label.set_fontsize(9)
