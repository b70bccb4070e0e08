"""The paper's figures, drawn from rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from matplotlib.patches import Patch

from uavbridge.experiments.experiment import Outcome
from uavbridge.experiments.intervals import t_quantile
from uavbridge.experiments.rows import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS = {
    "steps": "time steps",
    "error_percent": "location errors (%)",
    "gain_percent": "gain over uncoordinated (%)",
    "bytes": "bytes sent by a UAV",
    "distance_cells": "from the cell named to the target (cells)",
}
_MARKS = dict(zip(("UNC", "BU", "AVG", "OGMM", "MOGM", "SDS", "COUNTS"), "kosv^Dx", strict=True))

_RANKS = tuple(_MARKS)[1:]
STEERING = ("found_s", "gain_percent")


def against(
    figure: Figure,
    outcome: Outcome,
    key: str,
    label: str,
    metrics: Sequence[str],
    *,
    log: bool = False,
) -> None:
    """A panel a metric: each rule's line over one key of the cases, with standard errors."""
    figure.set_size_inches(4.6 * len(metrics), 3.6)
    panels = figure.subplots(1, len(metrics), squeeze=False)[0]
    for panel, metric in zip(panels, metrics, strict=True):
        _lines(panel, [row for row in outcome.rows if row.metric == metric], key)
        panel.set_xlabel(label)
        panel.set_ylabel(LABELS[metric])
        panel.grid(alpha=0.3)
        if log:
            panel.set_xscale("log")
    panels[0].legend(fontsize=7)


def over_axes(figure: Figure, outcome: Outcome, axes: Mapping[str, Sequence[int | float]]) -> None:
    """Gain above, errors below, a column for each axis of the cases."""
    figure.set_size_inches(3.4 * len(axes), 6.4)
    panels = figure.subplots(2, len(axes), squeeze=False, sharey="row")
    for column, axis in enumerate(axes):
        for row, metric in enumerate(("gain_percent", "error_percent")):
            panel = panels[row, column]
            shown = [r for r in outcome.rows if r.metric == metric and r.case["axis"] == axis]
            _lines(panel, shown, axis)
            panel.set_xlabel(axis)
            panel.grid(alpha=0.3)
            if axis == "bytes":
                panel.set_xscale("log")
            if not column:
                panel.set_ylabel(LABELS[metric])
    panels[1, 0].legend(fontsize=7)


def _lines(panel: Axes, shown: Sequence[Row], key: str) -> None:
    plain = [row for row in shown if row.reading is None and row.mean is not None]
    for rule in dict.fromkeys(str(row.case["rule"]) for row in plain):
        points = sorted(
            (float(row.case[key]), row.mean or 0.0, row.se or 0.0)
            for row in plain
            if row.case["rule"] == rule
        )
        across, means, errors = zip(*points, strict=True)
        panel.errorbar(
            across,
            means,
            errors,
            color="k" if rule == "UNC" else f"C{_RANKS.index(rule)}",
            marker="." if rule == "UNC" else _MARKS.get(rule, "."),
            markersize=4,
            linewidth=1.0,
            label=rule,
        )


def bars(figure: Figure, outcome: Outcome) -> None:
    """Table II: our gains as bars, the printed ones as lines across them."""
    shown = [row for row in outcome.rows if row.metric == "gain_percent" and row.reading is None]
    ranges = sorted({int(row.case["range"]) for row in shown})
    rules = list(dict.fromkeys(str(row.case["rule"]) for row in shown))
    figure.set_size_inches(3.8 * len(ranges), 3.6)
    panels = figure.subplots(1, len(ranges), squeeze=False, sharey=True)[0]
    width = 0.8 / len(rules)
    for panel, reach in zip(panels, ranges, strict=True):
        for place, rule in enumerate(rules):
            for row in shown:
                if row.case["range"] != reach or row.case["rule"] != rule:
                    continue
                x = int(row.case["N"]) + (place - (len(rules) - 1) / 2) * width
                label = rule if row.case["N"] == shown[0].case["N"] else None
                panel.bar(x, row.mean or 0.0, width, yerr=row.se, color=f"C{place}", label=label)
                if row.paper is not None:
                    panel.hlines(row.paper, x - width / 2, x + width / 2, color="k", linewidth=1.5)
        panel.set_title(f"range {reach}")
        panel.set_xlabel("N")
        panel.set_xticks(sorted({int(row.case["N"]) for row in shown}))
        panel.grid(axis="y", alpha=0.3)
    panels[0].set_ylabel("gain over uncoordinated (%); line: paper")
    panels[0].legend(fontsize=7)


def steering(figure: Figure, outcome: Outcome) -> None:
    """Time until the target is declared above, gain below; a column a range, bars by planner."""
    rows = [row for row in outcome.rows if row.mean is not None]
    ranges = list(dict.fromkeys(int(row.case["range"]) for row in rows))
    planners = list(dict.fromkeys(str(row.case["planner"]) for row in rows))
    rules = list(dict.fromkeys(str(row.case["rule"]) for row in rows))
    figure.set_size_inches(1.0 + 4.4 * len(ranges), 6.2)
    panels = figure.subplots(2, len(ranges), squeeze=False, sharey="row", sharex=True)
    width = 0.8 / len(planners)
    for row in rows:
        if row.metric not in STEERING:
            continue
        panel = panels[STEERING.index(row.metric), ranges.index(int(row.case["range"]))]
        place = planners.index(str(row.case["planner"]))
        x = rules.index(str(row.case["rule"])) + (place - (len(planners) - 1) / 2.0) * width
        wide = (row.se or 0.0) * (t_quantile(row.n - 1) if row.n > 1 else 0.0)
        panel.bar(x, row.mean or 0.0, width, yerr=wide, color=f"C{place}", error_kw={"lw": 0.8})
    for reach, column in zip(ranges, panels.T, strict=True):
        column[0].set_title(f"range {reach} cells")
        column[1].set_xticks(range(len(rules)), rules)
        for panel in column:
            panel.grid(axis="y", alpha=0.3)
    panels[0, 0].set_ylim(bottom=0)
    panels[0, 0].set_ylabel("time until the target is declared (s)")
    panels[1, 0].set_ylabel("gain over the same planner alone (%)")
    marks = [Patch(color=f"C{place}", label=name) for place, name in enumerate(planners)]
    figure.legend(handles=marks, loc="outside lower center", ncols=len(planners), frameon=False)
