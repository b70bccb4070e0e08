"""The paper's setting, and what it leaves open as parameters.

The defaults are the readings that the printed numbers favour; see
docs/experiments/khan.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from planners.belief.fusing import Average, ModifiedOgmm, Ogmm
from planners.belief.maps import SensorModel
from planners.belief.newest import BeliefUpdate, Uncoordinated
from planners.belief.rule import MergeRule
from planners.belief.sensed_data import SensedData
from planners.grid import Grid
from planners.paths.sweeps import LOOPS
from planners.planner import param

RULES = ("UNC", "BU", "AVG", "OGMM", "MOGM", "SDS")
MERGING = RULES[1:]


@dataclass(frozen=True, slots=True)
class KhanParams:
    """Section V of the paper, and the open choices."""

    columns: int = param(10, unit="cells", doc="size of the search region", low=1, high=100)
    rows: int = param(10, unit="cells", doc="size of the search region", low=1, high=100)
    target_column: int = param(6, unit="cells", doc="where the target is, from 0", low=0)
    target_row: int = param(7, unit="cells", doc="where the target is, from 0", low=0)
    p: float = param(0.9, unit="1", doc="detection probability", low=0.001, high=0.999)
    q: float = param(0.2, unit="1", doc="false alarm probability", low=0.001, high=0.999)
    threshold: float = param(0.99, unit="1", doc="B: the search ends", low=0.501, high=0.999)
    v: float = param(0.7, unit="1", doc="weight of the average, Eq. (7)", low=0.0, high=1.0)
    sweep: str = param(
        "columns-and-rows",
        unit="-",
        doc="the loop of cells that every UAV follows",
        choices=tuple(LOOPS),
    )
    starts: str = param(
        "every-run", unit="-", doc="start cells are drawn", choices=("every-run", "once")
    )
    starts_seed: int = param(0, unit="1", doc="of start cells that are drawn once", low=0)
    phase: str = param(
        "first",
        unit="-",
        doc="where a UAV enters a loop that passes its start cell more than once",
        choices=("first", "random"),
    )
    order: str = param(
        "together",
        unit="-",
        doc="all observe, then all exchange; or one UAV after the other does both",
        choices=("together", "in-turn"),
    )
    exchange: str = param(
        "current",
        unit="-",
        doc="values sent: of the sender's cell, of every cell just observed by somebody "
        "in range, or the whole map",
        choices=("current", "contested", "whole"),
    )
    observer: str = param(
        "keeps",
        unit="-",
        doc="who holds the newest observation keeps its value, or merges older ones in",
        choices=("keeps", "merges"),
    )
    counted: str = param(
        "distinct",
        unit="-",
        doc="n of Eqs (3), (5), (8): one value a time stamp, or every UAV in range",
        choices=("distinct", "all"),
    )
    untouched: str = param(
        "averaged",
        unit="-",
        doc="MOGM: the 0.5 of a UAV that never saw the cell enters Eq. (8), or is overwritten",
        choices=("averaged", "overwritten"),
    )
    history: str = param(
        "whole",
        unit="-",
        doc="SDS: all readings known are sent, or the current one alone",
        choices=("whole", "current"),
    )
    relay: bool = param(False, unit="-", doc="UAVs pass on what they hear, within one step")
    talk: bool = param(True, unit="-", doc="false: no communication, whatever the range")
    forget: float = param(
        0.0,
        unit="1",
        doc="share of its log odds that a cell loses each step, for targets that move",
        low=0.0,
        high=0.999,
    )
    steps_most: int = param(3000, unit="steps", doc="a run ends then", low=1, high=100000)

    def __post_init__(self) -> None:
        if self.target_column >= self.columns or self.target_row >= self.rows:
            raise ValueError("the target lies outside the region")
        if not self.q < self.p:
            raise ValueError(f"q must be below p = {self.p:g}, not {self.q:g}")

    @property
    def grid(self) -> Grid:
        """Cells of one metre."""
        return Grid(0.0, 0.0, 1.0, self.columns, self.rows)

    @property
    def target(self) -> int:
        """The target's flat cell."""
        return self.target_column * self.rows + self.target_row

    @property
    def sensor(self) -> SensorModel:
        """The UAVs' surveillance sensor."""
        return SensorModel(self.p, self.q)


@dataclass(frozen=True, slots=True)
class Scale:
    """The region for vehicles."""

    cell_m: float
    speed_m_s: float
    flight_s: float  # a search is given up then

    @property
    def step_s(self) -> float:
        """Time (s) from cell to cell: a time step of the paper."""
        return self.cell_m / self.speed_m_s

    def step(self, t_s: float) -> int:
        """Time step, from 1, at a time (s): UAVs start in the middle of their first cell."""
        return 1 + int(t_s / self.step_s + 0.5)


def rules(choices: KhanParams) -> Mapping[str, MergeRule]:
    """The paper's strategies by its abbreviations, under these choices."""
    keeps, distinct = choices.observer == "keeps", choices.counted == "distinct"
    return {
        "UNC": Uncoordinated(),
        "BU": BeliefUpdate(),
        "AVG": Average(keeps, distinct),
        "OGMM": Ogmm(keeps, distinct),
        "MOGM": ModifiedOgmm(
            keeps, distinct, v=choices.v, untouched_counts=choices.untouched == "averaged"
        ),
        "SDS": SensedData(),
    }
