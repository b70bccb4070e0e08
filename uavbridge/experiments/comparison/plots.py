"""Pictures of compared planners."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from uavbridge.experiments.comparison.compare import mission_of, of_planner
from uavbridge.experiments.experiment import FIDELITIES, Outcome
from uavbridge.experiments.intervals import half_width
from uavbridge.experiments.style import GREEN, INDIGO, INK, ORANGE, PURPLE, RED, plain

_COLOURS = (RED, GREEN, PURPLE, ORANGE, INDIGO, INK)
_CURVES = {
    "coverage": "share of cells seen",
    "entropy": "entropy of the union (bits)",
    "targets_found": "targets declared",
    "components": "groups out of each other's reach",
    "age_s": "age of what is known of others (s)",
    "bytes_per_agent": "bytes sent an agent (kB)",
}
_FIGURES = {
    "coverage_s": "time to the coverage goal (s)",
    "goal_s": "time to the mission's goal (s)",
    "targets_found": "targets declared",
    "false_targets": "false targets",
    "entropy": "entropy at the end (bits)",
}
_MARKS = {"ideal": "o", "dynamics": "s", "mavlink": "^"}


def over_time(figure: Figure, outcome: Outcome) -> None:
    """A panel a curve: mean and its 95 % interval."""
    figure.set_size_inches(10.5, 6.2)
    names = of_planner(outcome)
    mission = mission_of(outcome.params, names[0], 1)
    axis = outcome.experiment.axis
    assert axis is not None
    t_s = np.array(axis.values) * mission.duration
    most = {"coverage": 1.0, "targets_found": float(len(mission.targets))}  # no interval goes on
    for axes, (name, title) in zip(figure.subplots(2, 3).flat, _CURVES.items(), strict=True):
        for place, (_, samples) in enumerate(outcome.samples):
            values = samples[f"{name}@share"] / (1000.0 if name == "bytes_per_agent" else 1.0)
            mean = values.mean(axis=0)
            wide = half_width(values.std(axis=0, ddof=min(1, len(values) - 1)), len(values))
            colour = _COLOURS[place % len(_COLOURS)]
            low, high = np.clip((mean - wide, mean + wide), 0.0, most.get(name))
            axes.fill_between(t_s, low, high, color=colour, alpha=0.15, lw=0)
            axes.plot(t_s, mean, color=colour, lw=1.6)
        axes.set_title(title, loc="left", color=INK)
        axes.set_xlim(0, t_s[-1])
        axes.set_ylim(bottom=0)
        plain(axes)
    for axes in figure.axes[3:]:
        axes.set_xlabel("time since the search began (s)")
    handles = [
        Line2D([], [], color=_COLOURS[place % len(_COLOURS)], lw=2, label=name)
        for place, name in enumerate(names)
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=6, frameon=False)


def by_fidelity(figure: Figure, outcome: Outcome) -> None:
    """A panel a figure: every planner in every fidelity, mean and 95 % interval."""
    figure.set_size_inches(11.0, 6.4)
    planners = list(dict.fromkeys(of_planner(outcome)))
    used = [name for name in FIDELITIES if any(c["fidelity"] == name for c, _ in outcome.samples)]
    panels = figure.subplots(2, 3).flat
    for axes, (metric, title) in zip(panels, _FIGURES.items(), strict=False):
        for case, samples in outcome.samples:
            values = samples[metric][np.isfinite(samples[metric])]
            place = used.index(str(case["fidelity"]))
            x = planners.index(str(case["planner"])) + 0.22 * (place - (len(used) - 1) / 2.0)
            colour = _COLOURS[place]
            if len(values) > 1:
                wide = half_width(values.std(ddof=1), len(values))
                axes.errorbar(x, values.mean(), wide, color=colour, lw=1.2, capsize=2.5)
            if len(values):
                mark = _MARKS[used[place]]
                axes.plot(x, values.mean(), mark, ms=5, color=colour)
            if len(values) < outcome.runs:
                text = f"{len(values)}/{outcome.runs}"
                axes.annotate(
                    text, (x, 1.0), xycoords=("data", "axes fraction"), rotation=90, ha="center",
                    va="top", fontsize=6.5, color=colour,
                )  # fmt: skip
        axes.set_title(title, loc="left", color=INK)
        axes.set_xticks(range(len(planners)), planners, rotation=20)
        axes.set_xlim(-0.6, len(planners) - 0.4)
        axes.set_ylim(bottom=0)
        axes.margins(y=0.2)
        plain(axes)
        axes.grid(visible=False, axis="x")
    last = figure.axes[-1]
    last.set_axis_off()
    handles = [
        Line2D([], [], ls="", marker=_MARKS[name], color=_COLOURS[place], label=name)
        for place, name in enumerate(used)
    ]
    last.legend(handles=handles, loc="center", frameon=False, fontsize=10)
