"""Liu 2022, Figs 11, 12: cells visited and uncertainty over time, without targets."""

from __future__ import annotations

from typing import TYPE_CHECKING

from planners.types import I64
from uavbridge.experiments.experiment import FIDELITIES, Case, Experiment, Outcome, Samples
from uavbridge.experiments.liu import measures
from uavbridge.experiments.liu.setting import LiuParams

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CURVES = ("visited_cells", "uncertainty", "entropy")


def cases(params: LiuParams) -> list[Case]:
    """A case a method."""
    return [{"method": method, "targets": False} for method in params.chosen]


def simulate(case: Case, params: LiuParams, seeds: I64, fidelity: str) -> Samples:
    """Figures at the last cycle, and the curves."""
    course = measures.course(case, params, seeds, fidelity)
    return {**measures.numbers(course, params), **measures.curves(course, CURVES)}


def plot(figure: Figure, outcome: Outcome) -> None:
    """The curves: mean, and quartiles as a band."""
    from uavbridge.experiments.liu import plots

    plots.over_time(figure, outcome, CURVES)


EXPERIMENT = Experiment(
    name="liu-coverage",
    summary="cells visited and uncertainty over time, without targets",
    source="Liu 2022, Figs 11, 12",
    params=LiuParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    fidelities=FIDELITIES,
    batched=("ideal", "dynamics"),
    axis=measures.CURVE,
    plot=plot,
)
