"""Liu 2022, Figs 5-10 and 13-19: maps and tracks, a panel a method."""

from __future__ import annotations

from typing import TYPE_CHECKING

from planners.types import I64
from uavbridge.experiments.experiment import FIDELITIES, Case, Experiment, Outcome, Samples
from uavbridge.experiments.liu import measures
from uavbridge.experiments.liu.setting import LiuParams

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def cases(params: LiuParams) -> list[Case]:
    """Methods without and with targets."""
    return [
        {"method": method, "targets": targets}
        for targets in (False, True)
        for method in params.chosen
    ]


def simulate(case: Case, params: LiuParams, seeds: I64, fidelity: str) -> Samples:
    """Figures at the last cycle."""
    return measures.numbers(measures.course(case, params, seeds, fidelity), params)


def plot(figure: Figure, outcome: Outcome) -> None:
    """Maps and tracks of the first run of every case."""
    from uavbridge.experiments.liu import plots

    plots.maps(figure, outcome)


EXPERIMENT = Experiment(
    name="liu-maps",
    summary="maps and tracks after 200 cycles, and ESUSTPM's as the targets are found",
    source="Liu 2022, Figs 5-10, 13-19",
    params=LiuParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    fidelities=FIDELITIES,
    batched=("ideal", "dynamics"),
    runs=1,
    plot=plot,
)
