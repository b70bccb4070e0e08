"""Exhaustive search by fixed routes, to compare: one sweeper or several, lanes of any width.

Routes are laid before anything is known; where an obstacle bars one, the sweeper takes the
shortest way round it. A sweeper that is through flies its route back, and so on.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from planners.pheromone.field import disc
from planners.pheromone.sectors import STEPS, inside
from planners.types import F64, I64, Bools
from uavbridge.experiments.shao.ground import Ground


def lanes(width: int, spacing: int) -> I64:
    """Columns (k,) of the lanes over a strip, every cell at most half a spacing from one."""
    count = -(-width // spacing)
    return np.asarray(((np.arange(count) + 0.5) * width / count).astype(np.int64))


def planned(size: int, sweepers: int, spacing: int) -> list[I64]:
    """Each sweeper's route (k, 2) of cells over its own strip, obstacles not minded."""
    edges = np.linspace(0, size, sweepers + 1).astype(np.int64)
    routes = []
    for west, east in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        cells: list[tuple[int, int]] = []
        for number, lane in enumerate(lanes(max(east - west, 1), spacing).tolist()):
            column = min(west + lane, size - 1)
            rows = range(size) if number % 2 == 0 else range(size - 1, -1, -1)
            if cells:
                across = range(cells[-1][0] + 1, column)
                cells += [(between, cells[-1][1]) for between in across]
            cells += [(column, row) for row in rows]
        routes.append(np.array(cells))
    return routes


def flown(route: I64, obstacles: Bools, steps: int) -> I64:
    """Cells (steps + 1, 2) of one sweeper, one step a cell."""
    free = [tuple(cell) for cell in route.tolist() if not obstacles[tuple(cell)]]
    track = free[:1]
    onwards = free
    while len(track) <= steps and len(free) > 1:
        for cell in onwards:
            if cell != track[-1]:
                track += way_round(track[-1], cell, obstacles)
            if len(track) > steps:
                break
        onwards = onwards[::-1]
    track += track[-1:] * (steps + 1 - len(track))
    return np.array(track[: steps + 1])


def way_round(
    start: tuple[int, ...], goal: tuple[int, ...], obstacles: Bools
) -> list[tuple[int, ...]]:
    """Cells of a shortest way from ``start``, left out, to ``goal``; none: stays."""
    before: dict[tuple[int, ...], tuple[int, ...]] = {start: start}
    ahead = deque([start])
    while ahead and goal not in before:
        here = ahead.popleft()
        for column, row in STEPS.tolist():
            there = here[0] + column, here[1] + row
            on_map = 0 <= there[0] < obstacles.shape[0] and 0 <= there[1] < obstacles.shape[1]
            if on_map and there not in before and not obstacles[there]:
                before[there] = here
                ahead.append(there)
    if goal not in before:
        return []
    way = [goal]
    while before[way[-1]] != start:
        way.append(before[way[-1]])
    return way[::-1]


def tracks(ground: Ground, sweepers: int, spacing: int, steps: int) -> I64:
    """Cells (runs, steps + 1, sweepers, 2)."""
    routes = planned(ground.obstacles.shape[1], sweepers, spacing)
    return np.stack(
        [
            np.stack([flown(route, obstacles, steps) for route in routes], axis=1)
            for obstacles in ground.obstacles
        ]
    )


def coverage(
    ground: Ground, track: I64, sensor: float, at: tuple[int, ...], alive: Bools | None = None
) -> F64:
    """Share (runs, len(at)) of all cells that the sweepers have seen at steps ``at``.

    Args:
        ground: lattices.
        track: (runs, steps + 1, sweepers, 2).
        sensor: radius, cells.
        at: steps, ascending.
        alive: (runs, steps + 1, sweepers); None: all the time.
    """
    first = first_seen(ground, track, sensor, alive)
    first = np.where(ground.obstacles, np.inf, first)
    return np.stack([(first <= step).mean(axis=(1, 2)) for step in at], axis=1)


def first_seen(ground: Ground, track: I64, sensor: float, alive: Bools | None = None) -> F64:
    """Step (runs, columns, rows) at which a cell was first in range; infinity: never."""
    first = np.full(ground.obstacles.shape, np.inf)
    for run, (places, seen) in enumerate(zip(track, first, strict=True)):
        around = places[:, :, None] + disc(sensor)
        valid = inside(around, ground.obstacles.shape[1:])
        if alive is not None:
            valid &= alive[run, :, :, None]
        step = np.broadcast_to(np.arange(len(places))[:, None, None], valid.shape)
        column, row = around[valid].T
        np.minimum.at(seen, (column, row), step[valid].astype(np.float64))
    return first


def in_range(track: I64, targets: I64, sensor: float, alive: Bools | None = None) -> Bools:
    """Which targets (steps + 1, T) of one run are in some sweeper's range.

    Args:
        track: (steps + 1, sweepers, 2).
        targets: (T, 2).
        sensor: radius, cells.
        alive: (steps + 1, sweepers); None: all the time.
    """
    apart = track[:, :, None] - targets
    near = np.hypot(apart[..., 0], apart[..., 1]) <= sensor
    if alive is not None:
        near &= alive[..., None]
    return np.asarray(near.any(axis=1))


def visits(near: Bools, period: int) -> tuple[I64, list[int], int]:
    """When targets are first in range, and how long a due one waits for the next time.

    Args:
        near: (steps + 1, T) as of ``in_range``.
        period: T; a target is due so many steps after its last visit.

    Returns:
        Steps (T,), -1: never; all responses; how many targets wait at the end.
    """
    found = np.where(near.any(axis=0), near.argmax(axis=0), -1)
    responses: list[int] = []
    waiting = 0
    for target in np.flatnonzero(found >= 0):
        seen = np.flatnonzero(near[:, target])
        due = int(found[target]) + period
        while due < len(near):
            place = int(np.searchsorted(seen, due))
            if place == len(seen):
                waiting += 1
                break
            responses.append(int(seen[place]) - due)
            due = int(seen[place]) + period
    return found, responses, waiting
