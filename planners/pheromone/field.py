"""Digital pheromone maps: target, obstacle and path pheromones on a grid.

Shao, Zhao, Li and Zhou 2020, "Target detection for multi-UAVs via digital pheromones and
navigation algorithm in unknown environments", Eqs. (1)-(8). Maps are (..., columns, rows) like
beliefs; leading axes are runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from planners.pheromone.law import FieldLaw, PathLaw, SpreadLaw, Weights
from planners.types import F64, I64, Bools

_FAINT = 1e-30  # less is nothing; numbers near the smallest float are slow


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """The three maps, (..., columns, rows) each."""

    target: F64  # tau
    obstacle: F64  # epsilon
    path: F64  # sigma

    @staticmethod
    def fresh(shape: tuple[int, ...], law: FieldLaw) -> Field:
        """Maps before the first step: no target or obstacle pheromone, path at its greatest."""
        return Field(np.zeros(shape), np.zeros(shape), np.full(shape, law.path.initial))

    def combined(self, weights: Weights) -> F64:
        """The sum by weights (..., columns, rows) of Fig. 7(d): Eq. (9) without costs."""
        return (
            weights.target * self.target
            + weights.obstacle * self.obstacle
            + weights.path * self.path
        )


def step(
    field: Field,
    targets: F64,
    obstacles: F64,
    uavs: I64,
    law: FieldLaw,
    present: Bools | None = None,
) -> Field:
    """The maps one step later, Eqs. (1)-(8).

    Args:
        field: the maps now.
        targets: (..., columns, rows) k_tau d_tau: d_tau where a found target waits for a visit.
        obstacles: (..., columns, rows) k_epsilon d_epsilon: d_epsilon where an obstacle is known.
        uavs: (..., n, 2) cells of the UAVs after their move.
        law: of each pheromone.
        present: (..., n) which of them count; None: all.
    """
    return Field(
        spread(field.target, targets, law.target),
        spread(field.obstacle, obstacles, law.obstacle),
        worn(field.path, uavs, law.path, present),
    )


def spread(field: F64, deposited: F64, law: SpreadLaw) -> F64:
    """Aggregation, diffusion and evaporation, Eqs. (1)-(2) and (3)-(4).

    Each cell gives its share to the neighbours that it has, up to eight: the sum over the map
    after the step is (1 - E) times the sum before it and of the deposits, at every border.

    Args:
        field: (..., columns, rows).
        deposited: the same shape, k d.
        law: of this pheromone.
    """
    held = field + deposited
    if held.max() < _FAINT:
        return np.zeros_like(held)
    share, kept = _shares(field.shape[-2], field.shape[-1], law)
    after = around(held * share)
    held *= kept
    after += held
    return after


def around(values: F64) -> F64:
    """Sums (..., columns, rows) over the up to eight neighbours of each cell, itself left out."""
    sides = np.zeros_like(values)
    sides[..., 1:] += values[..., :-1]
    sides[..., :-1] += values[..., 1:]
    three = sides + values
    sides[..., 1:, :] += three[..., :-1, :]
    sides[..., :-1, :] += three[..., 1:, :]
    return sides


def worn(path: F64, uavs: I64, law: PathLaw, present: Bools | None = None) -> F64:
    """Path pheromone after the UAVs have moved, Eqs. (5)-(8).

    Args:
        path: (..., columns, rows) sigma.
        uavs: (..., n, 2) their cells; effects beyond the map's edges are lost.
        law: of path pheromone.
        present: (..., n) which of them count; None: all.
    """
    columns, rows = path.shape[-2:]
    offsets, losses = _wear(law)
    flat = path.reshape(-1, columns * rows) + law.recovery
    cells = uavs.reshape(len(flat), -1, 1, 2) + offsets
    column, row = cells[..., 0], cells[..., 1]
    valid = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    if present is not None:
        valid &= present.reshape(len(flat), -1, 1)
    place = column * rows + row + (np.arange(len(flat)) * (columns * rows))[:, None, None]
    loss = np.broadcast_to(losses, place.shape)
    np.subtract.at(flat.reshape(-1), place[valid], loss[valid])
    return np.clip(flat, law.least, law.initial, out=flat).reshape(path.shape)


@lru_cache(maxsize=64)
def _shares(columns: int, rows: int, law: SpreadLaw) -> tuple[F64, F64]:
    """What of a cell is in each neighbour after a step, and in itself, (columns, rows)."""
    count = around(np.ones((columns, rows)))
    share = law.diffusion / np.maximum(count, 1.0)
    kept = np.where(count > 0.0, 1.0 - law.diffusion, 1.0)  # a map of one cell gives to nobody
    return share * (1.0 - law.evaporation), kept * (1.0 - law.evaporation)


@lru_cache(maxsize=64)
def _wear(law: PathLaw) -> tuple[I64, F64]:
    """Offsets (k, 2) of the cells within D_0, and what each loses (k,), Eq. (7)."""
    offsets = disc(law.reach)
    distance = np.hypot(offsets[:, 0], offsets[:, 1])
    apart = np.maximum(distance, 1.0)
    ratio = law.attenuation / apart if law.wear == "printed" else apart / law.attenuation
    beside = np.exp(-0.5 * ratio**2) / (2.0 * np.sqrt(2.0 * np.pi))
    return offsets, np.where(distance == 0.0, 0.9, beside) * law.initial


@lru_cache(maxsize=64)
def disc(radius: float) -> I64:
    """Offsets (k, 2) of all cells whose centres are within a radius (cells), the own included."""
    most = int(np.floor(radius))
    side = np.arange(-most, most + 1)
    grid = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.asarray(grid[np.hypot(grid[:, 0], grid[:, 1]) <= radius], dtype=np.int64)
