"""How a leader follows the field to the target region: Shao 2020, Algorithm 2, Eqs. (12)-(16).

Kernels over leading axes (...): none for one leader, or runs. Positions are in cells, a cell's
centre at its number, and need not be on the lattice.

| symbol | name |
| --- | --- |
| q_i^L, q_j | ``position``, cells around it |
| s_d | ``sector_vectors`` of the weighted sum of the three fields |
| rho | ``length`` |

DEVIATION: with s^t = max_d |s_d| a vector is set equal to a number; the sector of the greatest
|s_d| counts. A sector whose step would end in an obstacle or off the map is passed over: nothing
printed keeps the leader out of either.

DEVIATION: with Table 1's evaporation the field falls by a factor of 5.6 a cell, so that over 100
cells only its logarithm can be followed: ``sensed``. The field itself is a reading too.
"""

from __future__ import annotations

import numpy as np

from planners.pheromone.field import Field, disc
from planners.pheromone.law import Weights
from planners.pheromone.sectors import HEADINGS, STEPS, inside, places, taken
from planners.types import F64, I64, Bools

_LEAST = 1e-300
_NEAR = 1e-9
_UNIT = STEPS / np.hypot(STEPS[:, 0], STEPS[:, 1])[:, None]


def sensed(field: Field, weights: Weights, scale: float, log: bool) -> F64:
    """The weighted sum (..., columns, rows) that a leader senses, Eq. (14).

    Args:
        field: the three maps.
        weights: of Eq. (14).
        scale: of target pheromone, or of its logarithm.
        log: follow the logarithm of target pheromone.
    """
    target = np.log(np.maximum(field.target, _LEAST)) if log else field.target
    return Field(target * scale, field.obstacle, field.path).combined(weights)


def cell_of(position: F64) -> I64:
    """Cells (..., 2) that hold positions (..., 2)."""
    return np.floor(position + 0.5).astype(np.int64)


def vector_step(
    position: F64, heading: F64, total: F64, closed: Bools, radius: float, length: float
) -> F64:
    """Velocities (..., 2), cells a step, of leaders that sense vector pheromones.

    Args:
        position: (..., 2).
        heading: (..., 2) last velocity, kept where the field says nothing.
        total: (..., columns, rows) as of ``sensed``.
        closed: (..., columns, rows) known obstacles.
        radius: sensorLD, cells.
        length: rho, cells.
    """
    vectors = sector_vectors(position, total, radius)
    norms = np.hypot(vectors[..., 0], vectors[..., 1])
    silent = norms <= 0.0
    ways = np.where(silent[..., None], _directed(heading)[..., None, :], vectors)
    ways = ways / np.maximum(np.hypot(ways[..., 0], ways[..., 1]), _LEAST)[..., None]
    return _best(position, ways, np.where(silent, 0.0, norms), closed, length)


def sector_vectors(position: F64, total: F64, radius: float) -> F64:
    """Sums s_d (..., 8, 2) of the vector pheromones in each sector, Eqs. (12)-(14).

    Args:
        position: (..., 2).
        total: (..., columns, rows) weighted sum of the fields; Eq. (12) is linear in them.
        radius: sensorLD, cells.
    """
    cell = cell_of(position)[..., None, :]
    offsets = disc(radius + 1.0)
    place, on_map = places(cell, offsets, total.shape[-2:])
    here = taken(total, _own(cell, total.shape))
    apart = position[..., None, None, :] - (cell[..., None, :] + offsets)  # q_i - q_j
    distance = np.hypot(apart[..., 0], apart[..., 1])
    counts = on_map & (distance <= radius) & (offsets != 0).any(axis=-1)
    drop = (here[..., None] - taken(total, place)) / np.maximum(distance, _NEAR) ** 2  # Eq. (12)
    vectors = np.where(counts, drop, 0.0)[..., None] * apart
    towards = np.arctan2(-apart[..., 1], -apart[..., 0])
    sector = np.round(towards / (np.pi / 4.0)).astype(np.int64) % HEADINGS
    members = sector[..., None, :] == np.arange(HEADINGS)[:, None]
    return np.asarray((members[..., None] * vectors[..., None, :, :]).sum(axis=-2)[..., 0, :, :])


def scalar_step(
    position: F64, total: F64, closed: Bools, radius: float, length: float, lattice: bool
) -> F64:
    """Velocities (..., 2) of leaders that sense scalar pheromones: to the sector of greatest mean.

    The paper gives no rule for its rival; this is the vector leader without vectors.

    Args:
        position: (..., 2).
        total: (..., columns, rows) as of ``sensed``.
        closed: (..., columns, rows) known obstacles.
        radius: sensorLD, cells.
        length: cells a step.
        lattice: steps go from cell to cell, a diagonal one is longer by sqrt 2.
    """
    cell = cell_of(position)[..., None, :]
    offsets = disc(radius)
    offsets = offsets[(offsets != 0).any(axis=1)]
    place, on_map = places(cell, offsets, total.shape[-2:])
    members = (offsets @ _UNIT.T).argmax(axis=1)[:, None] == np.arange(HEADINGS)
    sums = np.where(on_map, taken(total, place), 0.0) @ (members * 1.0)
    count = on_map @ (members * 1.0)
    means = np.where(count > 0.0, sums / np.maximum(count, 1.0), -np.inf)[..., 0, :]
    ways = STEPS.astype(np.float64) if lattice else _UNIT
    ways = np.broadcast_to(ways, (*means.shape, 2))
    return _best(position, ways, means, closed, length)


def _best(position: F64, ways: F64, worth: F64, closed: Bools, length: float) -> F64:
    """The way (..., 2) of greatest worth that is open, times ``length``; zero: none is.

    Where no sector's way is open, the nearest of the eight headings to the best one that is.
    """
    best = np.take_along_axis(ways, worth.argmax(axis=-1)[..., None, None], axis=-2)
    other = np.broadcast_to(_UNIT, ways.shape)
    near = (other * best).sum(axis=-1) - 10.0
    low = np.min(np.where(np.isfinite(worth), worth, np.inf), axis=-1, keepdims=True)
    low = np.where(np.isfinite(low), low, 0.0)
    all_ways = np.concatenate((ways, other), axis=-2)
    all_worth = np.concatenate((worth, low + near), axis=-1)
    all_worth = np.where(_open(position, all_ways * length, closed), all_worth, -np.inf)
    chosen = all_worth.argmax(axis=-1)[..., None]
    some = np.isfinite(np.take_along_axis(all_worth, chosen, axis=-1))
    way = np.take_along_axis(all_ways, chosen[..., None], axis=-2)[..., 0, :]
    return np.asarray(np.where(some, way * length, 0.0))


def _open(position: F64, steps: F64, closed: Bools) -> Bools:
    """Which steps (..., k, 2) keep to free cells, half-way and at their end."""
    free = np.ones(steps.shape[:-1], np.bool_)
    shape = closed.shape[-2:]
    for part in (0.5, 1.0):
        cell = cell_of(position[..., None, :] + steps * part)
        on_map = inside(cell, shape)
        place = np.where(on_map, cell[..., 0] * shape[1] + cell[..., 1], 0)
        free &= on_map & ~_taken_bools(closed, place)
    return free


def _taken_bools(closed: Bools, place: I64) -> Bools:
    return taken(closed.astype(np.float64), place) > 0.0


def _own(cell: I64, shape: tuple[int, ...]) -> I64:
    column = np.clip(cell[..., 0], 0, shape[-2] - 1)
    row = np.clip(cell[..., 1], 0, shape[-1] - 1)
    return np.asarray(column * shape[-1] + row)


def _directed(heading: F64) -> F64:
    """The heading, or east where there is none."""
    still = (heading == 0.0).all(axis=-1, keepdims=True)
    return np.where(still, np.array((1.0, 0.0)), heading)
