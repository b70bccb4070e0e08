"""What flight costs each planner against its point masses: ``reality-gap``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.planner import param
from planners.types import I64
from uavbridge.experiments.comparison import compare
from uavbridge.experiments.comparison.compare import COMPARED, CompareParams
from uavbridge.experiments.experiment import FIDELITIES, Case, Experiment, Outcome, Samples
from uavbridge.experiments.printed import Printed
from uavbridge.experiments.rows import Row, of_values

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class GapParams(CompareParams):
    """Which planners, on which mission, in which fidelities."""

    planners: str = param(
        "esustpm,boids-guided,boids,mower,sweep,random", unit="-", doc="names, by commas"
    )
    fidelities: str = param("ideal,dynamics,mavlink", unit="-", doc="those flown, by commas")
    duration: float = param(
        400.0, unit="s", doc="time limit; 0: the mission's", low=0.0, high=86400.0
    )


def cases(params: GapParams) -> list[Case]:
    """Every planner in every fidelity."""
    chosen = [part.strip() for part in params.fidelities.split(",")]
    for name in chosen:
        if name not in FIDELITIES:
            raise ValueError(f"unknown fidelity {name!r} (known: {', '.join(FIDELITIES)})")
    return [{**case, "fidelity": name} for case in compare.cases(params) for name in chosen]


def simulate(case: Case, params: GapParams, seeds: I64, fidelity: str) -> Samples:
    """Figures of a block of runs."""
    known = compare.simulate(case, params, seeds, str(case["fidelity"]))
    return {name: values for name, values in known.items() if np.ndim(values) == 1}


def gaps(outcome: Outcome) -> list[Row]:
    """Each fidelity against the point masses on equal seeds: metric ``..._gap``."""
    ideal = {
        case["planner"]: samples for case, samples in outcome.samples if case["fidelity"] == "ideal"
    }
    return [
        of_values(case, f"{name}_gap", samples[name] - ideal[case["planner"]][name], Printed())
        for case, samples in outcome.samples
        if case["fidelity"] != "ideal" and case["planner"] in ideal
        for name in COMPARED
    ]


def plot(figure: Figure, outcome: Outcome) -> None:
    """The figures of every planner by fidelity, with intervals."""
    from uavbridge.experiments.comparison import plots

    plots.by_fidelity(figure, outcome)


EXPERIMENT = Experiment(
    name="reality-gap",
    summary="what flight costs each planner against its point masses",
    source="ours",
    params=GapParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=20,
    block=5,
    paired=("planner", "fidelity"),
    intervals=True,
    derive=gaps,
    plot=plot,
)
