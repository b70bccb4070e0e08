"""Every merging rule, ours too, at equal bytes over range, loss, delay and bandwidth.

COUNTS is conflict-free merging: counts of readings by agent and cell, united by
maximum (``planners.belief.counts``). All rules gossip: as many wire records a
step as the budget of bytes allows (``gossip``). One axis at a time is moved away
from the middle; ``axis`` in a case says which.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from planners.planner import param
from planners.types import I64
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples, Value
from uavbridge.experiments.khan import study
from uavbridge.experiments.khan.choices import RULES, KhanParams
from uavbridge.experiments.khan.gossip import COUNTS, gossip_of
from uavbridge.experiments.khan.world import search

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AXES: Mapping[str, tuple[int | float, ...]] = {
    "range": (1, 2, 4, 6, 14),
    "loss": (0.0, 0.2, 0.5, 0.8, 0.95),
    "delay": (0, 2, 5, 10, 20),
    "bytes": (2, 9, 18, 36, 72, 288),
}


@dataclass(frozen=True, slots=True)
class Params(KhanParams):
    """The setting, and the middle of the four axes."""

    uavs: int = param(5, unit="1", doc="N", low=1, high=50)
    range_cells: int = param(6, unit="cells", doc="communication range", low=0)
    loss: float = param(0.0, unit="1", doc="share of messages lost", low=0.0, high=1.0)
    delay: int = param(0, unit="steps", doc="until a message arrives", low=0)
    bytes_a_step: int = param(36, unit="bytes", doc="that a UAV may send each step", low=1)


def cases(params: Params) -> list[Case]:
    """Points of the four axes under every rule."""
    middle: dict[str, Value] = {
        "range": params.range_cells,
        "loss": params.loss,
        "delay": params.delay,
        "bytes": params.bytes_a_step,
    }
    return [
        {"N": params.uavs, "axis": axis, **middle, axis: value, "rule": rule}
        for axis, values in AXES.items()
        for value in values
        for rule in (*RULES, COUNTS)
    ]


def simulate(case: Case, params: Params, seeds: I64, fidelity: str) -> Samples:
    """Steps, errors, and the bytes that a UAV sent."""
    rule, uavs = str(case["rule"]), int(case["N"])
    team = gossip_of(
        rule,
        params,
        len(seeds),
        uavs,
        budget_bytes=float(case["bytes"]),
        delay=int(case["delay"]),
    )
    fates = search(team, params, uavs, float(case["range"]), seeds, loss=float(case["loss"]))
    return {**study.metrics(fates), "bytes_per_agent": fates.bytes_sent / uavs}


def plot(figure: Figure, outcome: Outcome) -> None:
    """Gain and errors over each axis."""
    from uavbridge.experiments.khan import plots

    plots.over_axes(figure, outcome, AXES)


EXPERIMENT = Experiment(
    name="merge-beyond",
    summary="every merging rule and conflict-free counts at equal bytes",
    source="beyond Khan 2014",
    params=Params,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=300,
    block=100,
    paired=("rule", "range", "delay", "bytes", "axis"),
    derive=study.gains,
    plot=plot,
)
