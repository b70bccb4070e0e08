"""UAVs on lattices that detect targets and revisit them, many runs at once (Shao 2020, section 4).

The decisions are ``planners.pheromone``'s, which also fly; here are what the sensor sees, the
targets' timers, and the order of a step: mark obstacles, decide, move, mark targets, update the
maps.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planners.pheromone import Field, FieldLaw, Weights, look
from planners.pheromone import step as update
from planners.pheromone.detect import DRAWS, STAY, DetectRule, approach, decide, stepped
from planners.pheromone.field import disc
from planners.pheromone.look import free_steps
from planners.pheromone.sectors import inside
from planners.types import F64, I64, Bools
from uavbridge.experiments.shao.ground import Ground

NEVER = -1
_AHEAD = 128  # steps whose random numbers are drawn at once


@dataclass(frozen=True, slots=True)
class World:
    """All that holds for every UAV of every run."""

    period: int = 500  # T
    sensor: float = 4.0  # SD, cells
    law: FieldLaw = dataclasses.field(default_factory=FieldLaw)
    weights: Weights = dataclasses.field(default_factory=Weights)
    rule: DetectRule = dataclasses.field(default_factory=DetectRule)


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """Visits of one step that were asked for."""

    run: I64  # (k,)
    target: I64  # (k,)
    response: I64  # (k,) steps since they were


@dataclass(slots=True, eq=False)
class State:
    """All runs after some steps: leading axes runs (r), UAVs (n), targets (T)."""

    t: int
    cells: I64  # (r, n, 2)
    heading: I64  # (r, n)
    alive: Bools  # (r, n)
    field: Field  # (r, columns, rows)
    seen: Bools  # (r, columns, rows) in some sensor's range so far
    found_at: I64  # (r, T) step, NEVER: not yet
    visited_at: I64  # (r, T) last visit that was asked for
    due_at: I64  # (r, T) since when a visit is asked for, NEVER: none is
    answered: list[Answer] = dataclasses.field(default_factory=list)  # rows, targets, responses

    @property
    def wanted(self) -> Bools:
        """Which targets (r, T) are worth going to: new ones and those that are due."""
        return np.asarray((self.found_at == NEVER) | (self.due_at != NEVER))


class Draws:
    """Numbers (r, n, DRAWS) a step, of every run from its own generator."""

    def __init__(self, generators: Sequence[np.random.Generator], n: int) -> None:
        self._generators, self._n = generators, n
        self._ahead: list[F64] = []

    def next(self) -> F64:
        if not self._ahead:
            shape = (_AHEAD, self._n, DRAWS)
            drawn = np.stack([one.random(shape) for one in self._generators], axis=1)
            self._ahead = list(drawn[::-1])
        return self._ahead.pop()


def simulate(
    ground: Ground,
    generators: Sequence[np.random.Generator],
    world: World,
    steps: int,
    fails_at: I64 | None = None,
) -> Iterator[State]:
    """The state at t = 0, 1, ..., steps: one object, changed in place.

    Args:
        ground: lattices, targets, starts.
        generators: one a run.
        world: what holds for all.
        steps: N_c.
        fails_at: (r, n) step from which a UAV is out of service, NEVER: it stays.
    """
    runs, n = ground.starts.shape[:2]
    nobody = np.full(ground.targets.shape[:2], NEVER, dtype=np.int64)
    state = State(
        0,
        ground.starts.copy(),
        ground.headings.copy(),
        np.ones((runs, n), np.bool_),
        Field.fresh(ground.obstacles.shape, world.law),
        np.zeros(ground.obstacles.shape, np.bool_),
        nobody.copy(),
        nobody.copy(),
        nobody.copy(),
    )
    draws = Draws(generators, n)
    _sense(state, world)
    yield state
    while state.t < steps:
        step(state, ground, world, draws.next(), fails_at)
        yield state


def step(
    state: State, ground: Ground, world: World, draws: F64, fails_at: I64 | None = None
) -> None:
    """One step of every run, Algorithm 1, in place."""
    if fails_at is not None:
        state.alive &= (fails_at == NEVER) | (state.t < fails_at)
    known = ground.obstacles & state.seen
    free = free_steps(known, state.cells)
    means = look(state.field, state.cells, world.sensor).means(world.weights)
    goal = goals(state.cells, state.heading, ground.targets, state.wanted, known, world.sensor)
    chosen = decide(means, state.heading, free, goal, draws, world.rule)
    chosen = np.where(state.alive, chosen, STAY)
    wanted, before = state.wanted, state.cells
    state.cells = stepped(state.cells, chosen)
    state.heading = np.where(chosen == STAY, state.heading, chosen)
    state.t += 1
    state.due_at = np.where(
        (state.found_at != NEVER)
        & (state.due_at == NEVER)
        & (state.t - state.visited_at >= world.period),
        state.t,
        state.due_at,
    )
    _sense(state, world)
    _visit(state, ground, wanted, before)
    state.field = update(
        state.field,
        _sources(state, ground) * world.law.target.deposit,
        np.asarray(known * world.law.obstacle.deposit, np.float64),
        state.cells,
        world.law,
        None if state.alive.all() else state.alive,
    )


def goals(
    cells: I64, heading: I64, targets: I64, wanted: Bools, known: Bools, sensor: float
) -> I64:
    """Headings (r, n) towards the nearest wanted target in sight, ``STAY`` where there is none.

    Args:
        cells: (r, n, 2) of the UAVs.
        heading: (r, n).
        targets: (r, T, 2).
        wanted: (r, T).
        known: (r, columns, rows) obstacles seen so far.
        sensor: radius, cells.
    """
    goal = np.full(heading.shape, STAY, dtype=np.int64)
    apart = targets[:, None] - cells[:, :, None]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    distance = np.where(wanted[:, None] & (distance <= sensor) & (distance > 0.0), distance, np.inf)
    run, uav = np.nonzero(np.isfinite(distance).any(axis=-1))
    if not len(run):
        return goal
    tie = (targets[..., 0] * known.shape[-1] + targets[..., 1]) * 1e-9  # equally near: by cell
    nearest = (distance[run, uav] + tie[run]).argmin(axis=-1)
    blocked = windows(known, run, cells[run, uav], int(sensor))
    goal[run, uav] = approach(blocked, apart[run, uav, nearest], heading[run, uav])
    return goal


def windows(known: Bools, run: I64, cells: I64, reach: int) -> Bools:
    """What can not be entered (k, w, w) around cells (k, 2) of runs (k,), w = 2 reach + 1.

    Obstacles count within the sensor's radius only.
    """
    side = np.arange(-reach, reach + 1)
    offsets = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1)
    around = cells[:, None, None] + offsets
    on_map = inside(around, known.shape[1:])
    column, row = np.where(on_map[..., None], around, 0).transpose(3, 0, 1, 2)
    near = np.hypot(offsets[..., 0], offsets[..., 1]) <= reach
    return np.asarray(~on_map | (near & known[run[:, None, None], column, row]))


def _sense(state: State, world: World) -> None:
    """Every cell in a sensor's range is seen."""
    around = state.cells[:, :, None] + disc(world.sensor)
    valid = inside(around, state.seen.shape[1:]) & state.alive[..., None]
    run = np.broadcast_to(np.arange(len(around))[:, None, None], valid.shape)[valid]
    column, row = around[valid].T
    state.seen[run, column, row] = True


def _visit(state: State, ground: Ground, wanted: Bools, before: I64) -> None:
    """Targets that were wanted (r, T) and are reached: marked when new, answered when due.

    ``before``: (r, n, 2) where the UAVs came from; there they are visited too.
    """
    here = (state.cells[:, :, None] == ground.targets[:, None]).all(axis=-1)
    here |= (before[:, :, None] == ground.targets[:, None]).all(axis=-1)
    reached = (here & state.alive[..., None]).any(axis=1) & wanted
    if not reached.any():
        return
    due = reached & (state.due_at != NEVER)
    run, target = np.nonzero(due)
    if len(run):
        state.answered.append(Answer(run, target, state.t - state.due_at[run, target]))
    state.found_at = np.where(reached & (state.found_at == NEVER), state.t, state.found_at)
    state.visited_at = np.where(reached, state.t, state.visited_at)
    state.due_at = np.where(due, NEVER, state.due_at)


def _sources(state: State, ground: Ground) -> F64:
    """k_tau (r, columns, rows)."""
    sources = np.zeros(state.seen.shape)
    run, target = np.nonzero(state.due_at != NEVER)
    column, row = ground.targets[run, target].T
    sources[run, column, row] = 1.0
    return sources
