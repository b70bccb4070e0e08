"""Khan 2014, Table II: gain over uncoordinated search by rule, number of UAVs and range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from planners.planner import param
from uavbridge.experiments.experiment import Case, Experiment, Outcome
from uavbridge.experiments.khan import study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UAVS = (2, 3, 4, 5)
RANGES = (2, 6, 14)


@dataclass(frozen=True, slots=True)
class Params(study.StudyParams):
    """Those of all figures, with the four rules of the table."""

    rules: str = param("BU,AVG,MOGM,SDS", unit="-", doc="merging rules, by commas; UNC always is")


def cases(params: Params) -> list[Case]:
    """The table's cells, and uncoordinated search beside each row."""
    return study.cases(params, UAVS, RANGES)


def plot(figure: Figure, outcome: Outcome) -> None:
    """Gains as bars, beside the printed ones."""
    from uavbridge.experiments.khan import plots

    plots.bars(figure, outcome)


EXPERIMENT = Experiment(
    name="khan-table2",
    summary="gain over uncoordinated search by rule, number of UAVs and range",
    source="Khan 2014, Table II",
    params=Params,
    cases=cases,
    simulate=study.simulate,
    file=__file__,
    runs=1000,
    block=study.BLOCK,
    paired=study.PAIRED,
    derive=study.gains,
    plot=plot,
)
