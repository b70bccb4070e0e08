"""Terrains for the flock: the paper shows three and a narrow one, and prints none.

All are 8.6 km by 2.8 km, the flock starts at the western end and flies east. Hills are higher than
the ceiling, so that they must be passed by.

| name | what |
| --- | --- |
| one | three large hills on alternate sides of the way, low hills between |
| two | a small hill more, on the way behind the last |
| three | the same hill, larger |
| narrow | two ridges across the way with a gap between |
| flat | level ground |
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from planners.terrain import Terrain
from planners.types import F64

NAMES = ("one", "two", "three", "narrow")
START_BOX = ((0.0, 0.0, 50.0), (100.0, 100.0, 150.0))  # the paper's
AIM = (8000.0, 400.0, 150.0)

_WEST, _SOUTH, _CELL = -300.0, -1350.0, 20.0
_SHAPE = (431, 141)

# x, y, height, width east, width north (standard deviations), m
_LARGE = (
    (1500.0, 150.0, 480.0, 190.0, 260.0),
    (2500.0, -650.0, 420.0, 260.0, 300.0),
    (2600.0, 900.0, 450.0, 240.0, 280.0),
    (3600.0, 350.0, 460.0, 180.0, 240.0),
)
_LOW = (
    (700.0, -500.0, 90.0, 220.0, 200.0),
    (900.0, 700.0, 110.0, 250.0, 220.0),
    (3100.0, -100.0, 60.0, 200.0, 200.0),
    (4500.0, -700.0, 120.0, 300.0, 250.0),
    (5600.0, 800.0, 140.0, 300.0, 260.0),
)
_SMALL = ((4600.0, 220.0, 420.0, 70.0, 80.0),)
_BIG = ((4600.0, 300.0, 460.0, 170.0, 220.0),)


@cache
def terrain(name: str) -> Terrain:
    """A terrain by its name. Raises ValueError when there is none of that name."""
    hills = {
        "one": _LARGE + _LOW,
        "two": _LARGE + _LOW + _SMALL,
        "three": _LARGE + _LOW + _BIG,
        "narrow": _LOW,
        "flat": (),
    }
    if name not in hills:
        raise ValueError(f"no terrain {name!r} (known: {', '.join(hills)})")
    x, y = _axes()
    heights = _hills(hills[name])
    if name == "narrow":
        for east, gap in ((1900.0, 250.0), (3600.0, -150.0)):
            ridge = 450.0 * np.exp(-0.5 * ((x - east) / 130.0) ** 2)[:, None]
            opening = 1.0 / (1.0 + np.exp((np.abs(y - gap) - 190.0) / 25.0))
            heights = np.maximum(heights, ridge * (1.0 - opening))
    return Terrain(_WEST, _SOUTH, _CELL, heights)


def _axes() -> tuple[F64, F64]:
    columns, rows = (np.arange(float(size)) for size in _SHAPE)
    return _WEST + _CELL * columns, _SOUTH + _CELL * rows


def _hills(hills: Sequence[tuple[float, ...]]) -> F64:
    x, y = _axes()
    out = np.zeros(_SHAPE)
    for east, north, height, wide, long in hills:
        across = np.exp(-0.5 * ((x - east) / wide) ** 2)
        along = np.exp(-0.5 * ((y - north) / long) ** 2)
        out += height * across[:, None] * along
    return out
