"""Parameters of the planners by pheromones: Shao 2020, Tables 1 and 2, and what is open.

| symbol | name |
| --- | --- |
| SD, sensorLD | ``sensor``, ``leader_sensor`` |
| lambda_Ta, lambda_Th, lambda_Tr | ``target_weight``, ``obstacle_weight``, ``path_weight`` |
| alpha, beta | ``alpha``, ``beta`` |
| rho, r | ``length``, ``radius`` |
| epsilon, h, c_1, c_2 | ``epsilon``, ``h``, ``c1``, ``c2`` |

E, G, d, sigma_0, sigma_min, D_0, Q and T belong to who keeps the maps: the mission's
``[pheromones]``.
"""

from __future__ import annotations

from dataclasses import dataclass

from planners.pheromone.detect import DetectRule
from planners.pheromone.follow import FollowLaw
from planners.pheromone.law import Weights
from planners.planner import param


@dataclass(frozen=True, slots=True)
class PheromoneParams:
    """Table 1's other half: what a UAV decides by in detection and revisit."""

    sensor: int = param(4, unit="cells", doc="SD, sensor radius", low=1, high=12)
    target_weight: float = param(1.0, unit="1", doc="lambda_Ta", low=0.0, high=1.0)
    obstacle_weight: float = param(-0.3, unit="1", doc="lambda_Th", low=-1.0, high=0.0)
    path_weight: float = param(0.3, unit="1", doc="lambda_Tr", low=0.0, high=1.0)
    alpha: float = param(1.0, unit="1", doc="weight of pheromones, Eq. (9)", low=0.0, high=10.0)
    beta: float = param(1.0, unit="1", doc="weight of costs, Eq. (9)", low=0.0, high=10.0)
    random_share: float = param(
        0.2, unit="1", doc="chance of being in the random group", low=0.0, high=1.0
    )
    period: int = param(
        500, unit="ticks", doc="a target visited is left alone so long, should nobody keep maps",
        low=1,
    )  # fmt: skip
    speed_m_s: float = param(8.0, unit="m/s", doc="along the lattice", low=0.1)
    capture: float = param(
        0.35, unit="cells", doc="a cell is reached this near to its centre", low=0.05, high=0.5
    )
    clearance_m: float = param(
        10.0, unit="m", doc="a cell is closed when its centre is this near to a column", low=0.0
    )

    @property
    def weights(self) -> Weights:
        """Of Eq. (9)."""
        return Weights(self.target_weight, self.obstacle_weight, self.path_weight)

    @property
    def rule(self) -> DetectRule:
        """Of Eq. (9)."""
        return DetectRule(self.alpha, self.beta, self.random_share)


@dataclass(frozen=True, slots=True)
class ScenarioParams(PheromoneParams):
    """Table 2 too: how leader and followers travel."""

    region: float = param(
        0.5,
        unit="1",
        doc="share of the area's sides that the target region has, in its north-east",
        low=0.0,
        high=1.0,
    )
    leader_sensor: int = param(5, unit="cells", doc="sensorLD of the leader", low=1, high=12)
    length: float = param(2.0, unit="cells", doc="rho, step of the leader", low=0.5, high=4.0)
    sense: str = param(
        "log",
        unit="-",
        doc="the leader senses target pheromone's logarithm, or the field itself",
        choices=("log", "field"),
    )
    scale: float = param(0.1, unit="1", doc="of target pheromone as the leader senses it", low=0.0)
    radius: float = param(5.0, unit="cells", doc="r, within which followers keep apart", low=0.1)
    epsilon: float = param(0.1, unit="1", doc="of the sigma norm", low=0.001, high=0.999)
    h: float = param(0.5, unit="1", doc="of the bump function", low=0.0, high=0.999)
    c1: float = param(0.6, unit="1", doc="pull to the leader", low=0.0, high=10.0)
    c2: float = param(0.4, unit="1", doc="to the leader's velocity", low=0.0, high=10.0)
    form: str = param(
        "working",
        unit="-",
        doc="of the followers' rule: as it works, or as printed",
        choices=("working", "printed"),
    )
    leader_share: float = param(
        0.6, unit="1", doc="of the speed at which the leader travels", low=0.05, high=1.0
    )
    forget_s: float = param(
        5.0, unit="s", doc="others not heard for longer are gone; the next one leads", low=0.1
    )

    @property
    def law(self) -> FollowLaw:
        """Of the followers."""
        return FollowLaw(self.radius, self.epsilon, self.h, self.c1, self.c2, self.form)
