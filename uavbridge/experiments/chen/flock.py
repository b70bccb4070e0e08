"""Chen 2023, Figs 15-23: flocks that cross terrain, with ablations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planners.flocking.starling.rules import StarlingRules
from planners.planner import param
from planners.types import I64
from uavbridge.experiments.chen import flight, measures, terrains
from uavbridge.experiments.experiment import (
    Axis,
    Case,
    Experiment,
    Outcome,
    Samples,
    Value,
    generators,
)
from uavbridge.experiments.rows import Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZES = (8, 12, 16, 20)
VARIANTS = ("full", "no-spring", "no-planner", "printed-signs")
_ABLATED = (8, 20)


@dataclass(frozen=True, slots=True)
class FlockParams:
    """Parameters of chen-flock."""

    terrain: str = param(
        "all", unit="-", doc="one terrain only", choices=("all", *terrains.NAMES, "flat")
    )
    n: int = param(0, unit="1", doc="one number of aircraft only; 0: 8, 12, 16 and 20", low=0)
    variant: str = param("all", unit="-", doc="one variant only", choices=("all", *VARIANTS))
    planner: str = param(
        "shared",
        unit="-",
        doc="one way for all, or each for itself as in Eqs. (27)-(32) (slow)",
        choices=("shared", "own"),
    )
    seconds: float = param(120.0, unit="s", doc="of flight", low=1.0, high=3600.0)
    tracks: str = param("", unit="-", doc="also write tracks of the first run as CSV to this file")


def cases(params: FlockParams) -> list[Case]:
    """The full rules everywhere; the other variants on the first terrain."""
    names = terrains.NAMES if params.terrain == "all" else (params.terrain,)
    sizes = SIZES if params.n == 0 else (params.n,)
    chosen: list[Case] = []
    if params.variant in ("all", "full"):
        chosen = [{"terrain": name, "n": n, "variant": "full"} for name in names for n in sizes]
    others = VARIANTS[1:] if params.variant == "all" else (params.variant,)
    everywhere = params.terrain != "all" or params.variant != "all"
    for variant in others:
        if variant == "full":
            continue
        chosen += [
            {"terrain": name, "n": n, "variant": variant}
            for name in (names if everywhere else names[:1])
            for n in sizes
            if params.n or everywhere or n in _ABLATED
        ]
    return chosen


def rules_of(case: Case, params: FlockParams) -> flight.Rules:
    """How a case is flown."""
    starling, planner, variant = StarlingRules(), params.planner, case["variant"]
    if variant == "no-spring":
        starling = replace(starling, single=0.0, dodge=0.0)
    if variant == "printed-signs":
        starling = replace(starling, signs="printed", dodge=0.0)
    if variant == "no-planner":
        planner = "none"
    ground = terrains.terrain(str(case["terrain"]))
    return flight.Rules(ground, starling, params.seconds, planner)


def flown(case: Case, params: FlockParams, rng: np.random.Generator) -> flight.Tracks:
    """One flight of a case."""
    return flight.fly(int(case["n"]), rules_of(case, params), rng)


def simulate(case: Case, params: FlockParams, seeds: I64, fidelity: str) -> Samples:
    """Figures, and Eq. (1) over time."""
    ground = terrains.terrain(str(case["terrain"]))
    runs = [flown(case, params, rng) for rng in generators(seeds)]
    figures = [measures.numbers(tracks, ground) for tracks in runs]
    lines = [measures.curves(tracks) for tracks in runs]
    out = {name: np.array([part[name] for part in figures]) for name in figures[0]}
    if params.seconds == _USUAL_S:
        out |= {f"{name}@t_s": np.stack([part[name] for part in lines]) for name in lines[0]}
    return out


def derive(outcome: Outcome) -> Sequence[Row]:
    """No further rows; writes the tracks that were asked for."""
    if outcome.params.tracks:
        file = Path(outcome.params.tracks)
        for place, (case, tracks) in enumerate(first_runs(outcome)):
            path = measures.beside(file, *case.values()) if place else file
            measures.write_csv(tracks.t_s, tracks.position, tracks.velocity, path)
    return ()


def first_runs(outcome: Outcome) -> list[tuple[Case, flight.Tracks]]:
    """The first run of every case, flown again."""
    from uavbridge.experiments.runner import seeds_of

    out = []
    for case, _ in outcome.samples:
        seed = int(seeds_of(outcome.experiment, case, outcome.seed, 1)[0])
        out.append((case, _again(tuple(case.items()), outcome.params, seed)))
    return out


@lru_cache(maxsize=32)
def _again(case: tuple[tuple[str, Value], ...], params: FlockParams, seed: int) -> flight.Tracks:
    """One flight; kept, because tracks and picture want the same ones."""
    return flown(dict(case), params, generators(np.array([seed]))[0])


def plot(figure: Figure, outcome: Outcome) -> None:
    """Tracks from above; yaw, pitch, speed and separation over time."""
    from uavbridge.experiments.chen import plots

    plots.flocks(figure, first_runs(outcome))


_USUAL_S = 120.0
_TIMES = tuple(measures.EVERY_S * (1 + step) for step in range(int(_USUAL_S / measures.EVERY_S)))

EXPERIMENT = Experiment(
    name="chen-flock",
    summary="flocks of fixed-wing aircraft across terrain, with ablations",
    source="Chen 2023, Figs 15-23",
    params=FlockParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=5,
    block=1,
    paired=("variant",),
    axis=Axis("t_s", _TIMES),
    derive=derive,
    plot=plot,
)
