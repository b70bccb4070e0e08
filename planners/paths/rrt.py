"""Rapidly-exploring random trees over terrain.

LaValle and Kuffner 2001; Chen 2023, sections 3.1 to 3.3: grow a tree by steps towards random
points, join the goal as soon as it is in sight of the newest node, then skip nodes.

| matter | reading |
| --- | --- |
| X_obt | nearer than ``clearance_m`` to the ground, above the ceiling, or outside the terrain |
| collision test | exact over the lattice (``planners.paths.ground``), not by samples |
| smoothing | ``skipped``: "printed" stops at the first leg that is blocked; "farthest" looks on |
| climb | legs steeper than ``climb_rad`` are refused: an airplane could not fly them |
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from numpy.random import Generator

from planners.paths.ground import clear
from planners.terrain import Terrain

_F64 = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RrtRules:
    """How a tree grows."""

    step_m: float = 50.0  # length of an extension
    clearance_m: float = 20.0  # least height above ground
    ceiling_m: float = math.inf  # largest height; inf: a step over top and ends
    climb_rad: float = math.pi / 2.0  # largest slope of a leg
    goal_bias: float = 0.0  # share of samples that are the goal; none in the paper
    nodes: int = 4000  # samples before it gives up
    smoothing: str = "farthest"  # or "printed", or "none"


@dataclass(frozen=True, slots=True, eq=False)
class RrtPath:
    """A way from start to goal, and the tree it was found with."""

    points: _F64  # (k, 3) after smoothing
    raw: _F64  # (m, 3) before
    samples: int
    nodes: _F64 = field(default_factory=lambda: np.zeros((0, 3)))  # (n, 3)
    parents: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))  # (n,)

    @property
    def length(self) -> float:
        """Metres, after smoothing."""
        return path_length(self.points)

    @property
    def raw_length(self) -> float:
        """Metres, before smoothing."""
        return path_length(self.raw)


def plan(
    terrain: Terrain, start: npt.ArrayLike, goal: npt.ArrayLike, rules: RrtRules, rng: Generator
) -> RrtPath | None:
    """A way between two points (3,), or None when ``rules.nodes`` samples did not find one.

    Raises:
        ValueError: start or goal cannot be flown at, or the rules make no sense.
    """
    here, there = _point(start, "start"), _point(goal, "goal")
    space = _Space(terrain, rules, max(here[2], there[2]))
    for name, point in (("start", here), ("goal", there)):
        if not space.free(point, point):
            raise ValueError(f"rrt: the {name} {point} {space.fault(point)}")
    if space.free(here, there):
        line = np.stack((here, there))
        return RrtPath(line, line, 0, here[None], np.array([-1]))
    tree = _Tree(here, rules.nodes + 1)
    for sample in range(1, rules.nodes + 1):
        wish = there if rng.uniform() < rules.goal_bias else space.draw(rng)
        near = tree.nearest(wish)
        offset = wish - tree.points[near]
        away = float(np.linalg.norm(offset))
        if away < 1e-9:
            continue
        new = tree.points[near] + offset * min(1.0, rules.step_m / away)
        if not space.free(tree.points[near], new):
            continue
        tree.add(new, near)
        if space.free(new, there):
            raw = np.concatenate((tree.way(tree.size - 1), there[None]))
            points = skipped(terrain, raw, rules)
            nodes, parents = tree.points[: tree.size], tree.parents[: tree.size]
            return RrtPath(points, raw, sample, nodes.copy(), parents.copy())
    return None


def skipped(terrain: Terrain, points: _F64, rules: RrtRules) -> _F64:
    """The polyline (k, 3) with the nodes left out that need not be flown to (section 3.2)."""
    if rules.smoothing == "none":
        return points
    space = _Space(terrain, rules, float(points[:, 2].max()))
    kept, at, last = [0], 0, len(points) - 1
    while at < last:
        ahead = points[at + 1 :]
        seen = space.free_all(points[at], ahead)
        seen[0] = True  # the tree's own leg
        if rules.smoothing == "printed":
            at += len(seen) if seen.all() else int(np.argmin(seen))
        else:
            at += int(np.nonzero(seen)[0][-1]) + 1
        kept.append(at)
    return points[kept]


def resampled(points: _F64, spacing_m: float) -> _F64:
    """Points (n, 3) along the polyline (k, 3), ``spacing_m`` apart but for the last leg."""
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    ends = np.concatenate(([0.0], np.cumsum(legs)))
    count = math.floor(ends[-1] / spacing_m + 1e-9)
    along = np.arange(count + 1) * spacing_m
    if ends[-1] - along[-1] > 1e-6 * spacing_m:
        along = np.append(along, ends[-1])
    return np.stack([np.interp(along, ends, points[:, axis]) for axis in range(3)], axis=-1)


def path_length(points: _F64) -> float:
    """Length in m of the polyline (k, 3)."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


class _Space:
    """Where a leg may lie."""

    def __init__(self, terrain: Terrain, rules: RrtRules, highest: float) -> None:
        _check(rules)
        top = max(float(terrain.heights.max()) + rules.clearance_m + rules.step_m, highest)
        self._terrain, self._rules = terrain, rules
        self._ceiling = (
            min(rules.ceiling_m, top) if math.isinf(rules.ceiling_m) else rules.ceiling_m
        )
        west, south, east, north = terrain.bounds
        floor = float(terrain.heights.min()) + rules.clearance_m
        self._low = np.array((west, south, min(floor, self._ceiling)))
        self._high = np.array((east, north, self._ceiling))

    def draw(self, rng: Generator) -> _F64:
        return rng.uniform(self._low, self._high)

    def fault(self, point: _F64) -> str:
        """Why a point cannot be flown at, as the end of a sentence."""
        if (point[:2] < self._low[:2] - 1e-9).any() or (point[:2] > self._high[:2] + 1e-9).any():
            return "lies outside the terrain"
        if point[2] > self._ceiling + 1e-9:
            return f"lies above the ceiling of {self._ceiling:g} m"
        height = float(point[2] - self._terrain.height_at(point))
        return f"is {height:g} m above ground, {self._rules.clearance_m:g} m are the least"

    def free(self, start: _F64, end: _F64) -> bool:
        return bool(self.free_all(start, end[None])[0])

    def free_all(self, start: _F64, ends: _F64) -> npt.NDArray[np.bool_]:
        """Which legs from ``start`` (3,) to ``ends`` (k, 3) are free."""
        inside = ((ends >= self._low - 1e-9) & (ends <= self._high + 1e-9)).all(axis=-1)
        inside &= bool((start <= self._high + 1e-9).all())
        if self._rules.climb_rad < math.pi / 2.0:
            offset = ends - start
            level = np.hypot(offset[:, 0], offset[:, 1])
            inside &= np.abs(offset[:, 2]) <= math.tan(self._rules.climb_rad) * level + 1e-9
        free = np.zeros(len(ends), np.bool_)
        free[inside] = clear(self._terrain, start, ends[inside], self._rules.clearance_m)
        return free


class _Tree:
    """Nodes (size, 3) and the parent of each."""

    def __init__(self, root: _F64, capacity: int) -> None:
        self.points = np.zeros((capacity, 3))
        self.parents = np.full(capacity, -1, np.int64)
        self.points[0] = root
        self.size = 1

    def nearest(self, point: _F64) -> int:
        offset = self.points[: self.size] - point
        return int(np.argmin(np.einsum("ij,ij->i", offset, offset)))

    def add(self, point: _F64, parent: int) -> None:
        self.points[self.size], self.parents[self.size] = point, parent
        self.size += 1

    def way(self, node: int) -> _F64:
        """Points (k, 3) from the root to a node."""
        order = []
        while node >= 0:
            order.append(node)
            node = int(self.parents[node])
        return self.points[order[::-1]].copy()


def _check(rules: RrtRules) -> None:
    for name, sound, wanted in (
        ("step_m", 0.0 < rules.step_m < math.inf, "positive"),
        ("clearance_m", 0.0 <= rules.clearance_m < math.inf, "zero or more"),
        ("ceiling_m", not math.isnan(rules.ceiling_m), "a number"),
        ("climb_rad", rules.climb_rad > 0.0, "positive"),
        ("goal_bias", 0.0 <= rules.goal_bias <= 1.0, "from 0 to 1"),
        ("nodes", rules.nodes >= 0, "zero or more"),
    ):
        if not sound:
            raise ValueError(f"rrt: {name} must be {wanted}, not {getattr(rules, name)}")
    if rules.smoothing not in ("farthest", "printed", "none"):
        raise ValueError(f"rrt: no smoothing {rules.smoothing!r}")


def _point(value: npt.ArrayLike, name: str) -> _F64:
    point = np.asarray(value, dtype=np.float64)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ValueError(f"rrt: the {name} must be three finite numbers, not {value!r}")
    return point
