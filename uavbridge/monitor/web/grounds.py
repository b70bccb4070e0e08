"""Pictures of numbers over the ground for the page: terrain with its shading, named layers."""

from __future__ import annotations

from base64 import b64encode
from math import cos, radians, sin

import numpy as np
import numpy.typing as npt

from planners.terrain import Terrain
from planners.types import F64
from uavbridge.bus.layers import Layer
from uavbridge.clock import to_s
from uavbridge.monitor.web.messages import Ground

MOST_POINTS = 400  # along a side; a finer lattice is thinned
TERRAIN = "terrain"
# The light of maps: from the north-west, half way up.
_LIGHT = np.array(
    [
        -cos(radians(45.0)) * sin(radians(45.0)),
        cos(radians(45.0)) * cos(radians(45.0)),
        sin(radians(45.0)),
    ]
)


def ground_of(terrain: Terrain) -> Ground:
    """Heights, and how bright the sun makes each place."""
    step = -(-max(terrain.heights.shape) // MOST_POINTS)
    heights, side = terrain.heights[::step, ::step], terrain.cell_m * step
    east, north = np.gradient(heights, side)
    normal = np.stack((-east, -north, np.ones_like(heights)), axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    shade = np.clip(normal @ _LIGHT, 0.0, 1.0)
    # A lattice point is the middle of its pixel.
    west, south = terrain.west_m - side / 2, terrain.south_m - side / 2
    return _ground(TERRAIN, 0.0, (west, south, side), heights, shade=_text(shade * 255.0))


def layer_picture(name: str, layer: Layer) -> Ground:
    """A layer as it is now."""
    place = layer.west_m, layer.south_m, layer.cell_m
    return _ground(name, to_s(layer.t_us), place, layer.values)


def _ground(
    name: str, t_s: float, place: tuple[float, float, float], values: F64, shade: str = ""
) -> Ground:
    low, high = float(values.min()), float(values.max())
    scaled = (values - low) * (255.0 / (high - low)) if high > low else np.zeros(values.shape)
    columns, rows = values.shape
    return Ground(name, t_s, (*place, columns, rows), low, high, _text(scaled), shade)


def _text(values: npt.NDArray[np.float64]) -> str:
    """One byte a cell, cell (c, r) at c * rows + r, as base64."""
    return b64encode(np.rint(values).astype(np.uint8).tobytes()).decode()
