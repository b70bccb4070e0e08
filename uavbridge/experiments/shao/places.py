"""Who keeps the pheromone maps, flown: place agents, copies on the UAVs, or nobody.

Missions in lockstep over MAVLink; what each form costs in bytes, how old its answers are, and
what comes of the search.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from numpy.random import Generator

from planners.planner import Planner, param
from planners.types import I64, Goal, View
from uavbridge.bus import keys
from uavbridge.bus.api import Bus, Mailbox
from uavbridge.bus.messages import decode_truth
from uavbridge.clock import to_s
from uavbridge.config import Mission, load
from uavbridge.config.pheromones import FIRST_PLACE, Failure, Pheromones, tiles
from uavbridge.experiments.comparison.flights import fly
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples
from uavbridge.runner.assemble import planner_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMS = ("copies", "places", "nobody")
METRICS = (
    "goal_s",
    "coverage_s",
    "targets_found",
    "bytes_per_agent_s",
    "answer_bytes_per_agent_s",
    "net_bytes_per_place_s",
    "answered",
    "answer_age_s",
    "min_separation_m",
)


@dataclass(frozen=True, slots=True)
class PlacesParams:
    """Which mission, and what fails."""

    mission: str = param("shao2020-small", unit="-", doc="a mission's name or file")
    duration: float = param(400.0, unit="s", doc="time limit of the search", low=1.0, high=86400.0)
    fail_from_s: float = param(60.0, unit="s", doc="when one place agent fails", low=0.0)
    fail_to_s: float = param(240.0, unit="s", doc="and is back", low=0.0)
    loss: float = param(0.3, unit="1", doc="share of messages lost in the rows with loss", low=0.0)


@dataclass(slots=True)
class Overheard:
    """A planner, and what it was answered."""

    planner: Planner
    silenced: bool
    ages: list[float] = field(default_factory=list)
    asked: int = 0
    told_bytes: int = 0

    def init(self, view: View) -> Any:
        return self.planner.init(view)

    def plan(self, view: View, memory: Any, rng: Generator) -> tuple[Goal, Any]:
        self.ages += [answer.age_s for answer in view.answers]
        self.told_bytes += sum(len(answer.data) for answer in view.answers)
        goal, after = self.planner.plan(view, memory, rng)
        self.asked += bool(goal.edits)  # a decision, not a question repeated
        if self.silenced:
            goal = Goal(goal.setpoint, goal.payload, note=goal.note)
        return goal, after


def cases(params: PlacesParams) -> list[Case]:
    """The forms; with messages lost; and place agents of which one fails."""
    plain: list[Case] = [{"form": form} for form in FORMS]
    lossy: list[Case] = [{"form": form, "loss": params.loss} for form in FORMS[:2]]
    return [*plain, *lossy, {"form": "places", "failed": 1}]


def mission_of(case: Case, params: PlacesParams, seed: int) -> Mission:
    """The mission of one run."""
    mission = load(params.mission)
    table = mission.pheromones or Pheromones()
    failures = (Failure(place=FIRST_PLACE, from_s=params.fail_from_s, to_s=params.fail_to_s),)
    replace = msgspec.structs.replace
    table = replace(
        table,
        form="places" if case["form"] == "places" else "copies",
        failures=failures if "failed" in case else (),
    )
    return replace(
        mission,
        pheromones=table,
        radio=replace(mission.radio, loss=float(case.get("loss", 0.0))),
        seed=seed % 2**32,
        clock="stepped",
        duration=params.duration,
    )


def simulate(case: Case, params: PlacesParams, seeds: I64, fidelity: str) -> Samples:
    """A mission a seed."""
    rows = []
    for seed in seeds.tolist():
        mission = mission_of(case, params, seed)
        planner = Overheard(planner_of(mission), case["form"] == "nobody")
        overheard: list[Mailbox] = []

        def listen(bus: Bus, to: list[Mailbox] = overheard) -> None:
            to += [bus.subscribe(keys.place_net("*")), bus.subscribe(keys.TRUTH)]

        trial = fly(mission, planner, listen=listen)
        figures = trial.figures()
        told = planner.told_bytes if case["form"] == "places" else 0  # a copy's are its own
        team_s = len(mission.scenario().team) * max(trial.t_s[-1], 1.0)
        figures["answer_bytes_per_agent_s"] = told / team_s
        figures["net_bytes_per_place_s"] = _net(mission, *overheard)
        figures["answered"] = len(planner.ages) / max(planner.asked, 1)
        figures["answer_age_s"] = float(np.mean(planner.ages)) if planner.ages else np.nan
        rows.append([figures[name] for name in METRICS])
    return dict(zip(METRICS, np.array(rows).T, strict=True))


def _net(mission: Mission, net: Mailbox, truth: Mailbox) -> float:
    """Bytes a second that a place agent tells others, over the whole flight."""
    last = decode_truth(truth.drain()[-1].data)
    places = 0 if mission.pheromones is None else len(tiles(mission, mission.pheromones))
    if last is None or not places:
        return 0.0
    told = sum(len(sample.data) for sample in net.drain())
    return told / places / to_s(max(last.t_us, 1))


def plot(figure: Figure, outcome: Outcome) -> None:
    """Bytes and times by form."""
    from uavbridge.experiments.shao import plots

    plots.places(figure, outcome)


EXPERIMENT = Experiment(
    name="shao-places",
    summary="place agents, copies on the UAVs or no maps at all: bytes, age and result",
    source="Shao 2020, section 1, flown",
    params=PlacesParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=10,
    block=1,
    paired=("form", "loss", "failed"),
    plot=plot,
)
