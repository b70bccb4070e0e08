"""The setting of Liu 2022, section 5, and every reading of it that is open.

One map that all share, agents that move in turn, readings that are never wrong
(Algorithm 1). The derivations are in docs/experiments/liu.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.belief.merge import SensorModel
from planners.grid import Grid
from planners.planner import param
from planners.search import readings
from planners.types import F64, Limits, Scenario

GRID = Grid(0.0, 0.0, 100.0, 10, 10)
TARGETS = ((4, 5), (4, 7), (7, 5))  # cells of (400, 500), (400, 700), (700, 500): floor(x / 100)
HIDDEN = (3, 2)  # cell of (300, 200), Fig. 27b
METHODS = ("random", "mower", "boids", "boids-guided", "esustpm")
TICK_S = 1.0  # a cycle: speeds in m/s are metres a cycle
INTERVAL_S = 0.01  # the simulation interval that section 5 gives, for speeds without a limit
RUNS_FLOWN = {"mavlink": 5}  # a case, where a run takes seconds
_LIMITS = Limits(speed_m_s=1e6)  # point masses: only the method's own speed limit holds

Cell = tuple[int, int]


@dataclass(frozen=True, slots=True)
class LiuParams:
    """The paper's numbers, and the readings where it is silent."""

    methods: str = param(
        "random,mower,boids,boids-guided,esustpm", unit="-", doc="methods, by commas"
    )
    cycles: int = param(200, unit="1", doc="cycles simulated", low=1, high=100_000)
    p_d: float = param(0.3, unit="1", doc="detection probability P_d", low=0.001, high=0.999)
    p_f: float = param(0.1, unit="1", doc="false alarm probability P_f", low=0.001, high=0.999)
    update: str = param(
        "liu",
        unit="-",
        doc="Eqs. (4) and (5) as printed, or Bayes' rule for both",
        choices=("liu", "bayes"),
    )
    update_on: str = param(
        "entry",
        unit="-",
        doc="the map is updated on entering a cell, or every cycle",
        choices=("entry", "cycle"),
    )
    prior: float = param(0.5, unit="1", doc="P of every cell at the start", low=0.001, high=0.999)
    threshold: float = param(0.95, unit="1", doc="theta: found at or above", low=0.5, high=0.9999)
    start_cells: str = param(
        "visited",
        unit="-",
        doc="at cycle 0 the start cells count as visited, as visited and read, or as neither",
        choices=("visited", "read", "unvisited"),
    )
    turns: str = param(
        "in-turn",
        unit="-",
        doc="agents move one after the other, or all on what was known a cycle ago",
        choices=("in-turn", "together"),
    )
    stop: str = param(
        "never",
        unit="-",
        doc="a run ends when all targets are found, the uncertainty reaches its goal, either or "
        "both (Algorithm 1, and the text of section 4)",
        choices=("never", "targets", "uncertainty", "either", "both"),
    )
    uncertainty_goal: float = param(40.0, unit="bit", doc="goal of the stop rule", low=0.0)
    speed_m: float = param(10.0, unit="m", doc="greatest way a cycle, S and l", low=0.1)
    speed_reading: str = param(
        "component",
        unit="-",
        doc="ESUSTPM's maximum velocity holds for each component, for the norm, or there is "
        "none and a cycle lasts 10 ms",
        choices=("component", "norm", "none"),
    )
    guide_gain: float = param(7000.0, unit="1", doc="beta_4, a constant", low=0.0)
    keep: str = readings.keep("entered")
    ties: str = readings.ties()
    guide_point: str = readings.guide_point()
    guide_law: str = param(
        "constant",
        unit="-",
        doc="beta_4 is guide_gain, or Eq. (9) of the distance, towards the cell or away from it",
        choices=("constant", "towards", "away"),
    )
    escape_ratio: float = param(
        0.0, unit="1", doc="our escape from searched cells; 0: none", low=0.0, high=1.0
    )
    neighbours: int = param(3, unit="1", doc="closest neighbours that count", low=0)
    heading_noise_rad: float = param(
        0.1, unit="rad", doc="noise on the heading: the source of randomness", low=0.0
    )
    boundary: str = readings.boundary()
    mower_starts: str = param(
        "lanes",
        unit="-",
        doc="the mower starts at its lanes' ends, or ferries there from the printed starts",
        choices=("lanes", "printed"),
    )
    boids_speed_m: float = param(10.0, unit="m", doc="boids: constant way a cycle", low=0.1)
    safe_m: float = param(120.0, unit="m", doc="boids: safe distance", low=0.001)
    radius_m: float = param(300.0, unit="m", doc="boids: radius of the flock", low=0.001)
    separation: float = param(1.5, unit="1", doc="boids: collision avoidance", low=0.0)
    alignment: float = param(0.5, unit="1", doc="boids: velocity matching", low=0.0)
    cohesion: float = param(0.3, unit="1", doc="boids: flock centering", low=0.0)
    guide: float = param(1.0, unit="1", doc="boids: weight of the guide cell", low=0.0)
    random_safe_m: float = param(
        20.0, unit="m", doc="random: distance kept from neighbours and edges", low=0.0
    )

    def __post_init__(self) -> None:
        unknown = [name for name in self.chosen if name not in METHODS]
        if unknown:
            raise ValueError(f"unknown method {unknown[0]!r} (known: {', '.join(METHODS)})")
        SensorModel(self.p_d, self.p_f, self.update)

    @property
    def chosen(self) -> tuple[str, ...]:
        """The methods, in their order."""
        return tuple(part.strip() for part in self.methods.split(","))

    @property
    def sensor(self) -> SensorModel:
        """What a reading does to the map."""
        return SensorModel(self.p_d, self.p_f, self.update)


def starts() -> F64:
    """The printed starts (10, 2) m: two columns in the lower left corner."""
    return np.array([(100.0 * (1 + i // 5), 100.0 * (1 + i % 5)) for i in range(10)])


def scenario(params: LiuParams, places: F64, tick_s: float = TICK_S) -> Scenario:
    """The search as planners know it; ``places`` (n, 2) m are the starts."""
    team = tuple(range(1, len(places) + 1))
    height = np.full((len(places), 1), 50.0)
    return Scenario(
        GRID, team, np.concatenate((places, height), axis=1), tick_s, _LIMITS, params.threshold
    )
