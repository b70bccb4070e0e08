"""Zhou 2023, Table 1: who ranks where among the candidates of a suballiance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.search.mountain import rank_members
from planners.types import I64
from uavbridge.experiments.experiment import Case, Experiment, Samples

# robot, I (class I), nearest communication robot and distance from it (class II), as printed
CANDIDATES = (
    (2, None, 14, 213.2349341),
    (3, None, 19, 209.3224293),
    (5, 2.099988287, None, 0.0),
    (9, None, 14, 33.53008801),
    (11, None, 5, 44.66655953),
    (14, 2.024188002, None, 0.0),
    (17, None, 19, 171.3542868),
    (18, None, 14, 232.4477832),
    (19, 6.13611151, None, 0.0),
    (21, None, 5, 212.6859702),
    (22, None, 14, 30.39406231),
    (23, None, 19, 142.4618399),
)


@dataclass(frozen=True, slots=True)
class Params:
    """None: the table has all that the rule needs."""


def cases(params: Params) -> list[Case]:
    """One: the twelve candidates."""
    return [{"table": 1, "n_u": len(CANDIDATES)}]


def simulate(case: Case, params: Params, seeds: I64, fidelity: str) -> Samples:
    """The rank of each robot."""
    strength = {robot: value for robot, value, _, _ in CANDIDATES if value is not None}
    order = rank_members(
        np.array([value is not None for _, value, _, _ in CANDIDATES]),
        np.array([strength.get(robot, 0.0) for robot, *_ in CANDIDATES]),
        np.array([distance for *_, distance in CANDIDATES]),
        np.array([0.0 if link is None else strength[link] for *_, link, _ in CANDIDATES]),
    )
    rank = np.argsort(order) + 1.0
    return {
        f"priority_R{robot}": np.full(len(seeds), rank[row])
        for row, (robot, *_) in enumerate(CANDIDATES)
    }


EXPERIMENT = Experiment(
    name="zhou-table1",
    summary="ranking of the candidates of a suballiance",
    source="Zhou 2023, Table 1",
    params=Params,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=1,
)
