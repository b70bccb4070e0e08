"""Ways over terrain for vehicles that climb only so steep: all ways to one place.

Dijkstra's shortest paths on a lattice whose edges are those that can be driven. Climbs
cost more: a vehicle's speed falls to nothing at the steepest slope that it climbs.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from math import hypot, inf

import numpy as np

from planners.terrain import Terrain
from planners.types import F64, I64

LATTICE_M = 20.0
MOST = 120  # lattice points a side, beyond which they lie farther apart
_NEIGHBOURS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
_SLOWEST = 0.1  # share of the speed that is left at the steepest climb
_AHEAD = 2  # lattice points that are cut where the ground allows


@dataclass(frozen=True, slots=True, eq=False)
class Routes:
    """Ways to a goal from everywhere.

    Attributes:
        goal: (x, y) m.
        west_m: x of lattice column 0.
        south_m: y of lattice row 0.
        cell_m: spacing.
        left_m: (columns, rows) length of the way from a lattice point, slow climbs counted
            longer; inf: there is none.
        onward: (columns, rows) flat index of the next point, the goal's own at the goal.
        terrain: the ground.
        climb: steepest rise, m per m.
    """

    goal: tuple[float, float]
    west_m: float
    south_m: float
    cell_m: float
    left_m: F64
    onward: I64
    terrain: Terrain
    climb: float

    def onwards(self, x: float, y: float) -> tuple[tuple[float, float], float]:
        """The point to drive to from (x, y), and how far the goal is along the way.

        Without a way the goal itself, at its distance.
        """
        straight = hypot(self.goal[0] - x, self.goal[1] - y)
        if straight < 1.5 * self.cell_m:
            return self.goal, straight
        first = self._nearby(x, y)
        if first is None:
            return self.goal, straight
        left = self._length(first, x, y)
        point = self._place(first)
        index = first
        for _ in range(_AHEAD):
            index = int(self.onward.flat[index])
            after = self._place(index)
            if not self._drives(x, y, after):
                break
            point = after
        return point, left

    def _nearby(self, x: float, y: float) -> int | None:
        """The lattice point around (x, y) with the shortest way that can be driven to."""
        columns, rows = self.left_m.shape
        c = round((x - self.west_m) / self.cell_m)
        r = round((y - self.south_m) / self.cell_m)
        around: list[int] = [
            i * rows + j
            for i in range(max(c - 1, 0), min(c + 2, columns))
            for j in range(max(r - 1, 0), min(r + 2, rows))
            if self.left_m[i, j] < inf
        ]
        if not around:
            return None
        around.sort(key=lambda index: (self._length(index, x, y), index))
        drives = (index for index in around if self._drives(x, y, self._place(index)))
        return next(drives, around[0])

    def _length(self, index: int, x: float, y: float) -> float:
        px, py = self._place(index)
        return float(self.left_m.flat[index]) + hypot(px - x, py - y)

    def _place(self, index: int) -> tuple[float, float]:
        column, row = divmod(index, self.left_m.shape[1])
        return self.west_m + column * self.cell_m, self.south_m + row * self.cell_m

    def _drives(self, x: float, y: float, to: tuple[float, float]) -> bool:
        """No steeper anywhere on the straight way there."""
        length = hypot(to[0] - x, to[1] - y)
        count = max(int(length / (0.5 * self.terrain.cell_m)), 1) + 1
        along = np.linspace((x, y), to, count)
        step = length / (count - 1)
        rise = np.diff(self.terrain.height_at(along))
        return bool((rise <= self.climb * step + 1e-9).all())


def routes_to(
    goal: tuple[float, ...], terrain: Terrain, climb_rad: float, lattice_m: float = LATTICE_M
) -> Routes:
    """All ways to a place.

    Args:
        goal: x, y (and more, ignored) m.
        terrain: the ground; ways stay on it.
        climb_rad: steepest climb.
        lattice_m: spacing of the lattice, at least the terrain's.
    """
    west, south, east, north = terrain.bounds
    cell = max(lattice_m, terrain.cell_m, (east - west) / MOST, (north - south) / MOST)
    columns, rows = int((east - west) / cell) + 1, int((north - south) / cell) + 1
    x = west + cell * np.arange(columns, dtype=np.float64)
    y = south + cell * np.arange(rows, dtype=np.float64)
    climb = float(np.tan(climb_rad))
    cost = [_cost(terrain, x, y, (dc * cell, dr * cell), climb) for dc, dr in _NEIGHBOURS]
    column = min(max(round((goal[0] - west) / cell), 0), columns - 1)
    row = min(max(round((goal[1] - south) / cell), 0), rows - 1)
    left, onward = _shortest(cost, column * rows + row)
    return Routes((goal[0], goal[1]), west, south, cell, left, onward, terrain, climb)


def _cost(terrain: Terrain, x: F64, y: F64, step: tuple[float, float], climb: float) -> F64:
    """Cost (columns, rows) in m of the edges from every lattice point in one direction."""
    length = hypot(*step)
    count = max(int(np.ceil(length / (0.5 * terrain.cell_m))), 1)
    share = np.linspace(0.0, 1.0, count + 1)
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)[:, :, None]
    height = terrain.height_at(points + share[:, None] * np.array(step))
    rise = np.diff(height, axis=-1) / (length / count)
    steep = np.asarray((rise > climb + 1e-9).any(axis=-1))
    up = np.maximum(rise, 0.0) / max(climb, 1e-9)
    slow = np.maximum(1.0 - up, _SLOWEST)
    cost = (length / count * np.sqrt(1.0 + rise * rise) / slow).sum(axis=-1)
    return np.where(steep, inf, cost)


def _shortest(cost: list[F64], goal: int) -> tuple[F64, I64]:
    """Lengths of the shortest ways to a lattice point, and the next point of each."""
    columns, rows = cost[0].shape
    left = np.full(columns * rows, inf)
    onward = np.full(columns * rows, goal, dtype=np.int64)
    left[goal] = 0.0
    done = bytearray(columns * rows)
    flat = [part.reshape(-1).tolist() for part in cost]
    front = [(0.0, goal)]
    while front:
        so_far, index = heapq.heappop(front)
        if done[index]:
            continue
        done[index] = 1
        column, row = divmod(index, rows)
        for (dc, dr), edges in zip(_NEIGHBOURS, flat, strict=True):
            c, r = column - dc, row - dr  # from there an edge leads here
            if not (0 <= c < columns and 0 <= r < rows):
                continue
            before = c * rows + r
            length = so_far + edges[before]
            if length < left[before]:
                left[before] = length
                onward[before] = index
                heapq.heappush(front, (length, before))
    return left.reshape(columns, rows), onward.reshape(columns, rows)
