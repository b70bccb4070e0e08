"""Point masses that search on one shared map: Algorithm 1 of Liu 2022, a batch of runs at once.

| symbol | name |
| --- | --- |
| P_i(t) | ``Course.tracks`` |
| TPM | ``Course.belief`` |
| t | cycle; index 0 of a curve is the start |
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from planners.belief import scores
from planners.search.guidance import own_cells
from planners.types import F64, I64, Bools
from uavbridge.experiments.liu.methods import Method, Seen
from uavbridge.experiments.liu.setting import GRID, Cell, LiuParams


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """How a batch of runs went; a run that stopped keeps its last values."""

    visited: I64  # (runs, cycles + 1) cells
    uncertainty: F64  # (runs, cycles + 1) one-sided
    entropy: F64  # (runs, cycles + 1) bits
    found: I64  # (runs, targets) cycle at which each was found, -1: not
    covered: I64  # (runs,) cycle at which every cell was visited, -1: not
    stopped: I64  # (runs,) cycle at which the stop rule held, -1: not
    belief: F64  # (runs, columns, rows) at the end
    seen: Bools  # (runs, columns, rows) at the end
    tracks: F64  # (runs, cycles + 1, agents, 2) m


class World:
    """The state of a batch of runs; ``step`` is one cycle."""

    def __init__(
        self,
        method: Method,
        params: LiuParams,
        draws: Sequence[Generator],
        targets: Sequence[Cell],
        prior: F64 | float,
    ) -> None:
        runs, team = len(draws), len(method.scenario.team)
        self.method, self.params = method, params
        self.memory = method.memory(draws, params.cycles)
        starts = method.scenario.starts[:, :2]
        self.position = np.broadcast_to(starts, (runs, team, 2)).copy()
        self.velocity = np.zeros((runs, team, 2))
        self.belief = np.broadcast_to(np.asarray(prior), (runs, *GRID.shape)).copy()
        self.seen = np.zeros((runs, *GRID.shape), np.bool_)
        self.there = np.zeros(GRID.shape, np.bool_)  # the truth
        for target in targets:
            self.there[target] = True
        self.cell = own_cells(GRID, self.position)
        self.running = np.ones(runs, np.bool_)
        self.cycle = 0
        self._others = [np.delete(np.arange(team), agent) for agent in range(team)]
        self._start()

    def step(self) -> None:
        """One cycle: every agent moves, and the cells they enter are read."""
        together = self.params.turns == "together"
        known = (self.position.copy(), self.velocity.copy(), self.belief.copy())
        for agent in range(self.position.shape[1]):
            self._fly(agent, self._decision(agent, known if together else self._now()))
        self.cycle += 1

    def _now(self) -> tuple[F64, F64, F64]:
        return self.position, self.velocity, self.belief

    def _decision(self, agent: int, known: tuple[F64, F64, F64]) -> F64:
        """Velocities (runs, 2) m/s that one agent wants."""
        position, velocity, belief = known
        others = self._others[agent]
        present = np.ones((len(position), len(others)), np.bool_)
        seen = Seen(position[:, agent], position[:, others], velocity[:, others], present, belief)
        return self.method.move(self.memory, agent, self.cycle, seen)

    def _fly(self, agent: int, velocity: F64) -> None:
        flown = np.where(self.running[:, None], velocity, 0.0)
        self.velocity[:, agent] = flown
        self.position[:, agent] += flown * self.method.scenario.tick_s  # Eqs. (10), (11)
        entered = self._enter(agent)
        if self.params.update_on == "cycle":
            entered = self.running
        self._read(self.cell[:, agent], entered)

    def _enter(self, agent: int) -> Bools:
        """Which runs (runs,) have the agent in another cell than before; remembers the cell."""
        cell = own_cells(GRID, self.position[:, agent])
        entered = (cell != self.cell[:, agent]).any(axis=-1)
        self.cell[:, agent] = cell
        return np.asarray(entered & self.running)

    def _read(self, cell: I64, which: Bools) -> None:
        """Eqs. (3)-(5) at the cells (runs, 2) of the runs in ``which`` (runs,)."""
        run = np.flatnonzero(which)
        at = (run, cell[run, 0], cell[run, 1])
        self.seen[at] = True
        detected = self.there[at[1:]]
        self.belief[at] = self.params.sensor.after(self.belief[at], detected)

    def _start(self) -> None:
        if self.params.start_cells == "unvisited":
            return
        for agent in range(self.position.shape[1]):
            cell = self.cell[:, agent]
            if self.params.start_cells == "read":
                self._read(cell, self.running)
            self.seen[np.arange(len(cell)), cell[:, 0], cell[:, 1]] = True


def search(
    method: Method,
    params: LiuParams,
    draws: Sequence[Generator],
    targets: Sequence[Cell],
    prior: F64 | float | None = None,
    kind: type[World] = World,
) -> Course:
    """Runs of one method.

    Args:
        method: which.
        params: the paper's numbers and the readings.
        draws: a generator a run.
        targets: cells that hold one.
        prior: the map at the start, (columns, rows) or one number; None: the parameters'.
        kind: point masses, or another world.
    """
    world = kind(method, params, draws, targets, params.prior if prior is None else prior)
    runs, points = len(draws), params.cycles + 1
    visited = np.zeros((runs, points), np.int64)
    uncertainty, entropy = np.zeros((2, runs, points))
    tracks = np.zeros((runs, points, *world.position.shape[1:]))
    found = np.full((runs, len(targets)), -1, np.int64)
    covered, stopped = np.full((2, runs), -1, np.int64)
    columns = [target[0] for target in targets]
    rows = [target[1] for target in targets]
    for cycle in range(points):
        if cycle and world.running.any():
            world.step()
        visited[:, cycle] = world.seen.sum(axis=(-2, -1))
        uncertainty[:, cycle] = scores.uncertainty(world.belief)
        entropy[:, cycle] = scores.entropy(world.belief)
        tracks[:, cycle] = world.position
        declared = world.belief[:, columns, rows] >= params.threshold
        found[(found < 0) & declared] = cycle
        covered[(covered < 0) & (visited[:, cycle] == GRID.size)] = cycle
        ends = _ends(params, found, uncertainty[:, cycle]) & world.running
        stopped[ends] = cycle
        world.running &= ~ends
    return Course(
        visited, uncertainty, entropy, found, covered, stopped, world.belief, world.seen, tracks
    )


def _ends(params: LiuParams, found: I64, uncertainty: F64) -> Bools:
    """Which runs (runs,) the stop rule ends."""
    targets = (found >= 0).all(axis=-1) & (found.shape[-1] > 0)
    certain = uncertainty < params.uncertainty_goal
    rules = {
        "never": np.zeros_like(certain),
        "targets": targets,
        "uncertainty": certain,
        "either": targets | certain,  # Algorithm 1, last lines
        "both": (targets if found.shape[-1] else certain) & certain,  # section 4, the text
    }
    return np.asarray(rules[params.stop])
