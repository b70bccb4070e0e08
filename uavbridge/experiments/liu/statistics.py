"""Liu 2022, Figs 28-30: boxplots of coverage time, uncertainty and the targets' times."""

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
    """Figures at the last cycle, and when things were reached."""
    return measures.numbers(measures.course(case, params, seeds, fidelity), params)


def plot(figure: Figure, outcome: Outcome) -> None:
    """Three panels of boxplots, as in the paper."""
    from uavbridge.experiments.liu import plots

    plots.boxes(figure, outcome)


EXPERIMENT = Experiment(
    name="liu-statistics",
    summary="boxplots of the time to full coverage, the uncertainty, and the times of the targets",
    source="Liu 2022, Figs 28-30",
    params=LiuParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    fidelities=FIDELITIES,
    batched=("ideal", "dynamics"),
    medians=(
        "visited_cells",
        "uncertainty",
        "entropy",
        "targets_found",
        "coverage_cycle",
        "stop_cycle",
        "target_1_cycle",
        "target_2_cycle",
        "target_3_cycle",
    ),
    plot=plot,
)
