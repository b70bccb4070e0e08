"""Fixed sweeps of the whole area, every agent the same loop.

Khan, Yanmaz and Rinner 2014, "Information merging in multi-UAV cooperative
search", section III: "predefined paths for the UAVs to move, i.e., a sweep
mobility model". The paper does not say which sweep; ``pattern`` offers the
readings (``planners.paths.sweeps``). Agents enter the loop at even distances
along it, or where it is nearest to their start.

| symbol | name |
| --- | --- |
| c_{i,t} | the cell of ``View.position`` |

DEVIATION: the paper steps from cell to cell; here the loop's corners are flown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.paths.sweeps import LOOPS, Cells, corners
from planners.planner import PlannerKind, param
from planners.search.mower import LoopFlight
from planners.types import F64, Scenario


@dataclass(frozen=True, slots=True)
class SweepParams:
    """Parameters of the fixed sweep."""

    pattern: str = param(
        "closed-tour", unit="-", doc="the loop that is flown", choices=tuple(LOOPS)
    )
    entry: str = param(
        "even",
        unit="-",
        doc="where agents enter the loop: at even distances, or nearest to their start",
        choices=("even", "nearest"),
    )
    speed_m_s: float = param(10.0, unit="m/s", doc="speed", low=0.1)
    reach_m: float = param(10.0, unit="m", doc="a corner is reached this close", low=0.001)


def entry_of(cells: Cells, scenario: Scenario, index: int, params: SweepParams) -> int:
    """Number of the loop's cell (k, 2) at which an agent enters it."""
    if params.entry == "even":
        return index * len(cells) // len(scenario.team)
    offset = scenario.grid.centre_of(cells) - scenario.starts[index, :2]
    return int(np.hypot(offset[:, 0], offset[:, 1]).argmin())


def bind(scenario: Scenario, params: SweepParams) -> LoopFlight:
    """The sweep for one mission."""
    grid = scenario.grid
    cells = LOOPS[params.pattern](grid.columns, grid.rows)

    def own(index: int) -> F64:
        entered = np.roll(cells, -entry_of(cells, scenario, index, params), axis=0)
        return corners(grid.centre_of(entered))

    loops = tuple(own(index) for index in range(len(scenario.team)))
    return LoopFlight(scenario, loops, params.speed_m_s, params.reach_m)


SWEEP = PlannerKind(
    "sweep", "Fixed sweeps of the whole area (Khan 2014, section III)", SweepParams, bind
)
