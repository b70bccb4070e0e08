"""``uavbridge compare``: any planners on one mission, seed by seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from planners.planner import param
from planners.types import F64, I64
from uavbridge import config, plugins
from uavbridge.config import Mission
from uavbridge.experiments.comparison.trial import SAMPLES, Trial, Until
from uavbridge.experiments.experiment import (
    FIDELITIES,
    Axis,
    Case,
    Experiment,
    Outcome,
    Samples,
)
from uavbridge.experiments.printed import Printed
from uavbridge.experiments.rows import Row, of_values
from uavbridge.runner import assemble

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COMPARED = (
    *("goal_s", "coverage_s", "targets_found", "false_targets", "entropy"),
    *("min_separation_m", "polarisation"),
)


@dataclass(frozen=True, slots=True)
class CompareParams:
    """Which planners, on which mission."""

    planners: str = param("esustpm,boids-guided,mower", unit="-", doc="names, by commas")
    mission: str = param("", unit="-", doc="mission file; empty: the built-in example")
    duration: float = param(
        0.0, unit="s", doc="time limit; 0: the mission's", low=0.0, high=86400.0
    )

    @property
    def chosen(self) -> tuple[str, ...]:
        """The planners, in their order."""
        return tuple(dict.fromkeys(part.strip() for part in self.planners.split(",")))


def mission_of(params: CompareParams, planner: str, seed: int) -> Mission:
    """The mission for one run."""
    overrides: dict[str, object] = {"planner": planner, "seed": seed % 2**32, "clock": "stepped"}
    if params.duration:
        overrides["duration"] = params.duration
    loaded = config.load(params.mission or None, overrides)
    return msgspec.structs.replace(loaded, recording=config.tables.Recording(False, False))


def cases(params: CompareParams) -> list[Case]:
    """A case a planner."""
    known = plugins.planners()
    for name in params.chosen:
        if name not in known:
            raise ValueError(f"unknown planner {name!r} (known: {', '.join(known)})")
        mission_of(params, name, 1)
    return [{"planner": name} for name in params.chosen]


def trials(params: CompareParams, planner: str, seeds: I64, fidelity: str) -> list[Trial]:
    """Runs of one planner, one a seed."""
    return search([mission_of(params, planner, int(seed)) for seed in seeds], fidelity)


def search(missions: Sequence[Mission], fidelity: str, until: Until = "goal") -> list[Trial]:
    """Missions that differ in seeds and starts alone, in one of ``FIDELITIES``."""
    bound = [(mission, assemble.planner_of(mission)) for mission in missions]
    if fidelity == "mavlink":
        from uavbridge.experiments.comparison.flights import fly

        return [fly(mission, planner, until) for mission, planner in bound]
    from uavbridge.experiments.comparison import points

    return points.fly(bound, flown=fidelity == "dynamics", until=until)


def simulate(case: Case, params: CompareParams, seeds: I64, fidelity: str) -> Samples:
    """Figures and curves of a block of runs."""
    flown = trials(params, str(case["planner"]), seeds, fidelity)
    figures = [one.figures() for one in flown]
    samples: dict[str, F64] = {
        name: np.array([part[name] for part in figures]) for name in figures[0]
    }
    curves = [one.resampled() for one in flown]
    for name in curves[0]:
        samples[f"{name}@share"] = np.stack([part[name] for part in curves])
    return samples


def differences(outcome: Outcome) -> list[Row]:
    """Each planner against the first, run by run on equal seeds: metric ``..._difference``."""
    (_, first), *others = outcome.samples
    return [
        of_values(case, f"{name}_difference", samples[name] - first[name], Printed())
        for case, samples in others
        for name in COMPARED
    ]


def plot(figure: Figure, outcome: Outcome) -> None:
    """Coverage, entropy, targets, network and bytes over time."""
    from uavbridge.experiments.comparison import plots

    plots.over_time(figure, outcome)


# The share of the time limit, for curves of missions of any length.
SHARE = Axis("share", tuple(round(float(x), 6) for x in np.linspace(0.0, 1.0, SAMPLES)))

EXPERIMENT = Experiment(
    name="compare",
    summary="planners on one mission, on equal seeds",
    source="ours",
    params=CompareParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=20,
    block=10,
    fidelities=FIDELITIES,
    batched=("dynamics",),
    paired=("planner",),
    axis=SHARE,
    intervals=True,
    derive=differences,
    plot=plot,
)


def of_planner(outcome: Outcome) -> Sequence[str]:
    """Names in the order of the cases."""
    return [str(case["planner"]) for case, _ in outcome.samples]
