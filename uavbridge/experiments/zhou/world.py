"""Robots on mountains, many runs at once: terrain, targets, radio, energy.

The decisions are ``planners.search.mountain.step``'s, which also flies; here are only
what a robot senses and hears, and what its steps cost.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planners.search.mountain import MountainParams, Rules, signal
from planners.search.mountain.state import (
    DRAWS,
    Draws,
    Heard,
    Messages,
    Robots,
    Sensed,
    fresh,
    length,
)
from planners.search.mountain.step import step
from planners.terrain import Terrain
from planners.types import F64, I64, Bools
from uavbridge.radio.draws import Purpose
from uavbridge.radio.draws import draw as uniform


@dataclass(frozen=True, slots=True)
class World:
    """What is not the planner's: Table 2's alpha, d_0, m, Q, and beyond the paper's ideal."""

    reached_m: float = 10.0  # d_0
    attenuation: float = 0.1  # m
    power: float = 1e5  # Q
    radio_m: float = 300.0  # d_com
    loss: float = 0.0  # share of messages that a receiver misses
    delay: int = 0  # steps that messages take, beyond the one
    energy_m: float = np.inf  # a robot that has driven so far stands and is silent
    steps: int = 2000  # after which a run is unfinished
    silent_when_found: bool = True  # a target that is reached gives no more signals


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """All runs after a step: leading axes runs (r), robots (n), targets (T)."""

    t: int
    run: I64  # (r,) which of the runs these are
    position: F64  # (r, n, 3) m
    robots: Robots  # (r, n)
    driven: F64  # (r, n) m, sum of |V|
    reached: Bools  # (r, T)
    reached_at: I64  # (r, T) step, -1: not yet
    reached_by: I64  # (r, T) robot, -1: nobody yet

    def keep(self, rows: Bools) -> State:
        """Some of the runs."""
        return State(
            self.t,
            self.run[rows],
            self.position[rows],
            self.robots.map(lambda part: part[rows]),
            self.driven[rows],
            self.reached[rows],
            self.reached_at[rows],
            self.reached_by[rows],
        )


def simulate(
    terrain: Terrain,
    starts: F64,
    targets: F64,
    generators: Sequence[np.random.Generator],
    params: MountainParams,
    world: World,
) -> Iterator[State]:
    """States of the runs at t = 1, 2, ..., without those that are done; ends when all are.

    A run is yielded once with all its targets reached, and then left out.

    Args:
        terrain: the ground of all these runs; its bounds are the search's.
        starts: (runs, n, 2 or 3) m.
        targets: (runs, T, 2 or 3) m.
        generators: one a run.
        params: the planner's.
        world: what is not.
    """
    rules = Rules.of(params, world.radio_m, 1.0)
    state = _begin(terrain, starts, generators, rules, targets.shape[1])
    goals = _grounded(terrain, targets)
    draw = _Randomness(generators)
    radio = _Radio(world)
    while len(state.run):
        state, sensed = _sense(state, goals[state.run], draw, params, world)
        done = state.reached.all(axis=1)
        yield state
        if done.any() or state.t >= world.steps:
            rows: Bools = ~done & (np.asarray(state.t) < world.steps)
            state, sensed = state.keep(rows), _rows(sensed, rows)
            radio.keep(rows)
        if len(state.run):
            state = _move(state, sensed, draw, radio, terrain, rules, world)


def _begin(
    terrain: Terrain,
    starts: F64,
    generators: Sequence[np.random.Generator],
    rules: Rules,
    targets: int,
) -> State:
    runs, n = starts.shape[:2]
    heading = np.stack([one.uniform(0.0, 2.0 * np.pi, n) for one in generators])
    velocity = np.stack((np.cos(heading), np.sin(heading), np.zeros_like(heading)), axis=-1)
    robots = fresh((runs, n), targets, rules.params.members, velocity * rules.speed_m)
    nobody = np.full((runs, targets), -1, dtype=np.int64)
    return State(
        1,
        np.arange(runs),
        _grounded(terrain, starts),
        robots,
        np.zeros((runs, n)),
        np.zeros((runs, targets), np.bool_),
        nobody,
        nobody,
    )


def _grounded(terrain: Terrain, points: F64) -> F64:
    return np.concatenate((points[..., :2], terrain.height_at(points)[..., None]), axis=-1)


def _sense(
    state: State, targets: F64, draw: _Randomness, params: MountainParams, world: World
) -> tuple[State, Sensed]:
    """Signals of targets, Eq. (1), and who has reached one."""
    offset = state.position[:, :, None] - targets[:, None]
    distance = length(offset)
    able = _able(state, world)[..., None]
    arrived = (distance < world.reached_m) & able
    heard = (distance <= params.detection_m) & able
    if world.silent_when_found:
        heard &= ~state.reached[:, None]
    noise = draw.normal(state.run, distance.shape[1:])
    strength = signal(distance, noise, world.attenuation, world.power, params.detection_m)
    new = arrived.any(axis=1) & ~state.reached
    after = replace(
        state,
        reached=state.reached | new,
        reached_at=np.where(new, state.t, state.reached_at),
        reached_by=np.where(new, arrived.argmax(axis=1), state.reached_by),
    )
    return after, Sensed(state.position, strength, heard, arrived)


def _rows(sensed: Sensed, rows: Bools) -> Sensed:
    return Sensed(
        sensed.position[rows], sensed.strength[rows], sensed.heard[rows], sensed.arrived[rows]
    )


def _able(state: State, world: World) -> Bools:
    return np.asarray(state.driven < world.energy_m)


def _move(
    state: State,
    sensed: Sensed,
    draw: _Randomness,
    radio: _Radio,
    terrain: Terrain,
    rules: Rules,
    world: World,
) -> State:
    n = state.position.shape[1]
    ids = np.broadcast_to(np.arange(n), state.position.shape[:2])
    able = _able(state, world)
    heard = radio.heard(state, able, draw)
    draws = Draws.of(draw.uniform(state.run, (n, DRAWS)))
    velocity, robots = step(ids, state.robots, sensed, heard, draws, terrain, terrain.bounds, rules)
    if not able.all():
        velocity = velocity * able[..., None]
    position = state.position + velocity
    driven = state.driven + length(velocity)
    return replace(state, t=state.t + 1, position=position, robots=robots, driven=driven)


class _Randomness:
    """Draws of every run from its own generator, whichever runs go on."""

    def __init__(self, generators: Sequence[np.random.Generator]) -> None:
        self._generators = generators

    @cached_property
    def seeds(self) -> I64:
        """(runs,) for what is drawn by number."""
        return np.array([one.integers(2**62) for one in self._generators])

    def normal(self, run: I64, shape: tuple[int, ...]) -> F64:
        return np.stack([self._generators[i].standard_normal(shape) for i in run])

    def uniform(self, run: I64, shape: tuple[int, ...]) -> F64:
        return np.stack([self._generators[i].random(shape) for i in run])


class _Radio:
    """Who knows what of whom: range at sending, loss, delay; the newest message counts."""

    FORGOTTEN = 5  # steps

    def __init__(self, world: World) -> None:
        self._world = world
        self._past: list[tuple[Messages, F64]] = []  # newest first: messages, places
        self._arrives: list[Bools] = []  # newest first, still under way: (r, receiver, sender)
        self._age: I64 | None = None  # (r, receiver, sender) steps; large: never

    def keep(self, rows: Bools) -> None:
        """Goes on with some of the runs."""
        self._past = [(m.map(lambda part: part[rows]), place[rows]) for m, place in self._past]
        self._arrives = [part[rows] for part in self._arrives]
        if self._age is not None:
            self._age = self._age[rows]

    def heard(self, state: State, able: Bools, draw: _Randomness) -> Heard:
        """Messages of the last step, or older ones where they are lost or late."""
        runs, n = state.position.shape[:2]
        ids = np.broadcast_to(np.arange(n), (runs, 1, n))
        offset = state.position[:, :, None] - state.position[:, None]
        near = length(offset) <= self._world.radio_m
        near &= able[:, None, :]
        own = np.eye(n, dtype=np.bool_)
        if not (self._world.loss or self._world.delay):
            told = state.robots.told.map(lambda part: part[:, None])
            return Heard(ids, state.position[:, None], near | own, told)
        if self._world.loss:
            link = np.arange(n)
            seeds = draw.seeds[state.run, None, None]
            near &= uniform(seeds, Purpose.LOSS, link, link[:, None], state.t) >= self._world.loss
        return self._late(state, ids, near, own)

    def _late(self, state: State, ids: I64, near: Bools, own: Bools) -> Heard:
        delay = self._world.delay
        longest = self.FORGOTTEN + delay + 1
        self._past = [(state.robots.told, state.position), *self._past][:longest]
        self._arrives = [near, *self._arrives][: delay + 1]
        age = np.full(near.shape, longest) if self._age is None else self._age + 1
        if len(self._arrives) > delay:
            age = np.where(self._arrives[delay], delay, age)
        self._age = np.where(own, 0, np.minimum(age, longest))
        known = self._age < len(self._past)
        at = np.minimum(self._age, len(self._past) - 1)
        run, sender = np.ogrid[: near.shape[0], : near.shape[2]]
        index = at, run[:, :, None], sender[:, None]
        places = np.stack([place for _, place in self._past])[index]
        parts = {
            name: np.stack([getattr(told, name) for told, _ in self._past])[index]
            for name in Messages.__slots__
        }
        return Heard(ids, places, known, Messages(**parts))
