"""The metrics of Liu 2022 from a batch of runs, and how its experiments get the runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planners.types import F64, I64
from uavbridge.errors import ConfigError
from uavbridge.experiments.experiment import READING, Axis, Case, Samples, generators
from uavbridge.experiments.liu.methods import method
from uavbridge.experiments.liu.setting import TARGETS, Cell, LiuParams
from uavbridge.experiments.liu.world import Course, search


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """What is expected before the search."""

    map: F64  # (columns, rows)
    keys: Mapping[str, Any]  # the same, as keys of a mission's [belief]


CURVE = Axis("cycle", tuple(range(0, 201, 5)))


def course(case: Case, params: LiuParams, seeds: I64, fidelity: str = "ideal") -> Course:
    """Runs of the case ``{"method": ..., "targets": ...}``, with its reading if it names one."""
    read = reading(params, str(case[READING])) if READING in case else params
    targets = TARGETS if case["targets"] else ()
    return runs(str(case["method"]), read, seeds, targets, None, fidelity)


def runs(
    name: str,
    params: LiuParams,
    seeds: I64,
    targets: Sequence[Cell],
    prior: Prior | None,
    fidelity: str,
) -> Course:
    """Runs of one method in one fidelity; arguments as of ``world.search``."""
    if fidelity == "mavlink":
        from uavbridge.experiments.liu import missions

        if params.stop != "never":
            raise ConfigError("missions do not stop early: stop must stay never")
        start = None if prior is None else missions.belief_of(params, **prior.keys)
        return missions.fly(name, params, seeds, targets, start)
    start_map = None if prior is None else prior.map
    if fidelity == "dynamics":
        from uavbridge.experiments.liu.flown import FlownWorld

        flown = method(name, params, flown=True)
        return search(flown, params, generators(seeds), targets, start_map, FlownWorld)
    return search(method(name, params), params, generators(seeds), targets, start_map)


def reading(params: LiuParams, label: str) -> LiuParams:
    """The parameters with one changed: "speed_reading=norm"."""
    name, _, text = label.partition("=")
    kind = type(getattr(params, name))
    return replace(params, **{name: kind(text)})


def numbers(course: Course, params: LiuParams) -> Samples:
    """Figures at the last cycle, and when things were reached; NaN where they were not."""
    found = course.found >= 0
    order = np.sort(np.where(found, course.found, np.inf), axis=-1)
    samples = {
        "visited_cells": course.visited[:, -1].astype(np.float64),
        "uncertainty": course.uncertainty[:, -1],
        "entropy": course.entropy[:, -1],
        "coverage_cycle": _or_nan(course.covered),
    }
    if found.shape[1]:
        samples["targets_found"] = found.sum(axis=-1).astype(np.float64)
    for place in range(found.shape[1]):
        at = order[:, place]
        samples[f"target_{place + 1}_cycle"] = np.where(np.isfinite(at), at, np.nan)
    if params.stop != "never":
        samples["stop_cycle"] = _or_nan(course.stopped)
    return samples


def curves(course: Course, names: Sequence[str]) -> Samples:
    """Named figures over time (runs, len(CURVE.values)); the last is repeated where runs end."""
    cycles = np.array(CURVE.values)
    places = np.minimum(cycles, course.visited.shape[1] - 1)
    every = {
        "visited_cells": course.visited[:, places],
        "uncertainty": course.uncertainty[:, places],
        "entropy": course.entropy[:, places],
        "targets_found": _found_by(course, cycles),
    }
    return {f"{name}@cycle": np.asarray(every[name], dtype=np.float64) for name in names}


def _found_by(course: Course, cycles: I64) -> I64:
    """Targets (runs, len(cycles)) found by each cycle."""
    known = (course.found >= 0)[..., None] & (course.found[..., None] <= cycles)
    return np.asarray(known.sum(axis=1))


def _or_nan(cycle: I64) -> F64:
    return np.where(cycle >= 0, cycle, np.nan)
