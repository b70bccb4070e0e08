"""Liu 2022, Figs 23-27: ESUSTPM with accurate, false and incomplete prior maps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from planners.belief.prior import gaussian_prior
from planners.planner import param
from planners.types import F64, I64
from uavbridge.config.tables import Expected
from uavbridge.experiments.experiment import FIDELITIES, Case, Experiment, Outcome, Samples
from uavbridge.experiments.liu import measures
from uavbridge.experiments.liu.setting import GRID, HIDDEN, RUNS_FLOWN, TARGETS, Cell, LiuParams

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# prior: cells that hold a target in truth. The prior map expects one in each of TARGETS.
TRUTH: dict[str, tuple[Cell, ...]] = {
    "none": TARGETS,
    "accurate": TARGETS,
    "false-target": TARGETS[:2],  # Fig. 27a: none at (700, 500)
    "hidden-target": (HIDDEN,),  # Fig. 27b: the expected three are not there
}


@dataclass(frozen=True, slots=True)
class Params(LiuParams):
    """Those of the setting, and the prior map's, which the paper does not give."""

    sigma_m: float = param(
        50.0, unit="m", doc="sigma_0: standard deviation of a target's expected place", low=1.0
    )
    floor: float = param(
        0.1, unit="1", doc="P of a cell where nothing is expected", low=1e-6, high=0.5
    )
    peak: float = param(0.8, unit="1", doc="P of the likeliest cell", low=0.5, high=0.94)
    expected_at: str = param(
        "cell",
        unit="-",
        doc="targets are expected at their cell's centre, or at their printed point (a corner)",
        choices=("cell", "corner"),
    )


def cases(params: Params) -> list[Case]:
    """A case a prior."""
    return [{"prior": prior} for prior in TRUTH]


def expected(params: Params) -> F64:
    """Where the prior expects targets (3, 2) m."""
    cells = np.array(TARGETS)
    return GRID.centre_of(cells) if params.expected_at == "cell" else cells * GRID.cell_m


def prior_map(params: Params) -> F64:
    """The map (columns, rows) that expects the three targets, Eqs. (1) and (2)."""
    means = expected(params)
    return gaussian_prior(GRID, means, params.sigma_m, floor=params.floor, peak=params.peak)


def mission_keys(params: Params) -> Mapping[str, Any]:
    """The same map as keys of a mission's [belief]."""
    places = tuple(Expected(position=(float(x), float(y))) for x, y in expected(params))
    own = {"sigma_m": params.sigma_m, "peak": params.peak}
    return {"prior": params.floor, "expected": places, **own}


def simulate(case: Case, params: Params, seeds: I64, fidelity: str) -> Samples:
    """Figures at the last cycle, and P of the cells where a target is wrongly expected."""
    name = str(case["prior"])
    start = None
    if name != "none":
        start = measures.Prior(prior_map(params), mission_keys(params))
    course = measures.runs("esustpm", params, seeds, TRUTH[name], start, fidelity)
    samples = dict(measures.numbers(course, params))
    empty = [cell for cell in TARGETS if cell not in TRUTH[name]]
    if empty:
        wrong = np.stack([course.belief[:, column, row] for column, row in empty], axis=-1)
        samples["wrong_cell_probability"] = wrong.max(axis=-1)
    return samples


def plot(figure: Figure, outcome: Outcome) -> None:
    """The prior map, boxplots of the targets' times, and the maps at the end."""
    from uavbridge.experiments.liu import plots

    plots.priors(figure, outcome)


EXPERIMENT = Experiment(
    name="liu-prior",
    summary="ESUSTPM without prior, with an accurate one, with a false and with a hidden target",
    source="Liu 2022, Figs 23-27",
    params=Params,
    cases=cases,
    simulate=simulate,
    file=__file__,
    fidelities=FIDELITIES,
    runs_flown=RUNS_FLOWN,
    batched=("ideal", "dynamics"),
    paired=("prior",),
    medians=("coverage_cycle", "target_1_cycle", "target_2_cycle", "target_3_cycle"),
    plot=plot,
)
