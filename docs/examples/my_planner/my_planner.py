"""Fly to the nearest cell that nobody has seen and that no neighbour is nearer to."""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from planners.planner import PlannerKind, param
from planners.types import Goal, GoTo, Scenario, View


@dataclass(frozen=True, slots=True)
class Params:
    """Filled from the mission file's [parameters]."""

    speed_m_s: float = param(8.0, unit="m/s", doc="speed between cells")
    forget_s: float = param(5.0, unit="s", doc="neighbours not heard for longer do not count")


@dataclass(frozen=True, slots=True)
class Memory:
    """The cell that the agent is on its way to; None before the first decision."""

    cell: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class NearestUnseen:
    """The planner: bound to a mission once, then asked by every agent at every tick."""

    scenario: Scenario
    params: Params

    def init(self, view: View) -> Memory:
        return Memory()

    def plan(self, view: View, memory: Memory, rng: Generator) -> tuple[Goal, Memory]:
        cell = memory.cell
        if cell is None or view.seen[cell]:
            cell = self._choose(view, rng)
        x, y = self.scenario.grid.centre_of(cell)
        height = self.scenario.starts[self.scenario.index(view.agent), 2]
        speed = min(self.params.speed_m_s, self.scenario.limits.speed_m_s)
        setpoint = GoTo(np.array((x, y, height)), speed_m_s=speed)
        return Goal(setpoint, note=f"to cell {cell[0]}, {cell[1]}"), Memory(cell)

    def _choose(self, view: View, rng: Generator) -> tuple[int, int]:
        unseen = np.argwhere(~view.seen)
        if len(unseen) == 0:  # all done: look once more anywhere
            unseen = rng.integers(0, self.scenario.grid.shape, (1, 2))
        centres = self.scenario.grid.centre_of(unseen)
        own = np.linalg.norm(centres - view.position[:2], axis=1)
        heard = view.neighbours.position[view.neighbours.age_s <= self.params.forget_s, :2]
        theirs = np.linalg.norm(centres[:, None] - heard, axis=2)
        mine = own <= theirs.min(axis=1, initial=np.inf)
        best = np.argmin(np.where(mine, own, own + 1e6) if mine.any() else own)
        return int(unseen[best, 0]), int(unseen[best, 1])


def bind(scenario: Scenario, params: Params) -> NearestUnseen:
    """Called once a mission."""
    return NearestUnseen(scenario, params)


KIND = PlannerKind("nearest-unseen", "To the nearest cell nobody has seen", Params, bind)
