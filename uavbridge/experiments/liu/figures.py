"""Liu 2022: curves (Figs 11, 12, 20-22), boxplots (28-30), maps with tracks (5-10, 13-19)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planners.types import I64
from uavbridge.experiments.experiment import FIDELITIES, Case, Experiment, Outcome, Samples
from uavbridge.experiments.liu import measures
from uavbridge.experiments.liu.setting import RUNS_FLOWN, LiuParams

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_REACHED = (
    "visited_cells",
    "uncertainty",
    "entropy",
    "targets_found",
    "coverage_cycle",
    "stop_cycle",
    "target_1_cycle",
    "target_2_cycle",
    "target_3_cycle",
)


def _cases(params: LiuParams, targets: Sequence[bool]) -> list[Case]:
    return [{"method": method, "targets": there} for there in targets for method in params.chosen]


def _simulate(
    case: Case, params: LiuParams, seeds: I64, fidelity: str, curves: Sequence[str] = ()
) -> Samples:
    """Figures at the last cycle, and curves."""
    course = measures.course(case, params, seeds, fidelity)
    return {**measures.numbers(course, params), **measures.curves(course, curves)}


def _over_time(figure: Figure, outcome: Outcome, curves: Sequence[str]) -> None:
    from uavbridge.experiments.liu import plots

    plots.over_time(figure, outcome, curves)


def _boxes(figure: Figure, outcome: Outcome) -> None:
    from uavbridge.experiments.liu import plots

    plots.boxes(figure, outcome)


def _maps(figure: Figure, outcome: Outcome) -> None:
    from uavbridge.experiments.liu import plots

    plots.maps(figure, outcome)


def _figure(
    name: str,
    figures: str,
    summary: str,
    targets: Sequence[bool],
    plot: Callable[[Figure, Outcome], None],
    simulate: Callable[[Case, Any, I64, str], Samples] = _simulate,
    **more: Any,
) -> Experiment:
    """One of the figures, without targets, with targets, or both."""
    return Experiment(
        name=f"liu-{name}",
        summary=summary,
        source=f"Liu 2022, Figs {figures}",
        params=LiuParams,
        cases=partial(_cases, targets=targets),
        simulate=simulate,
        file=str(Path(__file__).with_name(f"{name}.py")),
        fidelities=FIDELITIES,
        runs_flown=RUNS_FLOWN,
        batched=("ideal", "dynamics"),
        plot=plot,
        **more,
    )


def _curves(name: str, figures: str, summary: str, targets: bool, *curves: str) -> Experiment:
    return _figure(
        name,
        figures,
        summary,
        (targets,),
        partial(_over_time, curves=curves),
        partial(_simulate, curves=curves),
        axis=measures.CURVE,
    )


_KNOWLEDGE = ("visited_cells", "uncertainty", "entropy")

COVERAGE = _curves(
    "coverage",
    "11, 12",
    "cells visited and uncertainty over time, without targets",
    False,
    *_KNOWLEDGE,
)
TARGETS = _curves(
    "targets",
    "20-22",
    "cells visited, uncertainty and targets found over time",
    True,
    *_KNOWLEDGE,
    "targets_found",
)
STATISTICS = _figure(
    "statistics",
    "28-30",
    "boxplots of the time to full coverage, the uncertainty, and the times of the targets",
    (False, True),
    _boxes,
    medians=_REACHED,
)
MAPS = _figure(
    "maps",
    "5-10, 13-19",
    "maps and tracks after 200 cycles, and ESUSTPM's as the targets are found",
    (False, True),
    _maps,
    runs=1,
)
