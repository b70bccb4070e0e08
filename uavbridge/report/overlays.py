"""Layers of numbers over the ground, and no-fly columns, as pictures of the report."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from planners.types import F64
from uavbridge.bus.layers import Layer
from uavbridge.clock import to_s

INK = "#24303c"
_ACROSS = 2  # panels


def layers_figure(layers: Mapping[str, Layer], columns: F64) -> Figure:
    """A panel a layer, as it was last; north up, axes in metres from home."""
    up = math.ceil(len(layers) / _ACROSS)
    figure = Figure(figsize=(7.6, 3.4 * up), layout="constrained")
    panels = figure.subplots(up, _ACROSS, squeeze=False).flat
    for axes, (name, layer) in zip(panels, layers.items(), strict=False):
        wide, high = np.array(layer.values.shape) * layer.cell_m
        bounds = layer.west_m, layer.west_m + wide, layer.south_m, layer.south_m + high
        image = axes.imshow(layer.values.T, origin="lower", extent=bounds, cmap="viridis")
        bar = figure.colorbar(image, ax=axes, shrink=0.8)
        bar.outline.set_visible(False)
        draw_columns(axes, columns)
        axes.set_title(f"{name}, {to_s(layer.t_us):.0f} s", loc="left", color=INK, size=9.5)
        axes.tick_params(labelsize=8, colors=INK)
    for axes in list(panels)[len(layers) :]:
        axes.set_visible(False)
    return figure


def draw_columns(axes: Axes, columns: F64) -> None:
    """No-fly columns (k, 3): x, y, radius in m."""
    for x, y, radius in columns.tolist():
        axes.add_patch(
            Circle((x, y), radius, fc="none", ec="#c8402f", hatch="xxx", lw=0.9, zorder=2)
        )
