"""ESUSTPM: emergent search of a UAV swarm guided by the target probability map.

Liu, Yao, Zhu, Zuo and Zhou 2022, "Emergent Search of UAV Swarm Guided by the
Target Probability Map", Appl. Sci. 12, 5086, Eqs. (3)-(11) and Algorithm 1.

    mvel = 1/4 sum_{i=1..4} F_i / norm(F_i) beta_i      (6)
    P(t+1) = P(t) + mvel dt                             (10), (11)

F_1..F_3 belong to the three closest neighbours, with beta by Eqs. (7)-(9)
(``planners.flocking.pair``), F_4 to the guide cell (``planners.search.guidance``).
The map itself, Eqs. (3)-(5), is kept by the agent (``planners.belief``).

| symbol | name |
| --- | --- |
| P_i | ``position`` |
| P_mn | ``belief`` |
| mvel_i | the value of ``velocity`` |
| F_1..F_3, beta_1..beta_3 | ``pair.pull`` |
| F_4 | ``guidance.direction`` |
| beta_4 | ``guide_gain`` |
| k_i, t_i, c_i, delta_i, delta'_i | ``k``, ``t``, ``c_m``, ``delta_m``, ``delta_g_m`` |
| maximum velocity | ``speed_m_s`` |
| theta | ``Scenario.detection_threshold`` |
| dt | ``Scenario.tick_s`` |

DEVIATION: beta_4 is a constant (``guide_law``). Table 1 gives four values of each constant, so
Eq. (9) would apply to the guide cell too, but then guidance hardly works, and
the text calls F_4 a direction only.

DEVIATION: a heading noise. The paper's statistics need a source of randomness
and name none. ``DEVIATION`` marks in ``pair`` and ``guidance`` apply too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from planners.flocking.pair import PairLaw, beta, pull
from planners.grid import Grid
from planners.planner import PlannerKind, param
from planners.search import flight, guidance, readings
from planners.search.guidance import Guidance
from planners.types import F64, I64, Bools, Goal, Scenario, View


@dataclass(frozen=True, slots=True)
class EsustpmParams:
    """Parameters of ESUSTPM; the constants of the pair function from Table 1."""

    k: float = param(-80.0, unit="1/m", doc="factor of a(d), Eq. (8); negative keeps distance c")
    t: float = param(5.0, unit="1", doc="factor of g(d), Eq. (7)", low=0.0)
    c_m: float = param(120.0, unit="m", doc="distance that neighbours keep", low=0.0)
    delta_m: float = param(40.0, unit="m", doc="range of a(d), Eq. (8)", low=0.001)
    delta_g_m: float = param(10.0, unit="m", doc="range of g(d), Eq. (7)", low=0.001)
    neighbours: int = param(3, unit="1", doc="closest neighbours that count", low=0)
    guide_gain: float = param(
        7000.0, unit="1", doc="beta_4, the pull of the guide cell; max |beta| is 6860", low=0.0
    )
    keep: str = readings.keep("best")
    escape_ratio: float = readings.escape_ratio(0.5)
    ties: str = readings.ties()
    guide_point: str = readings.guide_point()
    guide_law: str = param(
        "constant",
        unit="-",
        doc="beta_4 is guide_gain, or Eq. (9) of the distance, towards the cell or away from it",
        choices=("constant", "towards", "away"),
    )
    speed_m_s: float = param(10.0, unit="m/s", doc="maximum velocity", low=0.1)
    speed_reading: str = param(
        "norm",
        unit="-",
        doc="maximum of the norm, of each component, or none; limits hold anyway",
        choices=("norm", "component", "none"),
    )
    heading_noise_rad: float = readings.heading_noise_rad()
    boundary: str = readings.boundary()
    margin_m: float = readings.margin_m()
    forget_s: float = readings.forget_s()


@dataclass(frozen=True, slots=True)
class EsustpmMemory:
    """The guide cell (flat, -1: none) and the heading last flown."""

    guide: int
    heading_rad: float


def velocity(
    position: F64,
    others: F64,
    present: Bools,
    towards_guide: F64,
    law: PairLaw,
    guide_gain: F64,
    count: int,
) -> F64:
    """Objective velocity before the speed limit, Eq. (6).

    Args:
        position: (..., 2) m.
        others: (..., k, 2) m, the neighbours.
        present: (..., k) which of them are heard.
        towards_guide: (..., 2) unit vectors to the guide cells, or zero.
        law: Eqs. (7)-(9).
        guide_gain: (...) beta_4.
        count: neighbours that count.

    Returns:
        (..., 2), in the unit of beta, to be limited.
    """
    flock = pull(position, others, present, law, count)
    return np.asarray((flock + towards_guide * guide_gain[..., None]) / 4.0)  # Eq. (6)


@dataclass(frozen=True, slots=True)
class Rules:
    """Params as the kernels want them."""

    law: PairLaw
    guidance: Guidance

    @staticmethod
    def of(params: EsustpmParams, threshold: float) -> Rules:
        law = PairLaw(params.k, params.t, params.c_m, params.delta_m, params.delta_g_m)
        readings = (params.keep, params.escape_ratio, params.ties, params.guide_point)
        return Rules(law, Guidance(threshold, *readings))


def step(
    position: F64,
    heading: F64,
    others: F64,
    present: Bools,
    belief: F64,
    guide: I64,
    noise: F64,
    scenario: Scenario,
    params: EsustpmParams,
    rules: Rules,
) -> tuple[F64, I64]:
    """One decision of every agent of every run.

    Args:
        position: (..., 2) m.
        heading: (...) rad, flown when neither neighbour nor guide cell says anything.
        others: (..., k, 2) m.
        present: (..., k) which of them are heard.
        belief: (..., columns, rows), broadcast against the agents' leading axes.
        guide: (...) flat guide cells so far, -1 for none.
        noise: (...) standard normal draws.
        scenario: the search.
        params: of the planner.
        rules: ``Rules.of(params, threshold)``.

    Returns:
        Velocities (..., 2) m/s and the guide cells (...).
    """
    grid = scenario.grid
    guide = guidance.choose(belief, position, guide, grid, rules.guidance, others, present)
    towards = guidance.direction(position, guide, grid, rules.guidance.point)
    gain = _guide_gain(position, guide, grid, params, rules)
    wish = velocity(position, others, present, towards, rules.law, gain, params.neighbours)
    silent = (wish == 0.0).all(axis=-1)[..., None]
    onwards = np.stack((np.cos(heading), np.sin(heading)), axis=-1) * params.speed_m_s
    wish = flight.limit(np.where(silent, onwards, wish), params.speed_m_s, params.speed_reading)
    wish = flight.turned(wish, noise * params.heading_noise_rad)
    inside = flight.turn_back(
        position, wish, grid, scenario.tick_s, params.margin_m, params.boundary
    )
    return inside, guide


def _guide_gain(position: F64, guide: I64, grid: Grid, params: EsustpmParams, rules: Rules) -> F64:
    """beta_4 (...) along the direction to the guide cells (...)."""
    if params.guide_law == "constant":
        return np.asarray(params.guide_gain)
    offset = guidance.offset_to(position, guide, grid, rules.guidance.point)
    strength = beta(np.hypot(offset[..., 0], offset[..., 1]), rules.law)
    return strength if params.guide_law == "towards" else -strength


@dataclass(frozen=True, slots=True)
class Esustpm:
    """The planner: one agent's row of ``step``."""

    scenario: Scenario
    params: EsustpmParams
    rules: Rules

    def init(self, view: View) -> EsustpmMemory:
        return EsustpmMemory(-1, float(view.heading_rad))

    def plan(self, view: View, memory: EsustpmMemory, rng: Generator) -> tuple[Goal, EsustpmMemory]:
        others, _ = flight.neighbours(view, self.params.forget_s)
        flown, guide = step(
            view.position[:2],
            np.asarray(memory.heading_rad),
            others,
            flight.everyone(others),
            view.belief,
            np.asarray(memory.guide),
            np.asarray(rng.standard_normal()),
            self.scenario,
            self.params,
            self.rules,
        )
        heading = float(np.arctan2(flown[1], flown[0]))
        setpoint = flight.level_velocity(self.scenario, view, flown)
        cell = divmod(int(guide), self.scenario.grid.rows)
        note = f"to cell {cell[0]},{cell[1]}" if guide >= 0 else "nothing draws"
        return Goal(setpoint, note=note), EsustpmMemory(int(guide), heading)


def bind(scenario: Scenario, params: EsustpmParams) -> Esustpm:
    """ESUSTPM for one mission."""
    return Esustpm(scenario, params, Rules.of(params, scenario.detection_threshold))


ESUSTPM = PlannerKind(
    "esustpm",
    "Flocking at a given distance, drawn by the likeliest surrounding cell (Liu 2022, Eqs. 3-11)",
    EsustpmParams,
    bind,
)
