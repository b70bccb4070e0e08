"""Moving intruders: the paper has a rule for them (Eq. 7) and no experiment. Ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from planners.flocking.starling import goals
from planners.flocking.starling.near import unit
from planners.flocking.starling.rules import StarlingRules
from planners.planner import param
from planners.types import F64, I64
from uavbridge.experiments.chen import flight, measures, terrains
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples, generators

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = ("crossing", "head-on", "chasing")
_FAR_M = 900.0  # from the flock, when it appears


@dataclass(frozen=True, slots=True)
class IntruderParams:
    """Parameters of chen-intruder."""

    speed_m_s: float = param(60.0, unit="m/s", doc="of the intruder", low=1.0)
    appears_s: float = param(20.0, unit="s", doc="when it appears", low=0.0)
    stays_s: float = param(40.0, unit="s", doc="how long it flies", low=1.0)
    seconds: float = param(120.0, unit="s", doc="of flight", low=10.0)


@dataclass(frozen=True, slots=True)
class Intruder:
    """One that appears beside or before the flock and flies through it, or after it."""

    kind: str
    params: IntruderParams

    def __call__(self, t_s: float, before: F64, flock: F64) -> F64:
        """Positions (m, 3) at ``t_s``; m is 0 or 1."""
        params = self.params
        if not params.appears_s <= t_s < params.appears_s + params.stays_s:
            return np.zeros((0, 3))
        centre = flock.mean(axis=0)
        step = params.speed_m_s * flight.STEP_S
        if not len(before):
            meeting = _FAR_M / params.speed_m_s * 50.0  # where the flock will be by then
            side = {
                "crossing": (meeting, -_FAR_M, 0.0),
                "head-on": (_FAR_M, 0.0, 0.0),
                "chasing": (_FAR_M * 0.7, _FAR_M * 0.7, 0.0),
            }[self.kind]
            return np.asarray(centre + side)[None]
        if self.kind == "crossing":
            return np.asarray(before + np.array((0.0, step, 0.0)))
        if self.kind == "head-on":
            return np.asarray(before - np.array((step, 0.0, 0.0)))
        nearest = flock[np.argmin(np.linalg.norm(flock - before, axis=1))]
        return np.asarray(before + step * unit(nearest - before))


def cases(params: IntruderParams) -> list[Case]:
    """Each kind against two sizes of flock; Eq. (7) as printed besides."""
    return [
        {"intruder": kind, "n": n, "escape": escape}
        for escape in ("working", "printed", "none")
        for kind in KINDS
        for n in (8, 20)
    ]


def flown(case: Case, params: IntruderParams, rng: np.random.Generator) -> flight.Tracks:
    """One flight of a case."""
    starling = StarlingRules()
    if case["escape"] == "none":
        starling = replace(starling, escape=0.0)
    if case["escape"] == "printed":
        # Its sign alone; that the printed pull grows with the distance is left out.
        starling = replace(starling, escape=-starling.escape)
    rules = flight.Rules(terrains.terrain("flat"), starling, params.seconds)
    return flight.fly(int(case["n"]), rules, rng, Intruder(str(case["intruder"]), params))


def simulate(case: Case, params: IntruderParams, seeds: I64, fidelity: str) -> Samples:
    """Figures of the flights."""
    figures = [_figures(flown(case, params, rng), params) for rng in generators(seeds)]
    return {name: np.array([part[name] for part in figures]) for name in figures[0]}


def _figures(tracks: flight.Tracks, params: IntruderParams) -> dict[str, float]:
    there = np.isfinite(tracks.intruders[:, 0, 0])
    away = np.linalg.norm(tracks.position[there] - tracks.intruders[there], axis=-1)
    told = measures.numbers(tracks, terrains.terrain("flat"))
    seen = tracks.t_s[there][(away <= StarlingRules().perception_m).any(axis=-1)]
    first, last = (float(seen[0]), float(seen[-1])) if len(seen) else (np.nan, np.nan)
    all_know = tracks.t_s[tracks.alarm.all(axis=-1)]
    groups = goals.groups(tracks.position, measures.LINK_M)
    ordered = (goals.polarisation(tracks.velocity) > 0.98) & (groups == 1)
    after = tracks.t_s[ordered & (tracks.t_s > last)]
    return {
        "min_intruder_m": float(away.min()) if there.any() else np.nan,
        "min_separation_m": told["min_separation_m"],
        "min_clearance_m": told["min_clearance_m"],
        "groups_most": told["groups_most"],
        "groups_end": told["groups_end"],
        "speed_most_m_s": float(np.linalg.norm(tracks.velocity[tracks.t_s > 10.0], axis=-1).max()),
        "all_know_s": float(all_know[0]) - first if len(all_know) else np.nan,
        "regrouped_s": float(after[0]) - last if len(after) else np.nan,
        "polarisation_least": float(goals.polarisation(tracks.velocity[there]).min()),
        "share_escape": told["share_escape"],
        "polarisation_end": told["polarisation_end"],
    }


def plot(figure: Figure, outcome: Outcome) -> None:
    """Tracks from above of the first run of every case with the rule that works."""
    from uavbridge.experiments.chen import plots
    from uavbridge.experiments.runner import seeds_of

    flights: list[tuple[Case, flight.Tracks]] = []
    for case, _ in outcome.samples:
        if case["escape"] == "working":
            seeds = seeds_of(outcome.experiment, case, outcome.seed, 1)
            flights.append((case, flown(case, outcome.params, generators(seeds)[0])))
    plots.intruders(figure, flights)


def remarks(outcome: Outcome) -> Sequence[str]:
    """What a run does not tell by its numbers."""
    return ("The paper has Eq. (7) and no experiment: intruders, course and figures are ours.",)


EXPERIMENT = Experiment(
    name="chen-intruder",
    summary="a flock and a moving intruder: Eq. (7) as it works, as printed, and without",
    source="ours; Chen 2023, Eq. 7",
    params=IntruderParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=5,
    block=1,
    paired=("escape",),
    remarks=remarks,
    plot=plot,
)
