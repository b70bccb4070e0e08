"""Khan 2014, Fig. 7: steps and errors over the number of UAVs, all in range."""

from __future__ import annotations

from typing import TYPE_CHECKING

from uavbridge.experiments.experiment import Case, Experiment, Outcome
from uavbridge.experiments.khan import study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UAVS = (1, 2, 3, 4, 5)


def cases(params: study.StudyParams) -> list[Case]:
    """A case a point of each rule's curve."""
    return study.cases(params, UAVS, (14,))


def plot(figure: Figure, outcome: Outcome) -> None:
    """Steps and errors, as the paper shows them."""
    from uavbridge.experiments.khan import plots

    plots.against(figure, outcome, "N", "number of UAVs", ("steps", "error_percent"))


EXPERIMENT = Experiment(
    name="khan-fig7",
    summary="steps and errors over the number of UAVs, all in range",
    source="Khan 2014, Fig. 7",
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
