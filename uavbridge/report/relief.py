"""Terrain and suballiances as pictures, for reports and experiments."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource

from planners.terrain import Terrain
from planners.types import F64, I64

_INDIGO, _INK, _FAINT, _STAR = "#332288", "#24303c", "#8b97a3", "#ffd23f"


def draw_ground(axes: Axes, terrain: Terrain, climb_rad: float) -> None:
    """Shaded heights and contours; in red the cells with slopes above ``climb_rad``."""
    west, south, east, north = terrain.bounds
    extent = (west, east, south, north)
    light = LightSource(azdeg=315, altdeg=45)
    shade = light.hillshade(terrain.heights.T[::-1], dx=terrain.cell_m, dy=terrain.cell_m)
    axes.imshow(shade[::-1], origin="lower", extent=extent, cmap="gray", alpha=0.35, zorder=0)
    if np.ptp(terrain.heights) > 0.0:
        axes.contour(
            terrain.heights.T, levels=10, origin="lower", extent=extent, colors=_FAINT,
            linewidths=0.4, zorder=1,
        )  # fmt: skip
    steep = np.where(terrain.cell_slopes() > climb_rad + 1e-9, 1.0, np.nan)
    if np.isfinite(steep).any():
        axes.imshow(
            steep.T, origin="lower", extent=extent, cmap="Reds", vmin=0.0, vmax=1.3, alpha=0.55,
            zorder=1,
        )  # fmt: skip


def draw_members(
    axes: Axes, at: F64, members: I64, first: I64, found_at: Sequence[float | None]
) -> None:
    """Members of each target's suballiance over time, class I dark, and when it was found.

    Args:
        axes: to draw on.
        at: (k,) steps or seconds.
        members: (k, T) how many.
        first: (k, T) how many of them of class I.
        found_at: (T,) in the units of ``at``.
    """
    for target, when in enumerate(found_at):
        for counts, colour in ((members, _FAINT), (first, _INDIGO)):
            level = target + 1 + 0.13 * counts[:, target]
            axes.fill_between(at, target + 1, level, step="mid", color=colour, lw=0)
        if when is not None:
            axes.plot(when, target + 1, "*", ms=9, color=_STAR, mec=_INK, mew=0.6)
    axes.set_yticks(range(1, len(found_at) + 1))
    axes.set_ylim(0.5, len(found_at) + 1.2)
    axes.set_ylabel("target")
