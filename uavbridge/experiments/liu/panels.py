"""Maps with tracks, as the paper's Figs 5-10 and 13-19 show them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from planners.types import F64
from uavbridge.experiments.experiment import Case, Outcome
from uavbridge.experiments.liu import measures
from uavbridge.experiments.liu.setting import GRID, METHODS, TARGETS, LiuParams
from uavbridge.experiments.liu.world import Course
from uavbridge.experiments.runner import seeds_of
from uavbridge.experiments.style import INK, RED

_BELIEF = LinearSegmentedColormap.from_list("tpm", ["#ffffff", "#cfe1f2", "#6aa5d3", "#1f4e85"])


def draw_map(axes: Axes, belief: F64, course: Course | None, threshold: float = 1.0) -> None:
    """One map (columns, rows), found cells red, with the tracks of the course's first run."""
    edges = np.linspace(0.0, 1000.0, GRID.columns + 1)
    axes.pcolormesh(
        edges, edges, belief.T, cmap=_BELIEF, vmin=0.0, vmax=1.0, edgecolor="#dfe5ea", linewidth=0.4
    )
    for column, row in np.argwhere(belief >= threshold):
        axes.add_patch(Rectangle((100.0 * column, 100.0 * row), 100.0, 100.0, color=RED, lw=0))
    if course is not None:
        tracks = course.tracks[0]
        axes.plot(tracks[..., 0], tracks[..., 1], color=INK, lw=0.45, alpha=0.55)
        axes.plot(tracks[-1, :, 0], tracks[-1, :, 1], "o", ms=3.2, mfc=RED, mec="white", mew=0.5)
    axes.set(xlim=(0, 1000), ylim=(0, 1000), aspect="equal", xticks=(), yticks=())
    for spine in axes.spines.values():
        spine.set_color("#b9c2ca")


def draw_all(figure: Figure, outcome: Outcome) -> None:
    """Without targets, with targets, and ESUSTPM from the start to its last target."""
    params: LiuParams = outcome.params
    figure.set_size_inches(11.0, 7.3)
    grid = figure.subplots(3, len(METHODS))
    for axes in grid.flat:
        axes.set_axis_off()
    for row, targets in enumerate((False, True)):
        for axes, name in zip(grid[row], METHODS, strict=True):
            if name in params.chosen:
                course = _run(outcome, name, targets, params.cycles)
                found = f", {int((course.found >= 0).sum())} found" if targets else ""
                _panel(axes, course, params, f"{name}: {course.visited[0, -1]} cells{found}")
    if "esustpm" in params.chosen:
        _as_found(grid[2], outcome, params)
    for row, text in enumerate(("without targets", "with targets", "esustpm with targets")):
        first = grid[row, 0]
        first.annotate(
            text, (-0.06, 0.5), xycoords="axes fraction", rotation=90, va="center", ha="right",
            color=INK,
        )  # fmt: skip
    _scale(figure, grid[2, -1])


def _as_found(line: F64, outcome: Outcome, params: LiuParams) -> None:
    """The start, then the moments at which targets are found."""
    whole = _run(outcome, "esustpm", True, params.cycles)
    moments = [("start", 0)]
    for number, cycle in enumerate(sorted(int(cycle) for cycle in whole.found[0] if cycle >= 0)):
        moments.append((f"{number + 1} found: cycle {cycle}", cycle))
    for axes, (title, cycle) in zip(line, moments, strict=False):
        if cycle:
            course = _run(outcome, "esustpm", True, cycle)
        else:
            course = _start(_run(outcome, "esustpm", True, 1), params)
        _panel(axes, course, params, title)


def _run(outcome: Outcome, name: str, targets: bool, cycles: int) -> Course:
    """The first run of a case again, as far as ``cycles``."""
    case: Case = {"method": name, "targets": targets}
    seeds = seeds_of(outcome.experiment, case, outcome.seed, 1)
    shortened = replace(outcome.params, cycles=cycles)
    return measures.course(case, shortened, seeds, outcome.fidelity)


def _start(course: Course, params: LiuParams) -> Course:
    """The same before the first cycle."""
    belief = np.full_like(course.belief, params.prior)
    return replace(course, belief=belief, tracks=course.tracks[:, :1])


def _panel(axes: Axes, course: Course, params: LiuParams, title: str) -> None:
    axes.set_axis_on()
    draw_map(axes, course.belief[0], course, params.threshold)
    axes.set_title(title, fontsize=8.5, color=INK)
    if course.found.shape[1]:
        for column, row in TARGETS:
            axes.add_patch(
                Rectangle((100.0 * column, 100.0 * row), 100, 100, fill=False, ec=RED, lw=1.0)
            )


def _scale(figure: Figure, axes: Axes) -> None:
    from matplotlib.cm import ScalarMappable

    bar = figure.colorbar(
        ScalarMappable(cmap=_BELIEF),
        cax=axes.inset_axes((0.06, 0.5, 0.88, 0.06)),
        orientation="horizontal",
    )
    bar.set_label("P(target in cell); red: found", color=INK, size=8.5)
    bar.ax.tick_params(labelsize=8)
