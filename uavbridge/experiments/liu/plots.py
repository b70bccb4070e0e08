"""The pictures of the Liu experiments. Methods have the paper's colours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from planners.types import F64
from uavbridge.experiments.experiment import Outcome
from uavbridge.experiments.rows import Row
from uavbridge.experiments.style import FAINT, GREEN, INDIGO, INK, ORANGE, PURPLE, RED, plain

COLOURS = {
    "random": INDIGO,
    "mower": PURPLE,
    "boids": ORANGE,
    "boids-guided": GREEN,
    "esustpm": RED,
}
LABELS = {
    "visited_cells": "cells visited",
    "uncertainty": "uncertainty (one-sided)",
    "entropy": "entropy (bits)",
    "targets_found": "targets found",
}


def against_paper(figure: Figure, outcome: Outcome, metrics: Sequence[tuple[str, str]]) -> None:
    """A panel a metric: the paper's number, ours, and ours in other readings."""
    figure.set_size_inches(9.6, 6.4)
    panels = figure.subplots(2, 2)
    methods = [name for name in COLOURS if name in outcome.params.chosen]
    for axes, (metric, label) in zip(panels.flat, metrics, strict=True):
        for row in outcome.rows:
            if row.metric == metric:
                _dot(axes, row, methods)
        axes.set_xticks(range(len(methods)), methods)
        axes.set_title(label, loc="left", color=INK)
        axes.set_xlim(-0.6, len(methods) - 0.4)
        plain(axes)
        axes.grid(visible=False, axis="x")
    handles = [
        Line2D([], [], ls="", marker="_", ms=13, mew=2.2, color=INK, label="printed"),
        Line2D([], [], ls="", marker="o", ms=6, color=FAINT, label="ours, with targets"),
        Line2D([], [], ls="", marker="o", ms=6, mfc="white", color=FAINT, label="ours, without"),
    ]
    shown = dict.fromkeys(row.reading for row in outcome.rows if row.reading is not None)
    handles += [
        Line2D(
            [], [], ls="", marker=_MARKS.get(label, "."), ms=5.5, mfc="w", color=FAINT, label=label
        )
        for label in shown
        if label in _MARKS
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)


_MARKS = {"speed_reading=norm": "x", "speed_reading=none": "+", "boids_speed_m=14.14": "^"}


def _dot(axes: Axes, row: Row, methods: Sequence[str]) -> None:
    if row.mean is None:
        return
    method, targets = str(row.case["method"]), bool(row.case["targets"])
    place = methods.index(method) + (-0.16 if targets else 0.16)
    colour = COLOURS[method]
    if row.paper is not None and row.reading is None:
        axes.plot(place, row.paper, "_", ms=13, mew=2.2, color=INK, zorder=2)
    if row.reading is not None:
        mark = _MARKS.get(row.reading, ".")
        axes.plot(place, row.mean, mark, ms=5.5, mfc="white", color=colour, alpha=0.8, zorder=3)
        return
    face = colour if targets else "white"
    axes.plot(place, row.mean, "o", ms=6, color=colour, mfc=face, zorder=4)


def over_time(figure: Figure, outcome: Outcome, metrics: Sequence[str]) -> None:
    """A panel a metric: the mean of every method, and its quartiles as a band."""
    axis = outcome.experiment.axis
    assert axis is not None
    figure.set_size_inches(9.6, 6.4 if len(metrics) > 3 else 3.6)
    panels = figure.subplots(2, 2) if len(metrics) > 3 else figure.subplots(1, len(metrics))
    for axes, metric in zip(np.ravel(panels), metrics, strict=True):
        for case, samples in outcome.samples:
            values = samples[f"{metric}@{axis.name}"]
            colour = COLOURS[str(case["method"])]
            if metric != "targets_found":  # few whole numbers: their quartiles jump
                low, high = np.quantile(values, (0.25, 0.75), axis=0)
                axes.fill_between(axis.values, low, high, color=colour, alpha=0.15, lw=0)
            axes.plot(axis.values, values.mean(axis=0), color=colour, lw=1.7)
        axes.set_title(LABELS[metric], loc="left", color=INK)
        axes.set_xlabel("cycle")
        axes.set_xlim(0, axis.values[-1])
        plain(axes)
    methods = [str(case["method"]) for case, _ in outcome.samples]
    handles = [Line2D([], [], color=COLOURS[name], lw=2, label=name) for name in methods]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(methods), frameon=False)


def boxes(figure: Figure, outcome: Outcome) -> None:
    """Figs 28, 29 and 30: coverage time, uncertainty, and the times of the targets."""
    figure.set_size_inches(9.6, 6.6)
    panels = figure.subplot_mosaic("AB;CC")
    coverage, uncertainty, targets = panels["A"], panels["B"], panels["C"]
    methods = [name for name in COLOURS if name in outcome.params.chosen]
    bare = [outcome.of(method=name, targets=False) for name in methods]
    colours = [COLOURS[name] for name in methods]
    for axes, metric, title in (
        (coverage, "coverage_cycle", "cycle of full coverage, without targets"),
        (
            uncertainty,
            "uncertainty",
            f"uncertainty at cycle {outcome.params.cycles}, without targets",
        ),
    ):
        values = [samples[metric] for samples in bare]
        _boxplot(axes, values, range(len(methods)), colours, outcome.runs)
        axes.set_xticks(range(len(methods)), methods)
        axes.set_title(title, loc="left", color=INK)
    coverage.set_ylim(0, outcome.params.cycles * 1.12)
    sought = [outcome.of(method=name, targets=True) for name in methods]
    for number in (1, 2, 3):
        values = [samples[f"target_{number}_cycle"] for samples in sought]
        places = [(number - 1) * (len(methods) + 1) + place for place in range(len(methods))]
        _boxplot(targets, values, places, colours, outcome.runs)
    middle = (len(methods) - 1) / 2.0
    ticks = [middle + number * (len(methods) + 1) for number in range(3)]
    targets.set_xticks(ticks, ["one target found", "two targets", "three targets"])
    targets.set_title("cycle at which targets are found", loc="left", color=INK)
    targets.set_ylim(0, outcome.params.cycles * 1.12)
    handles = [Patch(color=COLOURS[name], label=name) for name in methods]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(methods), frameon=False)


def priors(figure: Figure, outcome: Outcome) -> None:
    """Fig. 23 and Fig. 26: the prior map, and the times of the targets by prior."""
    from uavbridge.experiments.liu.panels import draw_map
    from uavbridge.experiments.liu.prior import prior_map

    figure.set_size_inches(9.6, 3.9)
    chart, times, wrong = figure.subplots(1, 3, width_ratios=(1.0, 1.5, 0.8))
    draw_map(chart, prior_map(outcome.params), None)
    chart.set_title("the prior map", loc="left", color=INK)
    names = ("none", "accurate", "false-target", "hidden-target")
    colours = dict(zip(names, (FAINT, GREEN, ORANGE, PURPLE), strict=True))
    labels = []
    place = 0
    for number in (1, 2, 3):
        first = place
        for name in names:
            samples = outcome.of(prior=name)
            if f"target_{number}_cycle" in samples:
                values = [samples[f"target_{number}_cycle"]]
                _boxplot(times, values, [place], [colours[name]], outcome.runs)
                place += 1
        labels.append(((first + place - 1) / 2.0, ("one", "two", "three")[number - 1]))
        place += 1
    times.set_xticks([at for at, _ in labels], [text for _, text in labels])
    times.set_title("cycle at which targets are found", loc="left", color=INK)
    times.set_xlabel("targets found")
    times.set_ylim(0, outcome.params.cycles * 1.12)
    empty = ("false-target", "hidden-target")
    values = [outcome.of(prior=name)["wrong_cell_probability"] for name in empty]
    _boxplot(wrong, values, range(2), [colours[name] for name in empty], outcome.runs)
    wrong.axhline(outcome.params.peak, color=INK, lw=0.9, ls=":")
    wrong.set_xticks(range(2), ["false", "hidden"])
    wrong.set_ylim(0, 1)
    wrong.set_title("final P, no target there", loc="left", color=INK)
    handles = [Patch(color=colours[name], label=name) for name in names]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)


def maps(figure: Figure, outcome: Outcome) -> None:
    """Figs 5-10 and 13-19."""
    from uavbridge.experiments.liu import panels

    panels.draw_all(figure, outcome)


def _boxplot(
    axes: Axes,
    values: Sequence[F64],
    places: Sequence[int],
    colours: Sequence[str],
    runs: int,
) -> None:
    """Boxes of the runs that have a value, and above how many those are, when not all."""
    known = [part[np.isfinite(part)] for part in values]
    drawn = axes.boxplot(
        known,
        positions=list(places),
        widths=0.62,
        patch_artist=True,
        manage_ticks=False,
        medianprops={"color": "white", "linewidth": 1.6},
        flierprops={"marker": ".", "markersize": 3, "markeredgecolor": FAINT},
        whiskerprops={"color": FAINT},
        capprops={"color": FAINT},
    )
    for box, line, colour, part in zip(
        drawn["boxes"], drawn["medians"], colours, known, strict=True
    ):
        box.set(facecolor=colour, edgecolor=colour)
        if len(part) and part.max() == part.min():  # a box without height: show its line
            line.set(color=colour, linewidth=2.4)
    left, right = axes.get_xlim()
    axes.set_xlim(min(left, min(places) - 0.6), max(right, max(places) + 0.6))
    for place, part in zip(places, known, strict=True):
        if len(part) < runs:
            text = f"{len(part)}/{runs}"
            axes.annotate(
                text, (place, 1.0), xycoords=("data", "axes fraction"), ha="center", va="top",
                fontsize=7, color=INK,
            )  # fmt: skip
    plain(axes)
    axes.grid(visible=False, axis="x")
