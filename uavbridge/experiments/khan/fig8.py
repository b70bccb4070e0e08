"""Khan 2014, Fig. 8: steps and errors over the communication range, 2 UAVs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from uavbridge.experiments.experiment import Case, Experiment, Outcome
from uavbridge.experiments.khan import study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RANGES = range(15)


def cases(params: study.StudyParams) -> list[Case]:
    """A case a point of each rule's curve."""
    return study.cases(params, (2,), RANGES)


def plot(figure: Figure, outcome: Outcome) -> None:
    """Steps and errors, as the paper shows them."""
    from uavbridge.experiments.khan import plots

    plots.against(
        figure, outcome, "range", "communication range (cells)", ("steps", "error_percent")
    )


EXPERIMENT = Experiment(
    name="khan-fig8",
    summary="steps and errors over the communication range, 2 UAVs",
    source="Khan 2014, Fig. 8",
    params=study.StudyParams,
    cases=cases,
    simulate=study.simulate,
    file=__file__,
    runs=1000,
    block=study.BLOCK,
    paired=study.PAIRED,
    derive=study.gains,
    plot=plot,
)
