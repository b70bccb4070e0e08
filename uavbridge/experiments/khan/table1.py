"""Khan 2014, Table I: plain OGMM gets stuck; p = 0.9, q = 0.1, two UAVs, one cell.

UAV 1 has a false alarm at time 1; from time 2 on UAV 2 sees, rightly, nothing.
What each holds of the cell goes to the other, and both merge: the table needs
the reading in which the observer merges too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.belief.rule import MergeRule
from planners.planner import param
from planners.types import F64, I64
from uavbridge.experiments.experiment import READING, Case, Experiment, Outcome, Samples
from uavbridge.experiments.khan.choices import KhanParams, rules
from uavbridge.experiments.khan.world import STEP_US

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OTHERS = ("rule=BU", "rule=AVG", "rule=MOGM", "rule=SDS")


@dataclass(frozen=True, slots=True)
class Params:
    """The table's numbers."""

    p: float = param(0.9, unit="1", doc="detection probability", low=0.001, high=0.999)
    q: float = param(0.1, unit="1", doc="false alarm probability", low=0.001, high=0.999)
    times: int = param(10, unit="1", doc="times shown", low=1, high=100)
    observer: str = param(
        "merges",
        unit="-",
        doc="who holds the newest observation keeps its value, or merges older ones in",
        choices=("keeps", "merges"),
    )


def cases(params: Params) -> list[Case]:
    """Times and UAVs under OGMM, then under the other rules."""
    plain: list[Case] = [
        {"time": time, "uav": uav} for time in range(params.times + 1) for uav in (1, 2)
    ]
    return [*plain, *({**case, READING: label} for label in OTHERS for case in plain)]


def simulate(case: Case, params: Params, seeds: I64, fidelity: str) -> Samples:
    """What the UAV holds of the cell: the same in every run."""
    setting = KhanParams(
        columns=1,
        rows=1,
        target_column=0,
        target_row=0,
        p=params.p,
        q=params.q,
        observer=params.observer,
    )
    rule = rules(setting)[str(case.get(READING, "rule=OGMM")).removeprefix("rule=")]
    value = course(rule, setting, params.times)[int(case["time"]), int(case["uav"]) - 1]
    return {"probability": np.full(len(seeds), value)}


def course(rule: MergeRule, setting: KhanParams, times: int) -> F64:
    """(times + 1, 2) what both UAVs hold."""
    maps = [rule.empty(setting.grid, 0.5, setting.sensor) for _ in range(2)]
    held = [[0.5, 0.5]]
    for time in range(1, times + 1):
        who = 0 if time == 1 else 1
        maps[who] = rule.observe(
            maps[who], (0, 0), time == 1, setting.sensor, t_us=time * STEP_US, agent=who
        )
        told = [rule.records(belief, [0]) for belief in maps]
        maps = [rule.merge(maps[0], told[1])[0], rule.merge(maps[1], told[0])[0]]
        held.append([float(belief.probability[0, 0]) for belief in maps])
    return np.array(held)


def plot(figure: Figure, outcome: Outcome) -> None:
    """What UAV 1 holds over time, by rule."""
    axes = figure.subplots()
    for label in (None, *OTHERS):
        points = [
            (int(row.case["time"]), row.mean)
            for row in outcome.rows
            if row.reading == label and row.case["uav"] == 1
        ]
        name = "OGMM" if label is None else label.removeprefix("rule=")
        axes.plot(*zip(*points, strict=True), marker=".", label=name)
    axes.set_xlabel("time")
    axes.set_ylabel("P of the cell, UAV 1")
    axes.grid(alpha=0.3)
    axes.legend()


EXPERIMENT = Experiment(
    name="khan-table1",
    summary="plain OGMM gets stuck after one false alarm",
    source="Khan 2014, Table I",
    params=Params,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=1,
    plot=plot,
)
