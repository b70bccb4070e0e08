"""Which experiments there are. Modules are imported when they are asked for."""

from __future__ import annotations

import importlib
from collections.abc import Mapping

from uavbridge.errors import ConfigError
from uavbridge.experiments.experiment import Experiment

# name: module under uavbridge.experiments that holds EXPERIMENT, or module:NAME
MODULES: Mapping[str, str] = {
    "khan-table1": "khan.table1",
    "khan-table2": "khan.table2",
    "khan-fig4": "khan.fig4",
    "khan-fig5": "khan.figures:FIG5",
    "khan-fig6": "khan.figures:FIG6",
    "khan-fig7": "khan.figures:FIG7",
    "khan-fig8": "khan.figures:FIG8",
    "khan-fig9": "khan.figures:FIG9",
    "khan-moving": "khan.moving",
    "khan-bandwidth": "khan.bandwidth",
    "merge-beyond": "khan.beyond",
    "merge-steers": "khan.steers",
    "liu-table2": "liu.table2",
    "liu-coverage": "liu.figures:COVERAGE",
    "liu-targets": "liu.figures:TARGETS",
    "liu-prior": "liu.prior",
    "liu-statistics": "liu.figures:STATISTICS",
    "liu-maps": "liu.figures:MAPS",
    "reality-gap": "comparison.gap",
    "chen-dubins": "chen.dubins",
    "chen-rrt": "chen.rrt",
    "chen-flock": "chen.flock",
    "chen-intruder": "chen.intruder",
    "chen-track": "chen.track",
    "zhou-table1": "zhou.table1",
    "zhou-table3": "zhou.table3",
    "zhou-table4": "zhou.table4",
    "zhou-trace": "zhou.trace",
    "zhou-radio": "zhou.radio",
    "zhou-energy": "zhou.energy",
    "shao-detect-50": "shao.detect50",
    "shao-detect-100": "shao.detect100",
    "shao-maps": "shao.maps",
    "shao-navigate": "shao.navigate",
    "shao-scenario": "shao.scenario",
    "shao-faults": "shao.faults",
    "shao-places": "shao.places",
}


def find(name: str) -> Experiment:
    """The experiment of that name.

    Raises:
        ConfigError: there is none.
    """
    if name not in MODULES:
        raise ConfigError(f"unknown experiment {name!r} (known: {', '.join(MODULES)})")
    module, _, attribute = MODULES[name].partition(":")
    found = importlib.import_module(f"uavbridge.experiments.{module}")
    experiment: Experiment = getattr(found, attribute or "EXPERIMENT")
    return experiment


def everyone() -> list[Experiment]:
    """All experiments, in the order of the list."""
    return [find(name) for name in MODULES]
