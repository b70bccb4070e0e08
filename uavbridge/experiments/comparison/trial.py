"""How one mission went, in figures that all fidelities share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from planners.flocking.starling import goals
from planners.types import F64, Bools, Neighbours
from uavbridge.config import Mission
from uavbridge.radio.radio import Radio

Cell: TypeAlias = tuple[int, int]
Until: TypeAlias = Literal["goal", "named"]  # a search ends: mission's goal, or any cell declared

CURVES = (
    "coverage",
    "entropy",
    "uncertainty",
    "targets_found",
    "components",
    "age_s",
    "bytes_per_agent",
    "separation_m",
    "polarisation",
)
SAMPLES = 61  # points of a curve over the mission's time limit


@dataclass(slots=True)
class Trial:
    """One mission, sampled once a second from the start of the search on.

    Attributes:
        duration_s: the mission's time limit.
        t_s: times of the samples.
        curves: by name, a value a sample: coverage (share of the cells seen), entropy and
            one-sided uncertainty (bit) of the union of maps, true targets declared, groups that
            can reach each other by radio, mean age of what is known of another agent's position,
            bytes sent an agent; least distance of two vehicles (NaN: there is one) and how much all
            fly one way (0 to 1).
        goal_s: when every target was declared and enough seen, or every target's signal was
            followed to it; NaN: never.
        covered_s: when enough was seen; NaN: never.
        declared: cells that some agent declared, and when it first did.
        false_targets: how many of them hold none.
    """

    duration_s: float
    t_s: list[float] = field(default_factory=list)
    curves: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in CURVES})
    goal_s: float = float("nan")
    covered_s: float = float("nan")
    declared: dict[Cell, float] = field(default_factory=dict)
    false_targets: int = 0

    def over(self, until: Until) -> bool:
        """Whether what was searched for is there."""
        return bool(self.declared) if until == "named" else not np.isnan(self.goal_s)

    def declare(self, declared: Mapping[Cell, float], mission: Mission) -> None:
        """All cells declared so far, with their times (s)."""
        self.declared = dict(declared)
        targets = mission.target_cells()
        self.false_targets = sum(cell not in targets for cell in declared)

    def add(self, t_s: float, mission: Mission, values: Mapping[str, float]) -> None:
        """One sample."""
        self.t_s.append(t_s)
        for name in CURVES:
            self.curves[name].append(values[name])
        by_signal = mission.signals is not None
        covered = not by_signal and values["coverage"] >= mission.coverage_goal
        if covered and np.isnan(self.covered_s):
            self.covered_s = t_s
        sought = len(mission.targets) if by_signal else len(mission.target_cells())
        found = values["targets_found"] >= sought
        if (covered or by_signal) and found and np.isnan(self.goal_s):
            self.goal_s = t_s

    def figures(self) -> dict[str, float]:
        """Numbers of this mission."""
        return {
            "goal_s": self.goal_s,
            "coverage_s": self.covered_s,
            "coverage": self.curves["coverage"][-1],
            "targets_found": self.curves["targets_found"][-1],
            "false_targets": float(self.false_targets),
            "entropy": self.curves["entropy"][-1],
            "uncertainty": self.curves["uncertainty"][-1],
            "components": float(np.mean(self.curves["components"])),
            "age_s": float(np.mean(self.curves["age_s"])),
            "min_separation_m": float(np.min(self.curves["separation_m"])),
            "polarisation": self.curves["polarisation"][-1],
            "bytes_per_agent": self.curves["bytes_per_agent"][-1],
            "bytes_per_agent_s": self.curves["bytes_per_agent"][-1] / max(self.t_s[-1], 1.0),
        }

    def resampled(self) -> dict[str, F64]:
        """Curves (SAMPLES,) over the time limit; after the end the last value stays."""
        at = np.linspace(0.0, self.duration_s, SAMPLES)
        place = np.searchsorted(self.t_s, at, side="right") - 1
        place = np.maximum(place, 0)
        return {name: np.array(values)[place] for name, values in self.curves.items()}


def motion(position: F64, velocity: F64) -> dict[str, float]:
    """Curves of how vehicles at positions (n, 3) m with velocities (n, 3) m/s fly together."""
    apart = goals.separation(position) if len(position) > 1 else np.nan
    return {"separation_m": float(apart), "polarisation": float(goals.polarisation(velocity))}


def components(position: F64, radio: Radio) -> int:
    """Groups of agents at positions (n, 3) m that can reach each other, also by others."""
    reach: Bools = radio.reaches(position[:, None, :], position[None, :, :])
    group = np.arange(len(position))
    for _ in range(len(position)):
        least = np.where(reach, group[None, :], len(position)).min(axis=1)
        if (least == group).all():
            break
        group = least
    return len(set(group.tolist()))


class Ages:
    """How old what each agent knows of each other's position is.

    Args:
        team: ids, ascending.
    """

    def __init__(self, team: tuple[int, ...]) -> None:
        self._row = {agent: row for row, agent in enumerate(team)}
        self._last_s = np.zeros((len(team), len(team)))  # the newest that a row knows of a column

    def heard(self, agent: int, heard: Neighbours, t_s: float) -> None:
        """What one agent knows at a time since the search began."""
        columns = [self._row[other] for other in heard.ids.tolist()]
        row = self._last_s[self._row[agent]]
        row[columns] = np.maximum(row[columns], t_s - heard.age_s)

    def mean(self, t_s: float) -> float:
        """Mean age (s) over all pairs; who was never heard was last known at the start."""
        others = ~np.eye(len(self._row), dtype=np.bool_)
        return float((t_s - self._last_s[others]).mean()) if others.any() else 0.0
