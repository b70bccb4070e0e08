"""Chen 2023, Figs 24-26: tracks that a flock plans, and what aircraft make of them.

The paper feeds the planned tracks to a fixed-wing model after Beard and McLain with 10 to 50
commands a second. Ours: each command is a place, a velocity and a turn of the planned track; the
path manager flies the line through the place along the velocity, faster the farther it is behind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.random import Generator

from planners.flocking.starling import goals
from planners.flocking.starling.rules import StarlingRules
from planners.planner import param
from planners.terrain import Terrain
from planners.types import F64, I64
from sim_vehicles.dynamics import Setpoints
from sim_vehicles.dynamics.plane import GuidedPlane, SixDof
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

SETTLED_S = 20.0
_STEP_S = 0.02  # of the aircraft
_CATCH_UP_1_S = 0.25  # m/s faster for each metre behind
_FASTEST_M_S = 70.0
_USUAL_S = 120.0
Plane: TypeAlias = SixDof | GuidedPlane
_MODELS: dict[str, type[SixDof] | type[GuidedPlane]] = {"six-dof": SixDof, "guidance": GuidedPlane}


@dataclass(frozen=True, slots=True)
class TrackParams:
    """Parameters of chen-track."""

    terrain: str = param(
        "one", unit="-", doc="terrain of the flight", choices=(*terrains.NAMES, "flat")
    )
    n: int = param(8, unit="1", doc="number of aircraft", low=1)
    offset_m: float = param(
        30.0, unit="m", doc="standard deviation of where they start, an axis", low=0.0
    )
    command_hz: float = param(10.0, unit="1/s", doc="commands a second", low=1.0, high=50.0)
    seconds: float = param(_USUAL_S, unit="s", doc="of flight", low=21.0, high=3600.0)
    tracks: str = param("", unit="-", doc="also write flown tracks of the first run to this CSV")


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """A commanded flight and what became of it; k steps of the command."""

    commanded: flight.Tracks
    position: F64  # (k, n, 3) m
    velocity: F64  # (k, n, 3) m/s
    airspeed: F64  # (k, n) m/s

    @property
    def error(self) -> F64:
        """(k, n, 3) m: flown less commanded, east, north, up."""
        return self.position - self.commanded.position


def cases(params: TrackParams) -> list[Case]:
    """The two models, on the same commands from the same starts."""
    return [{"model": name} for name in _MODELS]


def follow(
    commanded: flight.Tracks,
    make: type[SixDof] | type[GuidedPlane],
    params: TrackParams,
    rng: Generator,
) -> Flown:
    """Fly commanded tracks from places beside their starts."""
    count = commanded.position.shape[1]
    beside = rng.normal(0.0, 1.0, (count, 3)) * params.offset_m
    start = commanded.position[0] + beside
    start[:, 2] = np.maximum(start[:, 2], 40.0)
    speed = np.clip(np.linalg.norm(commanded.velocity[0], axis=1), 25.0, _FASTEST_M_S)
    course = np.arctan2(commanded.velocity[0, :, 1], commanded.velocity[0, :, 0])
    plane: Plane = make(start, course, airspeed=speed)
    setpoints = Setpoints.idle(count)
    setpoints.motors[:] = True
    calm = np.zeros((count, 3))
    every = max(round(1.0 / (params.command_hz * _STEP_S)), 1)
    turn = _turns(commanded)
    rows: list[tuple[F64, F64, F64]] = []
    steps = round((commanded.t_s[-1] - commanded.t_s[0]) / _STEP_S)
    for step in range(steps + 1):
        now = step * _STEP_S
        if step % round(flight.STEP_S / _STEP_S) == 0:
            state = plane.states
            rows.append((state.position.copy(), state.velocity.copy(), state.airspeed.copy()))
        if step % every == 0:
            at = now / flight.STEP_S
            place, pace, rate = (
                _between(part, at) for part in (commanded.position, commanded.velocity, turn)
            )
        _command(setpoints, place + pace * (now % (every * _STEP_S)), pace, rate, plane)
        plane.step(setpoints, calm, _STEP_S)
    position, velocity, airspeed = (np.array(part) for part in zip(*rows, strict=True))
    return Flown(commanded, position, velocity, airspeed)


def _command(setpoints: Setpoints, place: F64, pace: F64, rate: F64, plane: Plane) -> None:
    """The line through where it should be, along where it should go; catching up."""
    speed = np.maximum(np.linalg.norm(pace, axis=1), 1.0)
    along = pace / speed[:, None]
    behind = ((place - plane.states.position) * along).sum(axis=1)
    catching = np.clip(speed + _CATCH_UP_1_S * behind, 0.5 * speed, 1.5 * speed)
    setpoints.position[:] = place
    setpoints.velocity[:] = along * catching[:, None]
    setpoints.velocity[:, 2] = pace[:, 2]
    setpoints.yaw_rate[:] = rate


def _turns(commanded: flight.Tracks) -> F64:
    """(k, n) rad/s of the commanded courses."""
    course = np.unwrap(np.arctan2(commanded.velocity[..., 1], commanded.velocity[..., 0]), axis=0)
    return np.asarray(np.gradient(course, flight.STEP_S, axis=0))


def _between(part: F64, at: float) -> F64:
    """A row of (k, ...) at a fractional place."""
    low = min(int(at + 1e-9), len(part) - 1)
    high = min(low + 1, len(part) - 1)
    return np.asarray(part[low] + (at - low) * (part[high] - part[low]))


def flown(case: Case, params: TrackParams, seed: int) -> Flown:
    """One run of a case."""
    return _flown(str(case["model"]), params, seed)


@lru_cache(maxsize=32)
def _commanded(terrain: str, n: int, seconds: float, seed: int) -> flight.Tracks:
    rules = flight.Rules(terrains.terrain(terrain), StarlingRules(), seconds)
    return flight.fly(n, rules, generators(np.array([seed]))[0])


@lru_cache(maxsize=16)
def _flown(model: str, params: TrackParams, seed: int) -> Flown:
    """Kept, because figures, tracks and picture want the same ones."""
    commanded = _commanded(params.terrain, params.n, params.seconds, seed)
    rng = np.random.Generator(np.random.PCG64([seed, 1]))
    return follow(commanded, _MODELS[model], params, rng)


def simulate(case: Case, params: TrackParams, seeds: I64, fidelity: str) -> Samples:
    """Errors after 20 s and before, over all aircraft, and over time."""
    ground = terrains.terrain(params.terrain)
    runs = [flown(case, params, int(seed)) for seed in seeds]
    figures = [_numbers(run, ground) for run in runs]
    out = {name: np.array([part[name] for part in figures]) for name in figures[0]}
    if params.seconds == _USUAL_S:
        stride = round(measures.EVERY_S / flight.STEP_S)
        for axis, name in enumerate(_AXES):
            off = [_rms(run.error[stride - 1 :: stride, :, axis], axis=1) for run in runs]
            out[f"{name}_m@t_s"] = np.stack(off)
    return out


_AXES = ("east", "north", "alt")


def _numbers(run: Flown, ground: Terrain) -> dict[str, float]:
    time = run.commanded.t_s - run.commanded.t_s[0]
    late = time >= SETTLED_S
    above = run.position[..., 2] - ground.height_at(run.position)
    apart = goals.separation(run.position)
    out = {f"rms_{name}_m": float(_rms(run.error[late, :, k])) for k, name in enumerate(_AXES)}
    early = {f"rms_{name}_start_m": _rms(run.error[~late, :, k]) for k, name in enumerate(_AXES)}
    return {
        **out,
        **{name: float(value) for name, value in early.items()},
        "most_m": float(np.linalg.norm(run.error[late], axis=-1).max()),
        "min_separation_m": float(apart[time > measures.SETTLED_S].min()),
        "min_clearance_m": float(above.min()),
        "airspeed_least_m_s": float(run.airspeed.min()),
        "airspeed_most_m_s": float(run.airspeed.max()),
    }


def _rms(values: F64, axis: int | None = None) -> F64:
    return np.asarray(np.sqrt(np.mean(values**2, axis=axis)))


def derive(outcome: Outcome) -> Sequence[Row]:
    """No further rows; writes the tracks that were asked for."""
    if outcome.params.tracks:
        file = Path(outcome.params.tracks)
        for place, (case, run) in enumerate(first_runs(outcome)):
            path = measures.beside(file, *case.values()) if place else file
            measures.write_csv(run.commanded.t_s, run.position, run.velocity, path)
    return ()


def first_runs(outcome: Outcome) -> list[tuple[dict[str, Value], Flown]]:
    """The first run of every case."""
    from uavbridge.experiments.runner import seeds_of

    out = []
    for case, _ in outcome.samples:
        seed = int(seeds_of(outcome.experiment, case, outcome.seed, 1)[0])
        out.append((dict(case), flown(case, outcome.params, seed)))
    return out


def plot(figure: Figure, outcome: Outcome) -> None:
    """Fig. 24: tracks flown, and one beside its command; Figs 25, 26: errors over time."""
    from uavbridge.experiments.chen import plots

    ground = terrains.terrain(outcome.params.terrain)
    plots.tracks(figure, first_runs(outcome), ground)


_TIMES = tuple(measures.EVERY_S * (1 + step) for step in range(int(_USUAL_S / measures.EVERY_S)))

EXPERIMENT = Experiment(
    name="chen-track",
    summary="planned tracks of a flock, and what fixed-wing aircraft make of them",
    source="Chen 2023, Figs 24-26",
    params=TrackParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=5,
    block=1,
    paired=("model",),
    axis=Axis("t_s", _TIMES),
    derive=derive,
    plot=plot,
)
