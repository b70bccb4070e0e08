"""The mower: lanes swept back and forth.

Liu et al. 2022, "Emergent search of UAV swarm guided by the target probability
map", section 5.1.3, Eq. (14):

    P_i(t+1) = P_i(t) + b l dt                          (14)

with b reversed where the agent meets the boundary.

| symbol | name |
| --- | --- |
| P_i | ``position`` |
| b | direction to the lane's end flown to, ``loop.towards`` |
| l | ``speed_m_s`` (10 m a cycle of 1 s) |
| dt | ``Scenario.tick_s`` |

Lanes are allotted by the agent's place in the team: neighbouring lanes in equal
shares. With fewer agents than lanes each sweeps its share boustrophedon and
back; with more, those on one lane split it. Each ferries to its lane's start
first.

DEVIATION: agents turn in the middle of the end cells (``inset_cells`` 0.5), not
at the boundary, which vehicles with inertia would cross; 0 is the paper's.
The printed starts cannot sweep 100 cells by Eq. (14); the ferry takes care of that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from planners.grid import Grid
from planners.paths import loop
from planners.paths.sweeps import corners, there_and_back
from planners.planner import PlannerKind, param
from planners.search import flight
from planners.types import F64, I64, Goal, Scenario, View


@dataclass(frozen=True, slots=True)
class MowerParams:
    """Parameters of the mower."""

    along: str = param("north", unit="-", doc="direction of the lanes", choices=("north", "east"))
    inset_cells: float = param(
        0.5, unit="cells", doc="lanes end this far inside the area", low=0.0, high=0.5
    )
    speed_m_s: float = param(10.0, unit="m/s", doc="speed, l of Eq. (14)", low=0.1)
    reach_m: float = param(10.0, unit="m", doc="a lane's end is reached this close", low=0.001)


@dataclass(frozen=True, slots=True)
class LoopMemory:
    """Number of the point of the own loop that is flown to."""

    leg: int


def share(grid: Grid, index: int, team: int, along: str) -> tuple[range, range]:
    """Lanes of an agent, and the cells of each lane that are its own.

    Args:
        grid: the area.
        index: the agent's place in the team, from 0.
        team: number of agents.
        along: "north" (lanes are columns) or "east" (lanes are rows).
    """
    lanes, cells = (grid.columns, grid.rows) if along == "north" else (grid.rows, grid.columns)
    first = index * lanes // team
    mates = [i for i in range(team) if i * lanes // team == first]
    if len(mates) == 1:
        return range(first, max(first + 1, (index + 1) * lanes // team)), range(cells)
    place, count = mates.index(index), len(mates)
    low = min(place * cells // count, cells - 1)
    return range(first, first + 1), range(low, max(low + 1, (place + 1) * cells // count))


def lanes_loop(grid: Grid, index: int, team: int, params: MowerParams) -> F64:
    """Corners (m, 2) in m of the loop that one agent flies for ever."""
    lanes, cells = share(grid, index, team, params.along)
    low, high = cells[0] + params.inset_cells, cells[-1] + 1 - params.inset_cells
    ends = [
        (lane + 0.5, end)
        for turn, lane in enumerate(lanes)
        for end in ((low, high) if turn % 2 == 0 else (high, low))
    ]
    points = np.array(ends) if params.along == "north" else np.array(ends)[:, ::-1]
    closed = corners(there_and_back(points))
    return np.asarray(closed * grid.cell_m + (grid.west_m, grid.south_m))


def step(
    position: F64, points: F64, count: I64, leg: I64, params: MowerParams, step_s: float
) -> tuple[F64, I64]:
    """One cycle of every agent of every run, Eq. (14).

    Args:
        position: (..., 2) m.
        points: (..., m, 2) m, the agents' loops, padded.
        count: (...) points of each loop.
        leg: (...) numbers of the points flown to.
        params: of the planner.
        step_s: dt.

    Returns:
        Velocities (..., 2) m/s and the numbers (...) of the points flown to.
    """
    leg = loop.advance(position, points, count, leg, params.reach_m)
    goal = loop.target(points, leg)
    return loop.towards(position, goal, params.speed_m_s, step_s), leg  # Eq. (14)


@dataclass(frozen=True, slots=True, eq=False)
class LoopFlight:
    """A planner that flies each agent round its own loop."""

    scenario: Scenario
    loops: tuple[F64, ...]  # (m, 2) m, in the order of the team
    speed_m_s: float
    reach_m: float

    def init(self, view: View) -> LoopMemory:
        return LoopMemory(0)

    def plan(self, view: View, memory: LoopMemory, rng: Generator) -> tuple[Goal, LoopMemory]:
        points = self.loops[self.scenario.index(view.agent)]
        count, leg = np.asarray(len(points)), np.asarray(memory.leg)
        leg = loop.advance(view.position[:2], points, count, leg, self.reach_m)
        goal = loop.target(points, leg)
        setpoint = flight.level_point(self.scenario, view, goal, self.speed_m_s)
        note = f"to point {int(leg) + 1} of {len(points)}"
        return Goal(setpoint, note=note), LoopMemory(int(leg))


def bind(scenario: Scenario, params: MowerParams) -> LoopFlight:
    """The mower for one mission."""
    team = len(scenario.team)
    loops = tuple(lanes_loop(scenario.grid, index, team, params) for index in range(team))
    return LoopFlight(scenario, loops, params.speed_m_s, params.reach_m)


MOWER = PlannerKind(
    "mower",
    "Lanes swept back and forth, allotted to the team (Liu 2022, Eq. 14)",
    MowerParams,
    bind,
)
