"""Which cell draws an agent: Liu's guide cell, F_4 of Eq. (6).

Liu et al. 2022, section 3.1, rule 4: "direction to the nearby grid with the
highest target existing probability", of the eight cells around the agent's own.

Readings taken where the paper is silent: the cell's centre draws (``point``); of
equal probabilities the nearest, then the lowest cell number (``ties``); a guide
cell is kept until it is entered (``keep``); cells found to hold a target draw
nobody any more.

DEVIATION: the paper has no rule for an agent whose eight cells are all searched
while far cells are not: literally it wanders among searched cells. With
``escape_ratio`` above 0, an agent whose best surrounding cell is below that
share of the best cell of its map is drawn by a far cell instead: the nearest of
those that reach the share, leaving out those that a neighbour is nearer to, if
any remain. 0 is the literal rule.

Flat cell numbers are column * rows + row; -1 is no cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.grid import Grid
from planners.types import F64, I64, Bools

_AROUND: I64 = np.array(
    [(c, r) for c in (-1, 0, 1) for r in (-1, 0, 1) if (c, r) != (0, 0)], dtype=np.int64
)


@dataclass(frozen=True, slots=True)
class Guidance:
    """The readings of the rule."""

    threshold: float = 0.95  # cells at or above it are found
    keep: str = "entered"  # "entered", or "best": only while no surrounding cell is better
    escape_ratio: float = 0.5
    ties: str = "nearest"  # of equally likely cells the nearest, or the "lowest" number
    point: str = "centre"  # what draws: the cell's "centre", or its south-western "corner"


def own_cells(grid: Grid, position: F64) -> I64:
    """Cells (..., 2) of points (..., 2), moved into the grid where outside."""
    return np.asarray(np.clip(grid.cell_of(position), 0, np.array(grid.shape) - 1))


def choose(
    belief: F64,
    position: F64,
    guide: I64,
    grid: Grid,
    rule: Guidance,
    others: F64 | None = None,
    present: Bools | None = None,
) -> I64:
    """Flat guide cell (...) of each agent.

    Args:
        belief: (..., columns, rows), broadcast against the agents' leading axes.
        position: (..., 2) m.
        guide: (...) guide cells so far, -1 for none.
        grid: the search area.
        rule: the readings.
        others: (..., k, 2) m, neighbours that an escaping agent yields to.
        present: (..., k) which rows of ``others`` count.
    """
    lead = position.shape[:-1]
    flat = belief.reshape((*belief.shape[:-2], grid.size))
    open_value = np.where(flat < rule.threshold, flat, -1.0)  # found cells draw nobody
    value = np.broadcast_to(open_value, (*lead, grid.size))
    here = own_cells(grid, position)
    best_cell, best = _best_around(value, position, here, grid, rule)
    kept = _kept(value, guide, here, best, grid, rule)
    chosen = np.where(kept, guide, best_cell)
    if rule.escape_ratio > 0.0:
        floor = open_value.max(axis=-1) * rule.escape_ratio
        stuck = ~kept & (best < np.broadcast_to(floor, lead))
        if stuck.any():
            chosen = _escape(chosen, stuck, value, position, here, grid, rule, others, present)
    return np.asarray(chosen)


def offset_to(position: F64, guide: I64, grid: Grid, point: str = "centre") -> F64:
    """Ways (..., 2) m to what draws of the guide cells (...)."""
    cell = np.stack(np.divmod(np.maximum(guide, 0), grid.rows), axis=-1)
    return _points(cell, grid, point) - position


def direction(position: F64, guide: I64, grid: Grid, point: str = "centre") -> F64:
    """Unit vectors (..., 2) to the guide cells (...); zero without one."""
    offset = offset_to(position, guide, grid, point)
    distance = np.hypot(offset[..., 0], offset[..., 1])
    usable = (guide >= 0) & (distance > 0.0)
    unit = offset / np.where(usable, distance, 1.0)[..., None]
    return np.asarray(np.where(usable[..., None], unit, 0.0))


def _points(cells: I64, grid: Grid, point: str) -> F64:
    """Points (..., 2) m that draw, of cells (..., 2)."""
    centre = grid.centre_of(cells)
    return centre if point == "centre" else centre - grid.cell_m / 2.0


def _best_around(
    value: F64, position: F64, here: I64, grid: Grid, rule: Guidance
) -> tuple[I64, F64]:
    """Best of the eight surrounding cells (...), -1 for none, and its probability."""
    cells = here[..., None, :] + _AROUND
    inside = grid.inside(cells)
    number = np.where(inside, cells[..., 0] * grid.rows + cells[..., 1], 0)
    around = np.where(inside, np.take_along_axis(value, number, axis=-1), -1.0)
    best = around.max(axis=-1)
    if rule.ties == "lowest":
        pick = around.argmax(axis=-1)  # the first of equals; cells are in ascending order
    else:
        offset = _points(cells, grid, rule.point) - position[..., None, :]
        distance = np.hypot(offset[..., 0], offset[..., 1])
        pick = np.where(around == best[..., None], distance, np.inf).argmin(axis=-1)
    chosen = np.take_along_axis(number, pick[..., None], axis=-1)[..., 0]
    return np.where(best >= 0.0, chosen, -1), best


def _kept(value: F64, guide: I64, here: I64, best: F64, grid: Grid, rule: Guidance) -> Bools:
    """Which agents stay with the guide cell they have."""
    column, row = np.divmod(np.maximum(guide, 0), grid.rows)
    steps = np.maximum(abs(column - here[..., 0]), abs(row - here[..., 1]))
    mine = np.take_along_axis(value, np.maximum(guide, 0)[..., None], axis=-1)[..., 0]
    kept = (guide >= 0) & (steps > 0) & (mine >= 0.0)
    far = (rule.escape_ratio > 0.0) & (best < rule.escape_ratio * mine)
    kept &= (steps == 1) | far
    if rule.keep == "best":
        kept &= mine >= best
    return np.asarray(kept)


def _escape(
    chosen: I64,
    stuck: Bools,
    value: F64,
    position: F64,
    here: I64,
    grid: Grid,
    rule: Guidance,
    others: F64 | None,
    present: Bools | None,
) -> I64:
    """``chosen`` with a far cell for the agents that are stuck."""
    values, points = value[stuck], position[stuck]
    good = values >= values.max(axis=-1, keepdims=True) * rule.escape_ratio
    own = here[stuck]
    np.put_along_axis(good, (own[:, 0] * grid.rows + own[:, 1])[:, None], False, axis=-1)
    number = np.arange(grid.size)
    centres = grid.centre_of(np.stack(np.divmod(number, grid.rows), axis=-1))
    distance = _distances(points, centres)
    if others is not None and present is not None and others.shape[-2]:
        theirs = np.where(
            present[stuck][..., None], _distances(others[stuck], centres), np.inf
        ).min(axis=-2)
        mine_first = good & (distance <= theirs)
        good = np.where(mine_first.any(axis=-1, keepdims=True), mine_first, good)
    target = np.where(good, distance, np.inf).argmin(axis=-1)
    out = chosen.copy()
    out[stuck] = np.where(good.any(axis=-1), target, chosen[stuck])
    return out


def _distances(points: F64, centres: F64) -> F64:
    """Distances (..., cells) from points (..., 2)."""
    offset = points[..., None, :] - centres
    return np.asarray(np.hypot(offset[..., 0], offset[..., 1]))
