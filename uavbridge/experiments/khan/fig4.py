"""Khan 2014, Fig. 4: fewest observations that lift a cell to B, by Eq. (12) and by Eq. (1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.belief.bayes import bayes, readings_needed
from planners.planner import param
from planners.types import I64
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DETECTION = (0.6, 0.7, 0.8, 0.9)
FALSE_ALARMS = tuple(round(0.02 * k, 2) for k in range(1, 28))


@dataclass(frozen=True, slots=True)
class Params:
    """The threshold and the first belief."""

    threshold: float = param(0.99, unit="1", doc="B", low=0.501, high=0.999999)
    prior: float = param(0.5, unit="1", doc="P_0", low=0.001, high=0.5)


def cases(params: Params) -> list[Case]:
    """Sensors that see a target more often than none."""
    return [{"p": p, "q": q} for p in DETECTION for q in FALSE_ALARMS if q < p]


def simulate(case: Case, params: Params, seeds: I64, fidelity: str) -> Samples:
    """Eq. (12), and positive observations counted until P >= B: the same in every run."""
    p, q = float(case["p"]), float(case["q"])
    needed = readings_needed(params.prior, p, q, params.threshold)
    belief, count = params.prior, 0
    while belief < params.threshold:
        belief, count = float(bayes(belief, True, p, q)), count + 1  # Eq. (10)
    return {
        "observations": np.full(len(seeds), float(needed)),
        "observations_counted": np.full(len(seeds), float(count)),
    }


def plot(figure: Figure, outcome: Outcome) -> None:
    """Steps over q, a line for each p; dots where counted."""
    axes = figure.subplots()
    for place, p in enumerate(DETECTION):
        for metric, style in (("observations", "-"), ("observations_counted", ".")):
            points = [
                (float(row.case["q"]), row.mean)
                for row in outcome.rows
                if row.metric == metric and row.case["p"] == p
            ]
            label = f"m, p = {p}" if style == "-" else None
            axes.plot(*zip(*points, strict=True), style, color=f"C{place}", label=label)
    axes.set_yscale("log")
    axes.set_xlabel("false alarm rate q")
    axes.set_ylabel("observations")
    axes.grid(alpha=0.3)
    axes.legend()


EXPERIMENT = Experiment(
    name="khan-fig4",
    summary="fewest observations that lift a cell to the threshold",
    source="Khan 2014, Fig. 4",
    params=Params,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=1,
    plot=plot,
)
