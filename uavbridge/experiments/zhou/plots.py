"""The pictures of the Zhou experiments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D

from uavbridge.experiments.experiment import Outcome
from uavbridge.experiments.style import FAINT, GREEN, INDIGO, INK, ORANGE, PURPLE, RED, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = (GREEN, INDIGO, ORANGE, PURPLE, RED)
LABELS = {
    "steps": "steps",
    "energy": "energy (km driven by all)",
    "found": "targets found",
}
SCALE = {"steps": 1.0, "energy": 1e-3}


def against_paper(figure: Figure, outcome: Outcome) -> None:
    """Steps and energy over n_u: every run, our mean, the printed mean and sd."""
    figure.set_size_inches(9.6, 3.9)
    for axes, metric in zip(figure.subplots(1, 2), ("steps", "energy"), strict=True):
        for row in outcome.rows:
            if row.metric == metric and row.reading is None and row.paper is not None:
                _printed(axes, outcome, metric, float(row.case["n_u"]), row.paper)
        for case, samples in outcome.samples:
            if "reading" not in case:
                _runs(axes, float(case["n_u"]), samples[metric] * SCALE[metric])
            elif np.isfinite(samples[metric]).any():
                mean = np.nanmean(samples[metric]) * SCALE[metric]
                axes.plot(float(case["n_u"]) + 0.8, mean, "x", ms=5, color=FAINT)
        axes.set_title(LABELS[metric], loc="left", color=INK)
        axes.set_xlabel("robots")
        axes.set_ylim(bottom=0.0)
        plain(axes)
    handles = [
        Line2D([], [], ls="", marker="_", ms=13, mew=2.2, color=INK, label="printed, ± sd"),
        Line2D([], [], ls="", marker="o", ms=6, color=GREEN, label="ours, mean"),
        Line2D([], [], ls="", marker=".", ms=5, color=GREEN, alpha=0.4, label="ours, runs"),
        Line2D([], [], ls="", marker="x", ms=5, color=FAINT, label="ours, other readings"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)


def _printed(axes: Axes, outcome: Outcome, metric: str, n_u: float, mean: float) -> None:
    spread = [
        row.paper
        for row in outcome.rows
        if row.metric == f"{metric}_sd" and row.case["n_u"] == n_u and row.paper is not None
    ]
    scale = SCALE[metric]
    axes.plot(n_u - 0.8, mean * scale, "_", ms=13, mew=2.2, color=INK)
    if spread:
        axes.errorbar(n_u - 0.8, mean * scale, spread[0] * scale, color=INK, lw=1.0)


def _runs(axes: Axes, n_u: float, values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
    known = values[np.isfinite(values)]
    axes.plot(np.full(len(known), n_u + 0.4), known, ".", ms=4, color=GREEN, alpha=0.35)
    if len(known):
        axes.plot(n_u + 0.4, known.mean(), "o", ms=6, color=GREEN)
    if len(known) < len(values):
        axes.annotate(f"{len(known)}/{len(values)}", (n_u, 0.0), ha="center", color=RED, fontsize=7)


def sweeps(figure: Figure, outcome: Outcome, axes_of: Mapping[str, str], metric: str) -> None:
    """A panel a swept key: the mean of a metric with its quartiles, by n_u."""
    figure.set_size_inches(4.2 * len(axes_of) + 1.0, 3.9)
    panels = figure.subplots(1, len(axes_of), squeeze=False, sharey=True)[0]
    for axes, (key, label) in zip(panels, axes_of.items(), strict=True):
        rows = [row for row in outcome.rows if row.metric == metric and key in row.case]
        for colour, n_u in zip(COLOURS, sorted({row.case["n_u"] for row in rows}), strict=False):
            mine = [row for row in rows if row.case["n_u"] == n_u and row.mean is not None]
            at = [float(row.case[key]) for row in mine]
            axes.fill_between(
                at, [row.q25 or 0.0 for row in mine], [row.q75 or 0.0 for row in mine],
                color=colour, alpha=0.15, lw=0,
            )  # fmt: skip
            axes.plot(at, [row.mean for row in mine], "o-", ms=4, color=colour, label=f"{n_u}")
        axes.set_xlabel(label)
        axes.set_ylim(bottom=0.0)
        plain(axes)
    panels[0].set_title(LABELS.get(metric, metric), loc="left", color=INK)
    panels[-1].legend(title="robots", frameon=False)
