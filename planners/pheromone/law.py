"""The laws of the three pheromones: Shao 2020, Table 1, and the readings that are open.

| symbol | name |
| --- | --- |
| E_tau, G_tau, d_tau | ``evaporation``, ``diffusion``, ``deposit`` of ``FieldLaw.target`` |
| E_eps, G_eps, d_eps | the same of ``FieldLaw.obstacle`` |
| sigma_0, sigma_min, D_0, Q | ``initial``, ``least``, ``reach``, ``attenuation`` of ``PathLaw`` |
| lambda_Ta, lambda_Th, lambda_Tr | ``Weights`` |
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class SpreadLaw:
    """How a pheromone that evaporates and spreads changes in a step, Eqs. (1)-(4).

    Raises:
        ValueError: evaporation or diffusion is outside [0, 1].
    """

    evaporation: float = 0.2
    diffusion: float = 0.2
    deposit: float = 1.0  # by one source in one step

    def __post_init__(self) -> None:
        for name in ("evaporation", "diffusion"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} must be in [0, 1], not {getattr(self, name)}")


@dataclass(frozen=True, slots=True)
class PathLaw:
    """How path pheromone is taken away where UAVs are, Eqs. (5)-(8).

    DEVIATION: Eq. (7) prints exp(-(Q/D)^2 / 2), which grows with the distance, while the text
    has neighbours decay more slowly than the own cell, and a range of influence. The reading
    "falling" is exp(-(D/Q)^2 / 2); "printed" is there too. Both take 0.9 sigma_0 at D = 0.

    DEVIATION: nothing printed ever raises sigma, so that the upper clamp of Eq. (8) never acts,
    while the text wants no repeated visit "in a short time". ``recovery`` is added in every
    step; 0 is as printed.
    """

    initial: float = 2.0
    least: float = 0.1
    reach: float = 4.0  # cells
    attenuation: float = 1.0
    recovery: float = 0.0  # a step
    wear: str = "falling"  # or "printed"


@dataclass(frozen=True, slots=True)
class Weights:
    """What each pheromone counts in a decision, Eq. (9); with sign their sum is 1."""

    target: float = 1.0
    obstacle: float = -0.3
    path: float = 0.3


@dataclass(frozen=True, slots=True)
class FieldLaw:
    """The three laws together."""

    target: SpreadLaw = field(default_factory=SpreadLaw)
    obstacle: SpreadLaw = field(default_factory=SpreadLaw)
    path: PathLaw = field(default_factory=PathLaw)
