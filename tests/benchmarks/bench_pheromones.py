"""Cost of a step of the pheromone maps: python tests/benchmarks/bench_pheromones.py.

Beside it the same aggregation and diffusion by eight shifted additions, and by SciPy's
``ndimage.convolve`` where it is installed: the two usual ways.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable

import numpy as np

from planners.pheromone import Field, FieldLaw, spread, step, worn
from planners.pheromone.sectors import STEPS
from planners.types import F64

SIZES = (50, 100, 200, 400)
NAMES = ("spread", "shifted", "scipy", "worn", "step", "x8")
UAVS = 16
LAW = FieldLaw()
REPEATS = 30


def fastest(run: Callable[..., object], *given: object) -> float:
    """CPU milliseconds of the fastest of some calls."""
    took = []
    for _ in range(REPEATS):
        begin = time.process_time()
        run(*given)
        took.append(time.process_time() - begin)
    return min(took) * 1e3


def shifted(field: F64, sources: F64) -> F64:
    """Eqs. (1)-(2) as they are printed: each neighbour's share, one neighbour after the other."""
    law, held = LAW.target, field + sources
    count, given = np.zeros_like(held), np.zeros_like(held)
    wide = np.pad(np.ones_like(held), 1)
    for column, row in STEPS.tolist():
        count += wide[1 + column : wide.shape[0] - 1 + column, 1 + row : wide.shape[1] - 1 + row]
    wide = np.pad(held * law.diffusion / count, 1)
    for column, row in STEPS.tolist():
        given += wide[1 + column : wide.shape[0] - 1 + column, 1 + row : wide.shape[1] - 1 + row]
    return np.asarray((1.0 - law.evaporation) * ((1.0 - law.diffusion) * held + given))


def convolved(field: F64, sources: F64) -> F64:
    """The same by SciPy."""
    ndimage = importlib.import_module("scipy.ndimage")
    law, held = LAW.target, field + sources
    around = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], np.float64)
    count = ndimage.convolve(np.ones_like(held), around, mode="constant")
    given = ndimage.convolve(held * law.diffusion / count, around, mode="constant")
    return np.asarray((1.0 - law.evaporation) * ((1.0 - law.diffusion) * held + given))


def main() -> None:
    """Print a table."""
    draw = np.random.default_rng(1)
    print("CPU ms; spread: one map; step: all three, with 16 UAVs; x8: eight runs in one call")
    print("    cells " + " ".join(f"{name:>8}" for name in NAMES))
    for size in SIZES:
        many = Field(*(draw.random((8, size, size)) for _ in range(3)))
        one = Field(many.target[0], many.obstacle[0], many.path[0])
        sources = (draw.random((8, size, size)) < 0.01) * 1.0
        uavs, first = draw.integers(0, size, (8, UAVS, 2)), sources[0]
        expected = spread(one.target, first, LAW.target)
        np.testing.assert_allclose(shifted(one.target, first), expected)
        try:
            np.testing.assert_allclose(convolved(one.target, first), expected)
            scipy = fastest(convolved, one.target, first)
        except ImportError:
            scipy = float("nan")
        row = (
            fastest(spread, one.target, first, LAW.target),
            fastest(shifted, one.target, first),
            scipy,
            fastest(worn, one.path, uavs[0], LAW.path),
            fastest(step, one, first, first, uavs[0], LAW),
            fastest(step, many, sources, sources, uavs, LAW),
        )
        print(f"{size:>4}x{size:<4} " + " ".join(f"{value:8.3f}" for value in row))


if __name__ == "__main__":
    main()
