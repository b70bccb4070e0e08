"""Khan 2014, Fig. 6: steps and errors over the false alarm rate, 5 UAVs, all in range."""

from __future__ import annotations

from typing import TYPE_CHECKING

from uavbridge.experiments.experiment import Case, Experiment, Outcome
from uavbridge.experiments.khan import study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FALSE_ALARMS = tuple({"q": round(0.02 * k, 2)} for k in range(1, 22))


def cases(params: study.StudyParams) -> list[Case]:
    """A case a point of each rule's curve."""
    return study.cases(params, (5,), (14,), FALSE_ALARMS)


def plot(figure: Figure, outcome: Outcome) -> None:
    """Steps and errors, as the paper shows them."""
    from uavbridge.experiments.khan import plots

    plots.against(figure, outcome, "q", "false alarm rate q", ("steps", "error_percent"))


EXPERIMENT = Experiment(
    name="khan-fig6",
    summary="steps and errors over the false alarm rate, 5 UAVs, all in range",
    source="Khan 2014, Fig. 6",
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
