"""Flights of fixed-wing aircraft as pictures: tracks in space, and how they moved over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from planners.terrain import Terrain
from planners.types import F64

_INK, _FAINT = "#24303c", "#8b97a3"
_LINES = ("#332288", "#117733", "#882255", "#44aa99", "#aa4499", "#2a6fb0", "#999933", "#cc6677")
_MOST_POINTS = 90  # of the ground, along either side
_TALL = 0.35  # of the height axis, beside the longer horizontal one


def tracks_figure(tracks: Mapping[int, F64], terrain: Terrain | None) -> Figure:
    """Tracks (k, 3) in space, over the terrain; heights are drawn larger."""
    figure = Figure(figsize=(7.4, 4.4), layout="constrained")
    axes: Any = figure.add_subplot(projection="3d", computed_zorder=False)
    if terrain is not None:
        west, south, _, _ = terrain.bounds
        step = max(1, max(terrain.heights.shape) // _MOST_POINTS)
        columns, rows = (np.arange(size)[::step] for size in terrain.heights.shape)
        x, y = west + terrain.cell_m * columns, south + terrain.cell_m * rows
        heights = terrain.heights[::step, ::step]
        axes.plot_surface(
            *np.meshgrid(x, y, indexing="ij"), heights, cmap="Greys", alpha=0.55, zorder=1
        )
    for place, (_, track) in enumerate(sorted(tracks.items())):
        points = track[np.isfinite(track).all(axis=1)]
        axes.plot(*points.T, color=_LINES[place % len(_LINES)], lw=0.8, zorder=2)
    low, high = (np.array(axes.get_w_lims()).reshape(3, 2)[:, side] for side in (0, 1))
    size = high - low
    wide = max(size[0], size[1])
    axes.set_box_aspect((size[0] / wide, size[1] / wide, _TALL), zoom=1.15)
    axes.set(xlabel="east (m)", ylabel="north (m)", zlabel="up (m)")
    axes.tick_params(labelsize=7, colors=_INK)
    axes.view_init(elev=32.0, azim=-75.0)
    return figure


def motion_figure(tracks: Mapping[int, F64], period_s: float = 1.0) -> Figure:
    """Yaw, pitch and speed of tracks (k, 3) with a place each ``period_s``."""
    figure = Figure(figsize=(7.4, 5.2), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    for place, (_, track) in enumerate(sorted(tracks.items())):
        points = track[np.isfinite(track).all(axis=1)]
        if len(points) < 3:
            continue
        velocity = np.gradient(points, period_s, axis=0)
        level = np.hypot(velocity[:, 0], velocity[:, 1])
        time = np.arange(len(points)) * period_s
        yaw = np.unwrap(np.arctan2(velocity[:, 1], velocity[:, 0]))
        lines = (yaw, np.arctan2(velocity[:, 2], level), np.hypot(level, velocity[:, 2]))
        for axes, line in zip(panels, lines, strict=True):
            axes.plot(time, line, color=_LINES[place % len(_LINES)], lw=0.8)
    for axes, name in zip(panels, ("yaw (rad)", "pitch (rad)", "speed (m/s)"), strict=True):
        _plain(axes, name)
    panels[-1].set_xlabel("time (s)", color=_INK)
    return figure


def _plain(axes: Axes, name: str) -> None:
    axes.set_ylabel(name, color=_INK)
    axes.grid(color="#d5dce3", lw=0.5)
    axes.tick_params(labelsize=8, colors=_INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(_FAINT)
