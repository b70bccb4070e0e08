"""Khan 2014, Table II: gain over uncoordinated search by rule, number of UAVs and range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from planners.planner import param
from uavbridge.experiments.experiment import FIDELITIES, Case, Experiment, Outcome
from uavbridge.experiments.khan import study

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Params(study.FlownParams):
    """Those of all figures, with the four rules of the table, and its cells."""

    rules: str = param("BU,AVG,MOGM,SDS", unit="-", doc="merging rules, by commas; UNC always is")
    uavs: str = param("2,3,4,5", unit="1", doc="N, by commas")
    ranges: str = param("2,6,14", unit="cells", doc="communication ranges, by commas")


def cases(params: Params) -> list[Case]:
    """The table's cells, and uncoordinated search beside each row."""
    return study.cases(
        params, study.numbers("uavs", params.uavs, 1), study.numbers("ranges", params.ranges, 0)
    )


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
    fidelities=FIDELITIES,
    runs=1000,
    runs_flown=study.RUNS_FLOWN,
    block=study.BLOCK,
    batched=("ideal", "dynamics"),
    paired=study.PAIRED,
    alike=study.alike,
    derive=study.gains,
    plot=plot,
)
