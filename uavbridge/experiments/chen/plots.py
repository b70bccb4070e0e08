"""The pictures of the Chen experiments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from planners.flocking.starling import goals
from planners.flocking.starling.wing import parts
from planners.terrain import Terrain
from uavbridge.experiments.chen import terrains
from uavbridge.experiments.chen.flight import Tracks
from uavbridge.experiments.experiment import Case
from uavbridge.experiments.style import FAINT, INK, ORANGE, RED, plain

_MOMENTS_S = (5.0, 10.0, 50.0, 80.0)  # Fig. 23


def flocks(figure: Figure, flights: Sequence[tuple[Case, Tracks]]) -> None:
    """Figs 15-20 from above, then Figs 21-23 of the first flight."""
    figure.set_size_inches(11.0, 1.7 * ((len(flights) + 1) // 2) + 5.2)
    parts_of_figure: Any = figure.subfigures(
        2, 1, height_ratios=(1.7 * ((len(flights) + 1) // 2), 5.2)
    )
    top, low = parts_of_figure
    maps = np.ravel(top.subplots((len(flights) + 1) // 2, 2, squeeze=False))
    for axes, (case, tracks) in zip(maps, flights, strict=False):
        ground(axes, terrains.terrain(str(case["terrain"])))
        _tracks(axes, tracks)
        axes.set_title(", ".join(str(value) for value in case.values()), loc="left", color=INK)
    for axes in maps[len(flights) :]:
        axes.set_visible(False)
    _over_time(low, flights[0][1])


def ground(axes: Axes, terrain: Terrain) -> None:
    """Heights as shades, seen from above."""
    west, south, east, north = terrain.bounds
    axes.imshow(
        terrain.heights.T,
        origin="lower",
        extent=(west, east, south, north),
        cmap="Greys",
        vmin=0.0,
        vmax=700.0,
    )
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7)


def _tracks(axes: Axes, tracks: Tracks) -> None:
    x, y = tracks.position[..., 0], tracks.position[..., 1]
    axes.plot(x, y, lw=0.7, color=RED, alpha=0.7)
    for moment in _MOMENTS_S:
        step = int(np.searchsorted(tracks.t_s, moment))
        if step < len(x):
            axes.plot(x[step], y[step], ".", ms=2.0, color=INK)
    if tracks.intruders.shape[1]:
        axes.plot(tracks.intruders[..., 0], tracks.intruders[..., 1], lw=1.0, color=ORANGE)


def _over_time(figure: Any, tracks: Tracks) -> None:
    """Yaw, pitch, speed and separation, and the places at four moments."""
    speed, course, climb = parts(tracks.velocity)
    panels = figure.subplots(2, 4)
    series = (
        ("yaw (rad)", course),
        ("pitch (rad, positive down)", -climb),
        ("speed (m/s)", speed),
        ("least separation (m)", goals.separation(tracks.position)),
    )
    for axes, (title, values) in zip(panels[0], series, strict=True):
        axes.plot(tracks.t_s, values, lw=0.8)
        axes.set_title(title, loc="left", color=INK)
        axes.set_xlabel("s")
        plain(axes)
    for axes, moment in zip(panels[1], _MOMENTS_S, strict=True):
        step = min(int(np.searchsorted(tracks.t_s, moment)), len(tracks.t_s) - 1)
        place = tracks.position[step]
        axes.plot(place[:, 0], place[:, 1], "o", ms=3.5, color=RED)
        axes.set_title(f"at {moment:g} s, from above", loc="left", color=INK)
        axes.set_aspect("equal", adjustable="datalim")
        axes.tick_params(colors=FAINT)
        plain(axes)
