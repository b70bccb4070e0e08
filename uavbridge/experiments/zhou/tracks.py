"""The picture of zhou-trace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from planners.terrain import Terrain
from uavbridge.experiments.style import GREEN, INDIGO, INK, ORANGE, RED, plain
from uavbridge.report.relief import draw_ground, draw_members

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from uavbridge.experiments.zhou.trace import Trace

_FIGURES = ("slopes up to beta (Fig. 5)", "slopes above beta in places (Fig. 6)")
_ZOOM_M = 130.0


def draw(figure: Figure, runs: Sequence[Trace], climb_rad: float) -> None:
    """A row a run: all tracks, one suballiance, members over time."""
    figure.set_size_inches(12.0, 3.9 * len(runs))
    grid = figure.subplots(len(runs), 3, squeeze=False, width_ratios=(1.0, 1.0, 1.2))
    for axes, run, title in zip(grid, runs, _FIGURES, strict=False):
        _whole(axes[0], run, climb_rad)
        axes[0].set_title(title, loc="left", color=INK)
        _alliance(axes[1], run, climb_rad)
        _members(axes[2], run)


def ground(axes: Axes, terrain: Terrain, climb_rad: float) -> None:
    """Heights as shade and contours; in red the cells with slopes above beta."""
    draw_ground(axes, terrain, climb_rad)
    axes.set_aspect("equal")
    axes.tick_params(colors=INK, length=3, width=0.8)


def _whole(axes: Axes, run: Trace, climb_rad: float) -> None:
    ground(axes, run.terrain, climb_rad)
    axes.plot(run.tracks[:, :, 0], run.tracks[:, :, 1], lw=0.5, color=INDIGO, alpha=0.55)
    axes.plot(*run.tracks[0, :, :2].T, ".", ms=3, color=GREEN)
    axes.plot(*run.targets.T, "*", ms=10, color=ORANGE, mec=INK, mew=0.5)
    for number, place in enumerate(run.targets, 1):
        axes.annotate(f"{number}", place, (5, 4), textcoords="offset points", fontsize=7)


def _alliance(axes: Axes, run: Trace, climb_rad: float) -> None:
    """The members of one target, from the first one's joining to its finding."""
    worked = (run.task[..., None] == np.arange(len(run.targets))).sum(axis=(0, 1))
    target = int(np.where(run.reached_at > 0, worked, -1).argmax())
    steps = np.flatnonzero((run.task == target).any(axis=1))
    if not len(steps):
        axes.set_axis_off()
        return
    ground(axes, run.terrain, climb_rad)
    for robot in np.flatnonzero((run.task == target).any(axis=0)):
        mine = run.tracks[steps[0] : steps[-1] + 2, robot]
        finder = robot == run.reached_by[target]
        axes.plot(mine[:, 0], mine[:, 1], lw=1.1, color=RED if finder else INDIGO)
        axes.plot(*mine[0, :2], ".", ms=5, color=GREEN)
        axes.annotate(f"R{robot + 1}", (mine[0, 0], mine[0, 1]), fontsize=7, annotation_clip=True)
    axes.plot(*run.targets[target], "*", ms=12, color=ORANGE, mec=INK, mew=0.5)
    x, y = run.targets[target]
    axes.set_xlim(x - _ZOOM_M, x + _ZOOM_M)
    axes.set_ylim(y - _ZOOM_M, y + _ZOOM_M)
    span = f"t = {steps[0] + 1} to {run.reached_at[target]}"
    axes.set_title(f"suballiance of target {target + 1}, {span}", loc="left", color=INK)


def _members(axes: Axes, run: Trace) -> None:
    """Members by target over time: class I dark, class II light."""
    of_target = run.task[..., None] == np.arange(len(run.targets))
    members = of_target.sum(axis=1)
    first = (of_target & (run.first == 1)[..., None]).sum(axis=1)
    found_at = [float(step) if step > 0 else None for step in run.reached_at]
    draw_members(axes, np.arange(1.0, len(members) + 1.0), members, first, found_at)
    axes.set_xlabel("step")
    axes.set_title("members (class I dark), found (star)", loc="left", color=INK)
    plain(axes)
