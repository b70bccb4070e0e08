"""Khan 2014, Figs 5-9: steps and errors over the false alarm rate, the team and the range."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from uavbridge.experiments.experiment import FIDELITIES, Case, Experiment, Outcome
from uavbridge.experiments.khan import study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FALSE_ALARMS = tuple({"q": round(0.02 * k, 2)} for k in range(1, 22))
RANGES = range(15)
EVERYONE = 14  # the range that reaches across the region


def _plot(axis: str, label: str, figure: Figure, outcome: Outcome) -> None:
    from uavbridge.experiments.khan import plots

    plots.against(figure, outcome, axis, label, ("steps", "error_percent"))


def _figure(
    number: int,
    summary: str,
    axis: tuple[str, str],
    uavs: Sequence[int],
    ranges: Iterable[int] = (EVERYONE,),
    more: Sequence[Case] = ({},),
) -> Experiment:
    """One of the figures: the case's key on its axis with a label, and the cases."""
    return Experiment(
        name=f"khan-fig{number}",
        summary=f"steps and errors over {summary}",
        source=f"Khan 2014, Fig. {number}",
        params=study.FlownParams,
        cases=partial(study.cases, uavs=uavs, ranges=ranges, more=more),
        simulate=study.simulate,
        file=str(Path(__file__).with_name(f"fig{number}.py")),
        fidelities=FIDELITIES,
        runs=1000,
        runs_flown=study.RUNS_FLOWN,
        block=study.BLOCK,
        batched=("ideal", "dynamics"),
        paired=study.PAIRED,
        alike=study.alike,
        derive=study.gains,
        plot=partial(_plot, *axis),
    )


_RATE = ("q", "false alarm rate q")
_TEAM = ("N", "number of UAVs")
_RANGE = ("range", "communication range (cells)")

FIG5 = _figure(5, "the false alarm rate, 2 UAVs, all in range", _RATE, uavs=(2,), more=FALSE_ALARMS)
FIG6 = _figure(6, "the false alarm rate, 5 UAVs, all in range", _RATE, uavs=(5,), more=FALSE_ALARMS)
FIG7 = _figure(7, "the number of UAVs, all in range", _TEAM, uavs=(1, 2, 3, 4, 5))
FIG8 = _figure(8, "the communication range, 2 UAVs", _RANGE, uavs=(2,), ranges=RANGES)
FIG9 = _figure(9, "the communication range, 5 UAVs", _RANGE, uavs=(5,), ranges=RANGES)
