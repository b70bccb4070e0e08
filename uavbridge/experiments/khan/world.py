"""The paper's world for many runs at once: sweeps, readings, exchange, end at P >= B.

Arrays lead with the runs that are still going, then the UAVs. A step: every UAV
reads its cell, those in range exchange, and the run ends when some map holds a
cell at or above the threshold; else all move on. UAVs are looked at by number
and their cells by number when several reach it at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from planners.paths.sweeps import LOOPS
from planners.types import F64, I64, Bools
from uavbridge.experiments.experiment import generators
from uavbridge.experiments.khan.choices import KhanParams
from uavbridge.radio.draws import Purpose, draw
from uavbridge.rng import stream

STEP_US = 1_000_000  # stamps
_CHUNK = 64  # steps whose draws are made at once
_LEFT = 0.8  # runs that ended are let go when fewer than this share are left


class Team(Protocol):
    """What the UAVs of all runs know."""

    @property
    def probability(self) -> F64:
        """(runs, N, cells)."""
        ...

    @property
    def bytes_sent(self) -> F64:
        """(runs,) by all UAVs so far, where bytes are counted; else zeros."""
        ...

    def observe(self, cells: I64, detected: Bools, who: I64, t_us: int) -> None:
        """Readings (runs, N) of the UAVs numbered ``who``, at their cells (runs, N)."""
        ...

    def exchange(self, reach: Bools, cells: I64, who: I64) -> None:
        """What ``who`` just observed goes out; reach (runs, receivers, senders)."""
        ...

    def fade(self, share: float) -> None:
        """Every cell loses a share of its log odds."""
        ...

    def keep(self, runs: Bools) -> None:
        """Go on with these runs alone."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Fates:
    """How runs (k,) ended."""

    steps: I64  # time steps until P >= B; steps_most when that never came
    cell: I64  # the flat cell named; -1: none
    target: I64  # the flat cell where the target was then
    bytes_sent: F64  # by all UAVs, where the team counts them

    @property
    def wrong(self) -> Bools:
        """Another cell than the target's was named, or none."""
        return np.asarray(self.cell != self.target)


class Luck:
    """Draws of runs, the same whichever runs are simulated together.

    Args:
        seeds: (runs,).
        uavs: N.
        choices: of where UAVs start.
    """

    def __init__(self, seeds: I64, uavs: int, choices: KhanParams) -> None:
        self._generators = generators(seeds)
        self._width = uavs + 1
        self._first = -_CHUNK
        self._drawn = np.zeros((0, 0, 0))
        once = stream(choices.starts_seed, "khan starts", uavs).random((uavs, 2))
        own = np.array([generator.random((uavs, 2)) for generator in self._generators])
        own = own.reshape(len(seeds), uavs, 2)
        self.start = np.broadcast_to(once, own.shape) if choices.starts == "once" else own

    def of(self, step: int) -> F64:
        """Uniform draws (runs, k) of a step, steps ascending: N readings, the target."""
        if step >= self._first + _CHUNK:
            self._first += _CHUNK
            size = (_CHUNK, self._width)
            self._drawn = np.array([generator.random(size) for generator in self._generators])
        return self._drawn[:, step - self._first]


def loop_of(choices: KhanParams) -> I64:
    """(L,) flat cells of the loop that all UAVs follow."""
    cells = LOOPS[choices.sweep](choices.columns, choices.rows)
    return cells[:, 0] * choices.rows + cells[:, 1]


def entries(loop: I64, start: F64, choices: KhanParams) -> I64:
    """Places (runs, N) in the loop where UAVs enter it, from draws (runs, N, 2)."""
    size = choices.columns * choices.rows
    cell = (start[..., 0] * size).astype(np.int64)
    passes = np.bincount(loop, minlength=size)
    order = np.argsort(loop, kind="stable")  # places of cell 0, of cell 1, ...
    first = np.cumsum(passes) - passes
    turn = (start[..., 1] * passes[cell]).astype(np.int64) if choices.phase == "random" else 0
    return np.asarray(order[first[cell] + turn])


def within(range_cells: float, choices: KhanParams) -> Bools:
    """Which cells (flat, flat) are in range of each other."""
    if not choices.talk:
        range_cells = -1.0
    column, row = np.divmod(np.arange(choices.columns * choices.rows), choices.rows)
    square = (column[:, None] - column) ** 2 + (row[:, None] - row) ** 2
    return np.asarray(np.sqrt(square) <= range_cells)


def reach_of(cells: I64, near: Bools, relay: bool) -> Bools:
    """Who hears whom, by their cells (runs, N): (runs, receivers, senders), nobody himself."""
    uavs = cells.shape[1]
    reach = near[cells[:, :, None], cells[:, None, :]]
    if relay:
        for _ in range(max(uavs - 1, 1).bit_length()):
            reach = np.asarray((reach[:, :, :, None] & reach[:, None, :, :]).any(axis=2))
    return np.asarray(reach & ~np.eye(uavs, dtype=np.bool_))


def turns(uavs: int, choices: KhanParams) -> list[I64]:
    """Who observes and sends together."""
    everyone = np.arange(uavs)
    return [everyone] if choices.order == "together" else [everyone[i : i + 1] for i in range(uavs)]


class Walk:
    """The target: it stays, or steps to one of the four cells beside it.

    Args:
        choices: where it begins.
        runs: how many of them.
        chance: of a step to somewhere, each time step. Steps out of the region stay.
    """

    def __init__(self, choices: KhanParams, runs: int, chance: float = 0.0) -> None:
        self.cell = np.full(runs, choices.target)
        self._chance = chance
        self._shape = (choices.columns, choices.rows)

    def step(self, draws: F64) -> None:
        """One time step, by uniform draws (runs,)."""
        if not self._chance:
            return
        way = np.minimum((draws / self._chance * 4).astype(np.int64), 4)
        columns, rows = self._shape
        ways = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (0, 0)])[way]
        column = np.clip(self.cell // rows + ways[:, 0], 0, columns - 1)
        row = np.clip(self.cell % rows + ways[:, 1], 0, rows - 1)
        self.cell = column * rows + row


def search(
    team: Team,
    choices: KhanParams,
    uavs: int,
    range_cells: float,
    seeds: I64,
    *,
    chance: float = 0.0,
    loss: float = 0.0,
) -> Fates:
    """Run searches to their end.

    Args:
        team: fresh, of as many runs as there are seeds.
        choices: the setting.
        uavs: N.
        range_cells: two UAVs at most this far apart (cell centres) are in range.
        seeds: (runs,).
        chance: of the target's moving, each step.
        loss: share of messages that a UAV in range does not get, drawn as missions draw it.
    """
    luck, loop = Luck(seeds, uavs, choices), loop_of(choices)
    entry = entries(loop, luck.start, choices)
    target = Walk(choices, len(seeds), chance)
    near = within(range_cells, choices)
    steps = np.full(len(seeds), choices.steps_most)
    named, true = np.full(len(seeds), -1), np.full(len(seeds), choices.target)
    spent = np.zeros(len(seeds))
    going, ended = np.arange(len(seeds)), np.zeros(len(seeds), np.bool_)
    for step in range(choices.steps_most):
        draws = luck.of(step)
        cells = loop[(entry[going] + step) % len(loop)]
        there = cells == target.cell[going, None]
        detected = draws[going, :uavs] < np.where(there, choices.p, choices.q)
        reach = reach_of(cells, near, choices.relay)
        if choices.forget > 0.0:
            team.fade(choices.forget)
        if loss > 0.0:
            link = np.arange(uavs)
            u = draw(seeds[going, None, None], Purpose.LOSS, link, link[:, None], step)
            reach &= u >= loss
        for who in turns(uavs, choices):
            team.observe(cells, detected, who, step * STEP_US)
            team.exchange(reach, cells, who)
        over, cell = first_above(team.probability, choices.threshold)
        over &= ~ended[going]
        if over.any():
            now = going[over]
            steps[now], named[now], true[now] = step + 1, cell[over], target.cell[now]
            spent[now] = team.bytes_sent[over]
            ended[now] = True
            left = ~ended[going]
            if not left.any():
                break
            if left.mean() < _LEFT:
                going = going[left]
                team.keep(left)
        target.step(draws[:, uavs])
    return Fates(steps, named, true, spent)


def first_above(probability: F64, threshold: float) -> tuple[Bools, I64]:
    """Which maps (runs, N, cells) hold a cell to be found, and the first such cell (runs,)."""
    size = probability.shape[-1]
    high = (probability >= threshold).reshape(len(probability), -1)
    first = high.argmax(axis=1)
    return high[np.arange(len(high)), first], first % size
