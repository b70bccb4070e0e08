"""The pictures of the Chen experiments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from planners.flocking.starling import goals
from planners.flocking.starling.wing import parts
from planners.paths.dubins import AirplanePath
from planners.paths.rrt import RrtPath
from planners.terrain import Terrain
from uavbridge.experiments.chen import terrains
from uavbridge.experiments.chen.flight import Tracks
from uavbridge.experiments.chen.track import Flown
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


def airplanes(figure: Figure, paths: Sequence[AirplanePath]) -> None:
    """Figs 9, 12, 13: each path in space and from above."""
    figure.set_size_inches(10.0, 6.4)
    for place, path in enumerate(paths):
        points = path.points(1.0)
        space: Any = figure.add_subplot(2, len(paths), place + 1, projection="3d")
        space.plot(points[:, 0], points[:, 1], points[:, 2], color=RED, lw=1.4)
        space.set_title(f"{path.case}: {path.height:g} m up, {path.length:.0f} m", color=INK)
        above = figure.add_subplot(2, len(paths), len(paths) + place + 1)
        above.plot(points[:, 0], points[:, 1], color=RED, lw=1.4)
        above.plot(points[[0, -1], 0], points[[0, -1], 1], "o", ms=4, color=INK)
        above.set_aspect("equal", adjustable="datalim")
        plain(above)


def ways(figure: Figure, found: Sequence[tuple[str, RrtPath | None]]) -> None:
    """Figs 7 and 8: tree, way and smoothed way from above, and the last ones in space."""
    figure.set_size_inches(11.0, 2.1 * len(found))
    for place, (name, path) in enumerate(found):
        above = figure.add_subplot(len(found), 2, 2 * place + 1)
        terrain = terrains.terrain(name)
        ground(above, terrain)
        above.set_title(name, loc="left", color=INK)
        space: Any = figure.add_subplot(len(found), 2, 2 * place + 2, projection="3d")
        _surface(space, terrain)
        if path is None:
            continue
        legs = np.stack((path.nodes[path.parents[1:]], path.nodes[1:]), axis=1)[..., :2]
        above.add_collection(LineCollection(list(legs), colors=FAINT, linewidths=0.4))
        above.plot(path.raw[:, 0], path.raw[:, 1], color=ORANGE, lw=1.0)
        above.plot(path.points[:, 0], path.points[:, 1], color=RED, lw=1.6)
        space.plot(*path.points.T, color=RED, lw=1.6, zorder=5)


def intruders(figure: Figure, flights: Sequence[tuple[Case, Tracks]]) -> None:
    """Tracks from above."""
    figure.set_size_inches(10.0, 0.9 * len(flights))
    for place, (case, tracks) in enumerate(flights):
        axes = figure.add_subplot((len(flights) + 1) // 2, 2, place + 1)
        _tracks(axes, tracks)
        axes.set_aspect("equal")
        axes.set_xlim(0.0, 4500.0)
        axes.set_ylim(-300.0, 800.0)
        axes.set_title(f"{case['intruder']}, {case['n']} aircraft", loc="left", color=INK)
        plain(axes)


def tracks(figure: Figure, runs: Sequence[tuple[Case, Flown]], terrain: Terrain) -> None:
    """Fig. 24: all tracks, and one beside its command; Figs 25, 26: errors over time."""
    figure.set_size_inches(11.0, 2.4 * (len(runs) + 1))
    parts_of_figure: Any = figure.subfigures(2, 1, height_ratios=(len(runs), 1.4))
    top, low = parts_of_figure
    maps = top.subplots(len(runs), 2, squeeze=False)
    panels = low.subplots(1, 3)
    for (case, run), (above, beside) in zip(runs, maps, strict=True):
        ground(above, terrain)
        above.plot(run.position[..., 0], run.position[..., 1], lw=0.7, color=RED, alpha=0.7)
        above.set_title(f"{case['model']}: flown", loc="left", color=INK)
        beside.plot(*run.commanded.position[:, 0, :2].T, lw=1.4, color=FAINT, label="commanded")
        beside.plot(*run.position[:, 0, :2].T, lw=0.8, color=RED, label="flown")
        beside.set_title(f"{case['model']}: one of them", loc="left", color=INK)
        beside.legend(frameon=False, fontsize=7)
        plain(beside)
    for place, (axes, name) in enumerate(zip(panels, ("east", "north", "height"), strict=True)):
        for (case, run), color in zip(runs, (RED, ORANGE), strict=False):
            lines = axes.plot(
                run.commanded.t_s, run.error[..., place], lw=0.6, color=color, alpha=0.6
            )
            lines[0].set_label(str(case["model"]))
        axes.set_title(f"error {name} (m)", loc="left", color=INK)
        axes.set_xlabel("s")
        axes.set_yscale("symlog", linthresh=5.0)
        axes.legend(frameon=False, fontsize=7)
        plain(axes)


def _surface(axes: Any, terrain: Terrain) -> None:
    west, south, _, _ = terrain.bounds
    columns, rows = (np.arange(size)[::4] for size in terrain.heights.shape)
    x, y = west + terrain.cell_m * columns, south + terrain.cell_m * rows
    axes.plot_surface(
        *np.meshgrid(x, y, indexing="ij"), terrain.heights[::4, ::4], cmap="Greys", alpha=0.6
    )
    axes.set_box_aspect((3.0, 1.0, 0.4), zoom=1.8)
    axes.tick_params(labelsize=6)


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
