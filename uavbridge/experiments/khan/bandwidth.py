"""Bandwidth limits, which Khan 2014 leaves to future work: few bytes a step for each UAV."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from planners.planner import param
from planners.types import I64
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples
from uavbridge.experiments.khan import study
from uavbridge.experiments.khan.gossip import gossip_of
from uavbridge.experiments.khan.world import search

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BUDGETS = (1, 2, 4, 9, 18, 36, 72, 144, 720)


@dataclass(frozen=True, slots=True)
class Params(study.StudyParams):
    """Those of all figures, and the team."""

    uavs: int = param(5, unit="1", doc="N", low=1, high=50)
    range_cells: int = param(6, unit="cells", doc="communication range", low=0)


def cases(params: Params) -> list[Case]:
    """A case a budget and rule."""
    budgets: list[Case] = [{"bytes": budget} for budget in BUDGETS]
    return study.cases(params, (params.uavs,), (params.range_cells,), budgets)


def simulate(case: Case, params: Params, seeds: I64, fidelity: str) -> Samples:
    """Steps, errors, and the bytes that a UAV sent."""
    setting = study.setting_of(case, params)
    rule, uavs = str(case["rule"]), int(case["N"])
    team = gossip_of(rule, setting, len(seeds), uavs, budget_bytes=float(case["bytes"]))
    fates = search(team, setting, uavs, float(case["range"]), seeds)
    return {**study.metrics(fates), "bytes_per_agent": fates.bytes_sent / uavs}


def plot(figure: Figure, outcome: Outcome) -> None:
    """Gain and errors over the budget."""
    from uavbridge.experiments.khan import plots

    shown = ("gain_percent", "error_percent")
    plots.against(figure, outcome, "bytes", "bytes a step and UAV", shown, log=True)


EXPERIMENT = Experiment(
    name="khan-bandwidth",
    summary="gain and errors when a UAV may send few bytes a step",
    source="Khan 2014, future work",
    params=Params,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=500,
    block=250,
    paired=(*study.PAIRED, "bytes"),
    derive=study.gains,
    plot=plot,
)
