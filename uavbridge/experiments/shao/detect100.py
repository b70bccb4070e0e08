"""Shao 2020, Figs 4(b), 5(b) and 6(b): twenty targets on 100 x 100 cells."""

from __future__ import annotations

from dataclasses import dataclass

from planners.planner import param
from uavbridge.experiments.shao import detect
from uavbridge.experiments.shao.detect import DetectParams


@dataclass(frozen=True, slots=True)
class Detect100Params(DetectParams):
    """Table 1's second column."""

    size: int = param(100, unit="cells", doc="M = N, side of the map", low=5, high=1000)
    targets: int = param(20, unit="1", doc="TarN, targets on the map", low=1, high=200)
    period: int = param(800, unit="steps", doc="T, revisit period", low=1)
    steps: int = param(10_000, unit="steps", doc="N_c, steps of a run", low=1, high=100_000)
    uavs: str = param("4,8,16,32", unit="-", doc="numbers of UAVs, by commas; not given")
    swept_uavs: int = param(16, unit="1", doc="UAVs of the swept rows", low=1, high=500)
    random_shares: str = param("0,0.5,1", unit="-", doc="random shares swept, by commas")
    recoveries: str = param("0.0005,0.005", unit="-", doc="recoveries swept, by commas")


EXPERIMENT = detect.experiment(
    "shao-detect-100", 100, Detect100Params, __file__, tuple(range(0, 10_001, 100))
)
