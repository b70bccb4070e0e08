"""From what the judge saw to the mission's result."""

from __future__ import annotations

import platform
import sys
from dataclasses import dataclass
from importlib.metadata import version
from math import nan
from typing import Any

import numpy as np

from uavbridge.agent.report import AgentReport, Clocks
from uavbridge.clock import to_s
from uavbridge.config import to_toml
from uavbridge.config.radio import radio_of
from uavbridge.report.result import AgentResult, Event, MissionResult, Series, TargetResult
from uavbridge.runner.judge import Found, Judge
from uavbridge.runner.ticks import Punctuality

DEAD = "dead"  # state of an agent whose process died and did not come back
PACKAGES = ("uavbridge", "numpy", "pymavlink", "eclipse-zenoh", "mcap")


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a launch ended."""

    summary: dict[str, Any]  # the document of --json
    text: str  # one screen for people
    exit_status: int  # 0 when the mission did what it was asked


def versions() -> dict[str, str]:
    """Of everything that a result may depend on."""
    found = {name: version(name) for name in PACKAGES}
    return {**found, "python": platform.python_version(), "platform": sys.platform}


def result_of(
    judge: Judge,
    *,
    duration_us: int,
    wall_s: float,
    out: str,
    digest: str,
    events: list[Event],
    kept: Punctuality | None = None,
) -> MissionResult:
    """Everything a report needs."""
    mission = judge.mission
    samples, by_signal = judge.samples, mission.signals is not None
    targets = [
        TargetResult(
            cell,
            None if found is None else to_s(found.t_us),
            None if found is None else found.by,
            target,
        )
        for target, cell, found in _targets(judge)
    ]
    cells = {target.cell for target in targets}
    last = judge.latest()
    return MissionResult(
        mission=mission.name,
        seed=mission.seed,
        clock=mission.clock,
        duration_s=to_s(duration_us),
        wall_s=wall_s,
        reached_goal=judge.goal_reached,
        grid=mission.grid,
        series=Series(
            np.array([to_s(s.t_us) for s in samples]),
            np.array([s.coverage for s in samples]),
            np.array([s.entropy for s in samples]),
            np.array([s.uncertainty for s in samples]),
            np.array([s.found for s in samples], dtype=np.int64),
            np.array([s.separation_m for s in samples]),
        ),
        tracks={agent: judge.track(agent) for agent in mission.scenario().team},
        belief=None if by_signal else judge.union.probability,
        seen=None if by_signal else judge.union.seen,
        by_signal=by_signal,
        terrain=mission.terrain(),
        climb_rad=nan if mission.ground is None else mission.ground.beta_rad,
        planes=any(member.kind == "plane" for member in mission.team()),
        layers=dict(sorted(judge.layers.items())),
        columns=mission.all_columns(),
        alliances=None if judge.rosters is None else judge.rosters.alliances(),
        coverage=nan if by_signal else judge.seen_share,
        uncertainty=nan if by_signal else last.uncertainty,
        entropy=nan if by_signal else last.entropy,
        targets=tuple(targets),
        false_targets=tuple(sorted(cell for cell in judge.declared if cell not in cells)),
        agents=_agents(judge),
        radio=radio_of(mission).words(),
        min_separation_m=judge.separation.closest,
        coverage_goal=nan if by_signal else mission.coverage_goal,
        separation_limit_m=mission.safety.separation_m if mission.safety.separation else np.nan,
        events=tuple(events),
        failures=judge.failures(),
        mission_text=to_toml(mission),
        versions=versions(),
        repeat=f"uavbridge launch mission.toml --clock {mission.clock} --seed {mission.seed}",
        digest=digest,
        out=out,
        ticks=kept.ticks if kept else 0,
        late_ticks=kept.late if kept else 0,
    )


def _targets(judge: Judge) -> list[tuple[tuple[float, float], tuple[int, int], Found | None]]:
    """Position and cell of each target, and who found it; one a cell, where cells are looked at."""
    mission = judge.mission
    places = [target.position for target in mission.targets]
    cells = [tuple(mission.grid.cell_of(place).tolist()) for place in places]
    if mission.signals is not None:
        return [
            (place, cell, judge.reached.get(number))
            for number, (place, cell) in enumerate(zip(places, cells, strict=True))
        ]
    by_cell: dict[tuple[int, int], tuple[float, float]] = {}
    for place, cell in zip(places, cells, strict=True):
        by_cell.setdefault(cell, place)
    return [(place, cell, judge.declared.get(cell)) for cell, place in by_cell.items()]


def _agents(judge: Judge) -> tuple[AgentResult, ...]:
    results = []
    for agent in judge.mission.scenario().team:
        report = judge.reports.get(agent)
        if report is None:
            results.append(AgentResult(agent, "silent"))
            continue
        results.append(
            AgentResult(
                agent,
                DEAD if agent in judge.dead else report.phase,
                report.distance_m,
                report.frames_sent,
                report.frames_heard,
                report.bytes_sent,
                report.bytes_heard,
                report.bytes_offered,
                report.map_bytes_sent,
                report.dropped,
                report.dropped_bytes,
                report.rejected,
                **_clocks(report),
            )
        )
    return tuple(results)


def _clocks(report: AgentReport) -> dict[str, float]:
    known = report.clocks
    if not isinstance(known, Clocks):
        return {}
    return {
        "clock_offset_s": known.offset_s,
        "clock_error_s": known.error_s,
        "date_offset_s": known.date_offset_s,
    }
