"""To the nearest cell that nobody has seen; when all are seen, to where a target may be."""

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
        grid = self.scenario.grid
        column, row = grid.cell_of(grid.clip(view.position[:2]))
        here = (int(column), int(row))
        cell = memory.cell
        if cell is None or cell == here or (view.seen[cell] and not view.seen.all()):
            cell = self._doubtful(view, here, rng) if view.seen.all() else self._nearest(view)
        x, y = grid.centre_of(cell)
        height = self.scenario.starts[self.scenario.index(view.agent), 2]
        speed = min(self.params.speed_m_s, self.scenario.limits.speed_m_s)
        setpoint = GoTo(np.array((x, y, height)), speed_m_s=speed)
        return Goal(setpoint, note=f"to cell {cell[0]}, {cell[1]}"), Memory(cell)

    def _nearest(self, view: View) -> tuple[int, int]:
        """The nearest unseen cell; one that a neighbour is nearer to only if there is no other."""
        unseen = np.argwhere(~view.seen)
        centres = self.scenario.grid.centre_of(unseen)
        own = np.linalg.norm(centres - view.position[:2], axis=1)
        heard = view.neighbours.position[view.neighbours.age_s <= self.params.forget_s, :2]
        theirs = np.linalg.norm(centres[:, None] - heard, axis=2)
        mine = own <= theirs.min(axis=1, initial=np.inf)
        best = np.argmin(np.where(mine, own, own + 1e6))
        return int(unseen[best, 0]), int(unseen[best, 1])

    def _doubtful(self, view: View, here: tuple[int, int], rng: Generator) -> tuple[int, int]:
        """Any other cell, the likelier the likelier a target there is, but for declared ones."""
        weight = np.where(view.belief < self.scenario.detection_threshold, view.belief, 0.0)
        weight[here] = 0.0
        if not weight.any():
            return here
        flat = rng.choice(weight.size, p=weight.ravel() / weight.sum())
        return int(flat // weight.shape[1]), int(flat % weight.shape[1])


def bind(scenario: Scenario, params: Params) -> NearestUnseen:
    """Called once a mission."""
    return NearestUnseen(scenario, params)


KIND = PlannerKind(
    "nearest-unseen", "To the nearest unseen cell, then where a target may be", Params, bind
)
