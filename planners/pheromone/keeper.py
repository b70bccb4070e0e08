"""Who keeps a pheromone map: of the whole grid, or of one tile of it with a margin.

A keeper takes words (``words``), updates its map once a step, and tells the field around a cell.
It does no I/O. Keepers of neighbouring tiles give each other what lies along their borders
(``margin_of``, ``take``) and pass on words that reach across; then their tiles together are the
one map, to single precision.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from planners.pheromone.field import Field, step
from planners.pheromone.law import FieldLaw
from planners.pheromone.sectors import inside, places, sectors, taken
from planners.pheromone.words import Local, Word
from planners.types import F64, I64, Bools

REMEMBERED = 64  # words of one UAV, to know one that comes twice


class Box(NamedTuple):
    """Cells of a rectangle; the ends are not in it."""

    west: int
    south: int
    east: int
    north: int

    def grown(self, cells: int, shape: tuple[int, int]) -> Box:
        """So many cells wider on every side, as far as the map goes."""
        return Box(
            max(self.west - cells, 0),
            max(self.south - cells, 0),
            min(self.east + cells, shape[0]),
            min(self.north + cells, shape[1]),
        )

    def common(self, other: Box) -> Box:
        """The cells in both; empty where it ends before it begins."""
        return Box(
            max(self.west, other.west),
            max(self.south, other.south),
            min(self.east, other.east),
            min(self.north, other.north),
        )

    @property
    def empty(self) -> bool:
        """No cell is in it."""
        return self.west >= self.east or self.south >= self.north

    @property
    def slices(self) -> tuple[slice, slice]:
        """To index maps (columns, rows)."""
        return slice(self.west, self.east), slice(self.south, self.north)


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A rectangle of a map at one step: what neighbours exchange, and what a store holds."""

    step: int
    box: tuple[int, int, int, int]  # of ``Box``
    layers: F64  # (3, columns, rows) target, obstacle, path
    closed: Bools  # (columns, rows) known obstacles
    marks: I64  # (m, 3) column, row, step of the last visit of targets found
    due: I64  # (m,) step since when a visit is asked for, -1: none is


@dataclass(frozen=True, slots=True)
class KeeperLaw:
    """What a map is kept by."""

    field: FieldLaw = field(default_factory=FieldLaw)
    period: int = 500  # T, steps from a visit to the next signal
    margin: int = 5  # cells of its neighbours' tiles that a keeper knows
    sources: tuple[tuple[int, int], ...] = ()  # cells that always give off target pheromone


@dataclass(slots=True)
class _Mark:
    visited: int  # step of the last visit that was asked for
    due: int = -1  # since when one is


class Keeper:
    """One map, or a tile of it.

    Args:
        shape: columns and rows of the whole map.
        law: what it is kept by.
        tile: its own cells; None: all.
    """

    def __init__(self, shape: tuple[int, int], law: KeeperLaw, tile: Box | None = None) -> None:
        self.law = law
        self.shape = shape
        self.tile = tile or Box(0, 0, *shape)
        self.steps = 0
        self.field = Field.fresh(shape, law.field)
        self.closed = np.zeros(shape, np.bool_)
        self.known = np.zeros(shape, np.bool_)
        self.known[self.tile.slices] = True
        self._marks: dict[tuple[int, int], _Mark] = {}
        self._words: list[tuple[int, Word]] = []
        self._heard: dict[int, dict[int, None]] = {}

    def hear(self, sender: int, word: Word) -> bool:
        """A word arrived; it counts at the next update. False: it was known."""
        heard = self._heard.setdefault(sender, {})
        if word.number in heard:
            return False
        heard[word.number] = None
        if len(heard) > REMEMBERED:
            del heard[next(iter(heard))]
        self._words.append((sender, word))
        return True

    def update(self) -> None:
        """One step of the map, with the words since the last one."""
        self.steps += 1
        words = [word for _, word in sorted(self._words, key=lambda one: (one[0], one[1].number))]
        self._words = []
        for mark in self._marks.values():
            if mark.due < 0 and self.steps - mark.visited >= self.law.period:
                mark.due = self.steps
        for word in words:
            for column, row in self._mine(word.obstacles):
                self.closed[column, row] = True
            for column, row in self._mine(word.targets):
                self._visit((column, row))
        uavs = [word.path for word in words if len(word.path)]
        cells = np.concatenate(uavs) if uavs else np.zeros((0, 2), np.int64)
        obstacles = np.where(self.closed, self.law.field.obstacle.deposit, 0.0)
        self.field = step(self.field, self._sources(), obstacles, cells, self.law.field)

    def local(self, cell: tuple[int, int], radius: int) -> Local:
        """The field around a cell."""
        offsets, _ = sectors(float(radius))
        here = tuple(np.clip(cell, 0, np.array(self.shape) - 1).tolist())
        own = np.array([layer[here] for _, layer in self.layers()])
        place, on_map = places(np.array(cell), offsets, self.shape)
        known = on_map & (taken(self.known.astype(np.float64), place) > 0.0)
        target, obstacle, path = (
            np.where(known, taken(layer, place), 0.0).astype(np.float32).astype(np.float64)
            for layer in (self.field.target, self.field.obstacle, self.field.path)
        )
        closed = on_map & (taken(self.closed.astype(np.float64), place) > 0.0)
        near = {(column, row) for column, row in (offsets + np.array(cell)).tolist()} | {cell}
        marks = [(at, mark.due >= 0) for at, mark in sorted(self._marks.items()) if at in near]
        return Local(
            self.steps,
            cell,
            radius,
            target,
            obstacle,
            path,
            own,
            known,
            closed,
            np.array([at for at, _ in marks], np.int64).reshape(-1, 2),
            np.array([due for _, due in marks], np.bool_),
        )

    def margin_of(self, tile: Box) -> Patch:
        """What the keeper of another tile is to know of this one; empty where none is near."""
        return self.patch(tile.grown(self.law.margin, self.shape).common(self.tile))

    def patch(self, box: Box) -> Patch:
        """A rectangle of the map."""
        fields = (self.field.target, self.field.obstacle, self.field.path)
        marks = [(at, m) for at, m in sorted(self._marks.items()) if _holds(box, at)]
        return Patch(
            self.steps,
            (box.west, box.south, box.east, box.north),
            np.stack([layer[box.slices] for layer in fields]),
            self.closed[box.slices].copy(),
            np.array([(*at, m.visited) for at, m in marks], np.int64).reshape(-1, 3),
            np.array([m.due for _, m in marks], np.int64),
        )

    def take(self, patch: Patch, *, own: bool = False) -> bool:
        """Take over what another keeper, or a store, knows of a rectangle.

        Args:
            patch: what it knows.
            own: it may lie in the own tile: after a restart.

        Returns:
            Whether it fitted.
        """
        box = Box(*patch.box)
        whole = Box(0, 0, *self.shape)
        shape = (box.east - box.west, box.north - box.south)
        if box.empty or box.common(whole) != box or patch.closed.shape != shape:
            return False
        if patch.layers.shape != (3, *shape) or (not own and not box.common(self.tile).empty):
            return False
        for layer, values in zip(
            (self.field.target, self.field.obstacle, self.field.path), patch.layers, strict=True
        ):
            layer[box.slices] = values
        self.closed[box.slices] |= patch.closed
        for (column, row, visited), due in zip(
            patch.marks.tolist(), patch.due.tolist(), strict=True
        ):
            self._marks[column, row] = _Mark(visited, due)
        if own:
            self.steps = max(self.steps, patch.step)
        else:
            self.known[box.slices] = True
        return True

    def layers(self) -> Iterable[tuple[str, F64]]:
        """Names and values (columns, rows) of the three maps."""
        yield "target", self.field.target
        yield "obstacle", self.field.obstacle
        yield "path", self.field.path

    def _mine(self, cells: I64) -> list[tuple[int, int]]:
        """Those of the cells that lie in the tile or its margin."""
        wide = self.tile.grown(self.law.margin, self.shape)
        return [(c, r) for c, r in cells.tolist() if _holds(wide, (c, r))]

    def _visit(self, cell: tuple[int, int]) -> None:
        mark = self._marks.get(cell)
        if mark is None:
            self._marks[cell] = _Mark(self.steps)
        elif mark.due >= 0:
            mark.visited, mark.due = self.steps, -1

    def _sources(self) -> F64:
        sources = np.zeros(self.shape)
        for (column, row), mark in self._marks.items():
            if mark.due >= 0:
                sources[column, row] = self.law.field.target.deposit
        for column, row in self.law.sources:
            if inside(np.array((column, row)), self.shape):
                sources[column, row] = self.law.field.target.deposit
        return sources


def reaches(word: Word, tile: Box, law: KeeperLaw, shape: tuple[int, int]) -> bool:
    """Whether a word matters to the keeper of a tile."""
    wide = tile.grown(max(int(law.field.path.reach), law.margin), shape)
    cells = np.concatenate((word.path, word.obstacles, word.targets))
    low, high = np.array(wide[:2]), np.array(wide[2:])
    return bool(((cells >= low) & (cells < high)).all(axis=1).any())


def _holds(box: Box, cell: tuple[int, int]) -> bool:
    return box.west <= cell[0] < box.east and box.south <= cell[1] < box.north
