"""Detection and revisit by one UAV: one row of the kernels, cell by cell (Shao 2020, Algorithm 1).

It deposits and asks once it has chosen a cell, flies there without stopping, and has the answer
when it must choose the next one. Without an answer it goes by costs alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from planners.pheromone.detect import DRAWS, STAY, approach, decide, stepped
from planners.pheromone.field import disc
from planners.pheromone.sectors import HEADINGS, STEPS
from planners.pheromone.words import ASK, OBSTACLE, PATH, TARGET, Local, decode_local, encode_query
from planners.search.pheromone.columns import closed_cells
from planners.search.pheromone.params import PheromoneParams
from planners.types import F64, I64, Ask, Bools, Edit, Scenario, View

LIKELY = 0.5  # a cell above it is gone to, and looked at again on the way
RECENT = 5  # ticks until what was told must be in the answers
_NONE: I64 = np.zeros((0, 2), np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class WalkMemory:
    """Where it goes, and what it has told."""

    cell: tuple[int, int]  # the one it flies to
    heading: int
    asked: int  # tick of the newest question
    local: bytes  # the answer for the cell; empty: none yet
    told: I64  # (k,) flat cells of obstacles told
    visited: I64  # (m, 2) flat cell, and the tick when it was told as visited


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """What a walk wants at one tick."""

    memory: WalkMemory
    edits: tuple[Edit, ...]
    asks: tuple[Ask, ...]
    stays: bool  # no way is open


@dataclass(frozen=True, slots=True)
class Walk:
    """The rules of a walk.

    Args:
        scenario: the search.
        params: Table 1.
        box: west, south, east, north: the cells that it keeps to.
    """

    scenario: Scenario
    params: PheromoneParams
    box: tuple[int, int, int, int]

    def begin(self, view: View) -> WalkMemory:
        """At the cell where the UAV is, or the nearest one in the box."""
        west, south, east, north = self.box
        column, row = self.scenario.grid.cell_of(view.position).tolist()
        cell = (min(max(column, west), east - 1), min(max(row, south), north - 1))
        heading = round(view.heading_rad / (np.pi / 4.0)) % HEADINGS
        return WalkMemory(cell, heading, -1, b"", np.zeros(0, np.int64), _NONE)

    def turn(self, view: View, memory: WalkMemory, rng: Generator) -> Turn:
        """Flies on, or decides where it has come to a cell."""
        memory = self._answered(view, memory)
        if self._arrived(view, memory):
            return self._decided(view, memory, rng)
        if memory.local or memory.asked == view.tick:
            return Turn(memory, (), (), stays=False)
        return Turn(memory, (), (self._ask(memory.cell),), stays=False)

    def _answered(self, view: View, memory: WalkMemory) -> WalkMemory:
        for answer in view.answers:
            local = decode_local(answer.data) if answer.key == ASK else None
            if local is not None and local.cell == memory.cell and self._fits(local):
                memory = _with_local(memory, answer.data)
        return memory

    def _fits(self, local: Local) -> bool:
        return local.radius == self.params.sensor

    def _arrived(self, view: View, memory: WalkMemory) -> bool:
        """At its cell, or that cell turns out to be closed."""
        grid = self.scenario.grid
        apart = grid.centre_of(memory.cell) - view.position[:2]
        pace = self.params.speed_m_s * self.scenario.tick_s
        near = max(self.params.capture * grid.cell_m, 0.6 * min(pace, grid.cell_m))
        if float(np.hypot(apart[0], apart[1])) <= near:
            return True
        return bool(self._closed(view, np.array([memory.cell]))[0])

    def _decided(self, view: View, memory: WalkMemory, rng: Generator) -> Turn:
        params, grid = self.params, self.scenario.grid
        if self._closed(view, np.array([memory.cell]))[0]:
            memory = self._elsewhere(view, memory)
        cell, heading = np.array(memory.cell), np.array(memory.heading)
        local = decode_local(memory.local) if memory.local else None
        means = np.ones(HEADINGS) if local is None else local.look().means(params.weights)
        ring = cell + STEPS
        free = self._inside(ring) & ~self._closed(view, ring) & ~_told_closed(local, ring)
        wanted = self._wanted(view, memory, local)
        goal = self._goal(view, memory, wanted)
        chosen = int(decide(means, heading, free, goal, rng.random(DRAWS), params.rule))
        moved = stepped(cell, np.array(chosen)) if chosen != STAY else cell
        there = (int(moved[0]), int(moved[1]))
        seen = cell + disc(float(params.sensor))
        seen = seen[grid.inside(seen)]
        seen = seen[self._closed(view, seen)]
        fresh, told = new_columns(seen, memory.told, grid.rows)
        sure = {*self._held(view, memory.cell, self.scenario.detection_threshold), *_marks(local)}
        visits = np.array([at for at in wanted if at in sure & {memory.cell, there}], np.int64)
        visits = visits.reshape(-1, 2)
        after = WalkMemory(
            there,
            memory.heading if chosen == STAY else chosen,
            view.tick,
            b"",
            told,
            self._remembered(memory, visits, view.tick),
        )
        edits = edits_of(moved[None], fresh, visits)
        return Turn(after, edits, (self._ask(there),), stays=chosen == STAY)

    def _elsewhere(self, view: View, memory: WalkMemory) -> WalkMemory:
        """The cell it flew to is closed: it decides anew where it is."""
        here = self.begin(view)
        return WalkMemory(here.cell, memory.heading, memory.asked, b"", memory.told, memory.visited)

    def _ask(self, cell: tuple[int, int]) -> Ask:
        return Ask(ASK, encode_query(cell, self.params.sensor))

    def _inside(self, cells: I64) -> Bools:
        west, south, east, north = self.box
        column, row = cells[..., 0], cells[..., 1]
        return np.asarray((column >= west) & (column < east) & (row >= south) & (row < north))

    def _closed(self, view: View, cells: I64) -> Bools:
        columns = np.concatenate((self.scenario.obstacles, view.obstacles))
        return closed_cells(self.scenario.grid, columns, cells, self.params.clearance_m)

    def _wanted(self, view: View, memory: WalkMemory, local: Local | None) -> list[tuple[int, int]]:
        """Targets in sight that are new or wait for a visit, the nearest first.

        Likely ones too: looks from nearby will make them sure, or rule them out.
        """
        marks, sure = _marks(local), self.scenario.detection_threshold
        lately = {int(flat): int(tick) for flat, tick in memory.visited}
        reach = self.params.sensor
        found = []
        for cell in {*self._held(view, memory.cell, min(LIKELY, sure)), *marks}:
            apart = float(np.hypot(cell[0] - memory.cell[0], cell[1] - memory.cell[1]))
            told = lately.get(cell[0] * self.scenario.grid.rows + cell[1])
            patience = self.params.period if local is None else RECENT
            known = told is not None and view.tick - told < patience
            if apart <= reach and marks.get(cell, not known) and self._inside(np.array(cell)):
                found.append((apart, cell))
        return [cell for _, cell in sorted(found)]

    def _held(self, view: View, cell: tuple[int, int], likely: float) -> Iterator[tuple[int, int]]:
        """Cells around one that the own map holds more likely than that to have a target."""
        reach = self.params.sensor
        west, south = max(cell[0] - reach, 0), max(cell[1] - reach, 0)
        part = view.belief[west : cell[0] + reach + 1, south : cell[1] + reach + 1]
        for column, row in np.argwhere(part > likely).tolist():
            yield west + column, south + row

    def _goal(self, view: View, memory: WalkMemory, wanted: list[tuple[int, int]]) -> I64:
        """Heading towards the nearest wanted target, or ``STAY``."""
        ahead = [cell for cell in wanted if cell != memory.cell]
        if not ahead:
            return np.array(STAY)
        reach = self.params.sensor
        side = np.arange(-reach, reach + 1)
        offsets = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1)
        cells = np.array(memory.cell) + offsets
        near = np.hypot(offsets[..., 0], offsets[..., 1]) <= reach
        closed = self._closed(view, cells.reshape(-1, 2)).reshape(near.shape)
        blocked = ~self._inside(cells) | (near & closed)
        target = np.array(ahead[0]) - np.array(memory.cell)
        return approach(blocked[None], target[None], np.array([memory.heading])).reshape(())

    def _remembered(self, memory: WalkMemory, visits: I64, tick: int) -> I64:
        """What was visited within the period."""
        lately = memory.visited[tick - memory.visited[:, 1] < self.params.period]
        flat = _flat(visits, self.scenario.grid.rows)
        kept = lately[~np.isin(lately[:, 0], flat)]
        return np.concatenate((kept, np.stack((flat, np.full_like(flat, tick)), axis=-1)))


def new_columns(cells: I64, told: I64, rows: int) -> tuple[I64, I64]:
    """Of closed cells (k, 2) those not told yet, and all flat cells told after that."""
    flat = _flat(cells, rows)
    return cells[~np.isin(flat, told)], np.union1d(told, flat)


def edits_of(path: I64, obstacles: I64, targets: I64) -> tuple[Edit, ...]:
    """What is to be deposited at cells (k, 2) of each kind."""
    kinds = ((PATH, path), (OBSTACLE, obstacles), (TARGET, targets))
    return tuple(
        Edit(name, np.asarray(cells, np.int64), np.ones(len(cells)))
        for name, cells in kinds
        if len(cells)
    )


def way_to(position: F64, point: F64, speed_m_s: float) -> F64:
    """Velocity (2,) m/s towards a point (2,), at one speed until it is reached."""
    offset = point - position[:2]
    distance = float(np.hypot(offset[0], offset[1]))
    return np.asarray(offset / max(distance, 1e-6) * speed_m_s)


def _with_local(memory: WalkMemory, data: bytes) -> WalkMemory:
    return WalkMemory(memory.cell, memory.heading, memory.asked, data, memory.told, memory.visited)


def _flat(cells: I64, rows: int) -> I64:
    return np.asarray(cells[..., 0] * rows + cells[..., 1])


def _told_closed(local: Local | None, cells: I64) -> Bools:
    """Which cells (k, 2) the answer says are obstacles."""
    if local is None or not local.closed.any():
        return np.zeros(len(cells), np.bool_)
    closed = {(c, r) for c, r in local.cells()[local.closed].tolist()}
    return np.array([(c, r) in closed for c, r in cells.tolist()])


def _marks(local: Local | None) -> dict[tuple[int, int], bool]:
    if local is None:
        return {}
    return {(c, r): bool(due) for (c, r), due in zip(local.marks.tolist(), local.due, strict=True)}
