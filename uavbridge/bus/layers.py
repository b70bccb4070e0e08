"""Layers of numbers over the ground, for people: pheromones, risk, whatever a planner keeps.

Same header and same manners as ``uavbridge.bus.messages``. Described in
docs/reference/wire_format.md.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from struct import Struct

import numpy as np

from planners.types import F64
from uavbridge.bus.wire import (
    MAGIC,
    POSITION_LIMIT_M,
    VERSION,
    Kind,
    MalformedError,
    accepted,
    check_head,
    check_length,
    check_time,
)

CELL_COUNT_LIMIT = 1 << 20
_LAYER = Struct("<2sBBqII3d")


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """One layer at one moment.

    Attributes:
        t_us: when.
        west_m: western edge, ENU m.
        south_m: southern edge, ENU m.
        cell_m: side of a cell.
        values: (columns, rows), any finite numbers; float32 on the wire.
    """

    t_us: int
    west_m: float
    south_m: float
    cell_m: float
    values: F64


def encode_layer(layer: Layer) -> bytes:
    """The bytes of a layer. Raises ValueError when its values are not (columns, rows)."""
    if layer.values.ndim != 2:
        raise ValueError(f"layer: values {layer.values.shape} are not (columns, rows)")
    columns, rows = layer.values.shape
    place = layer.west_m, layer.south_m, layer.cell_m
    head = _LAYER.pack(MAGIC, VERSION, Kind.LAYER, layer.t_us, columns, rows, *place)
    return head + layer.values.astype("<f4").tobytes()


def decode_layer(data: bytes, rejects: Counter[str] | None = None) -> Layer | None:
    """The layer in ``data``; None, and its reason counted, when malformed."""
    return accepted(_layer, data, rejects)


def _layer(data: bytes) -> Layer:
    check_head(data, _LAYER.size, (Kind.LAYER,))
    _, _, _, t_us, columns, rows, west_m, south_m, cell_m = _LAYER.unpack_from(data)
    count = columns * rows
    if not 0 < count <= CELL_COUNT_LIMIT:
        raise MalformedError("size")
    check_length(data, _LAYER.size + 4 * count)
    check_time(t_us)
    if not (abs(west_m) <= POSITION_LIMIT_M and abs(south_m) <= POSITION_LIMIT_M):
        raise MalformedError("position")
    values = np.frombuffer(data, "<f4", count, _LAYER.size)
    if not (0 < cell_m <= POSITION_LIMIT_M and np.isfinite(values).all()):
        raise MalformedError("value")
    return Layer(t_us, west_m, south_m, cell_m, values.astype(np.float64).reshape(columns, rows))
