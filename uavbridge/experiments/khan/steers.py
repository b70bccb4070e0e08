"""What each merge rule brings when the merged map steers the search: Khan 2014, future work.

Khan's setting as missions (``missions``), flown by planners that go where their map
tells them to. The rule is the mission's own ``belief.merge``. Fixed sweeps are those of
``khan-table2``; the planner ``sweep`` flies them here too.
A search goes on after a false alarm, until some agent declares the target's own cell:
``gain_percent`` is of that time, and so a rule gains nothing by naming wrong cells fast.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.planner import param
from planners.types import F64, I64
from uavbridge import plugins
from uavbridge.experiments.comparison.compare import search
from uavbridge.experiments.comparison.trial import Trial
from uavbridge.experiments.experiment import FIDELITIES, Case, Experiment, Outcome, Samples
from uavbridge.experiments.khan import missions, study
from uavbridge.experiments.khan.choices import KhanParams, Scale
from uavbridge.experiments.rows import Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RULES = tuple(missions.MERGE)  # UNC first
SWEEP = "sweep"


@dataclass(frozen=True, slots=True)
class Params(KhanParams):
    """The setting, the planners and the rules."""

    planners: str = param("esustpm,boids-guided", unit="-", doc="names, by commas")
    rules: str = param(",".join(RULES[1:]), unit="-", doc="merging rules, by commas; UNC always is")
    uavs: int = param(5, unit="1", doc="N", low=1, high=50)
    ranges: str = param("2,6", unit="cells", doc="communication ranges, by commas")
    cell_m: float = param(100.0, unit="m", doc="a cell", low=15.0, high=1000.0)
    speed_m_s: float = param(10.0, unit="m/s", doc="speed of the fixed sweep", low=1.0, high=12.0)
    flight_s: float = param(
        1000.0,
        unit="s",
        doc="a search is given up then; batteries last 18 minutes",
        low=1.0,
        high=86000.0,
    )

    @property
    def shown(self) -> tuple[str, ...]:
        """The rules in their order; UNC is what gains are measured against."""
        named = [part.strip() for part in self.rules.split(",") if part.strip()]
        for name in named:
            if name not in RULES:
                raise ValueError(f"unknown rule {name!r} (known: {', '.join(RULES)})")
        return tuple(name for name in RULES if name == "UNC" or name in named)

    @property
    def chosen(self) -> tuple[str, ...]:
        """The planners."""
        return tuple(dict.fromkeys(part.strip() for part in self.planners.split(",")))


def cases(params: Params) -> list[Case]:
    """Every planner under every rule at every range."""
    known = plugins.planners()
    for name in params.chosen:
        if name not in known:
            raise ValueError(f"unknown planner {name!r} (known: {', '.join(known)})")
    return [
        {"planner": name, "N": params.uavs, "range": reach, "rule": rule}
        for name in params.chosen
        for reach in study.numbers("ranges", params.ranges, 0)
        for rule in params.shown
    ]


def simulate(case: Case, params: Params, seeds: I64, fidelity: str) -> Samples:
    """Time until the target is declared, the first cell declared, bytes."""
    scale = Scale(params.cell_m, params.speed_m_s, params.flight_s)
    planner = str(case["planner"])
    # Planners decide once a second; the sweep, which has nothing to decide, as in ``missions``.
    guided = {"planner": planner, "parameters": {}, "tick": 1.0}
    changes = {} if planner == SWEEP else guided
    rule, reach = str(case["rule"]), float(case["range"])
    flown = [
        missions.mission_of(params, scale, rule, params.uavs, reach, seed, **changes)
        for seed in seeds.tolist()
    ]
    target = (params.target_column, params.target_row)
    return _metrics(search(flown, fidelity), target, params.flight_s)


def alike(case: Case) -> Case:
    """Who follows a fixed sweep and merges nothing does the same at every range."""
    alone = case["planner"] == SWEEP and case["rule"] == "UNC"
    return {**case, "range": 0} if alone else case


def _metrics(trials: list[Trial], target: tuple[int, int], limit_s: float) -> dict[str, F64]:
    """A run that does not find the target counts with the time it had."""
    found = np.array([trial.declared.get(target, np.nan) for trial in trials])
    first = [missions.first_named(trial) for trial in trials]
    named = [
        limit_s if one is None else trial.declared[one]
        for one, trial in zip(first, trials, strict=True)
    ]
    return {
        "found_s": np.where(np.isnan(found), limit_s, found),
        "found_percent": np.where(np.isnan(found), 0.0, 100.0),
        "named_s": np.array(named),
        "error_percent": np.array([100.0 * (one != target) for one in first]),
        "false_targets": np.array([float(trial.false_targets) for trial in trials]),
        "bytes_per_agent": np.array([trial.curves["bytes_per_agent"][-1] for trial in trials]),
    }


def gains(outcome: Outcome) -> list[Row]:
    """Gain in the time until the target is declared, over uncoordinated search."""
    return study.gains(outcome, "found_s")


def plot(figure: Figure, outcome: Outcome) -> None:
    """Times and gains by planner and rule."""
    from uavbridge.experiments.khan import plots

    plots.steering(figure, outcome)


EXPERIMENT = Experiment(
    name="merge-steers",
    summary="what each merging rule brings when the merged map guides the search",
    source="beyond Khan 2014",
    params=Params,
    cases=cases,
    simulate=simulate,
    file=__file__,
    fidelities=FIDELITIES,
    runs=20,
    runs_flown={"dynamics": 10, "mavlink": 3},
    block=5,
    batched=("ideal", "dynamics"),
    paired=("planner", "rule", "range"),
    intervals=True,
    alike=alike,
    derive=gains,
    plot=plot,
)
