"""From the judge's knowledge to what the live view shows."""

from __future__ import annotations

from math import nan

from uavbridge.clock import to_s
from uavbridge.config import Mission
from uavbridge.monitor.snapshot import (
    MissionFacts,
    Snapshot,
    VehicleLine,
    apart,
    dropped,
    rejected,
)
from uavbridge.runner.judge import Judge


def facts_of(mission: Mission) -> MissionFacts:
    """What does not change."""
    by_signal = mission.signals is not None
    return MissionFacts(
        name=mission.name,
        planner=mission.planner,
        seed=mission.seed,
        clock=mission.clock,
        duration_s=mission.duration,
        targets=len(mission.targets if by_signal else mission.target_cells()),
        by_signal=by_signal,
        coverage_goal=mission.coverage_goal,
        separation_limit_m=mission.safety.separation_m if mission.safety.separation else nan,
    )


def snapshot_of(t_us: int, judge: Judge) -> Snapshot:
    """The mission now."""
    last = judge.latest()
    reports = [judge.reports[agent] for agent in sorted(judge.reports)]
    return Snapshot(
        t_s=to_s(t_us),
        coverage=last.coverage,
        entropy=last.entropy,
        declared=last.found,
        separation_m=last.separation_m,
        closest_m=judge.separation.closest,
        frames_sent=sum(report.frames_sent for report in reports),
        bytes_sent=sum(report.bytes_sent for report in reports),
        frames_heard=sum(report.frames_heard for report in reports),
        bytes_heard=sum(report.bytes_heard for report in reports),
        dropped=dropped(reports),
        rejected=rejected(reports),
        clocks=apart(reports),
        vehicles=tuple(
            VehicleLine(
                id=report.agent,
                phase=report.phase,
                mode=report.mode,
                height_m=report.position[2],
                battery=nan if report.battery is None else report.battery,
                neighbours=report.neighbours,
                note=report.note,
            )
            for report in reports
        ),
        status=judge.verdict.value,
        alerts=tuple(
            f"agent {report.agent}: {report.failure}" for report in reports if report.failure
        )
        + tuple(f"agent {agent}: its process died" for agent in sorted(judge.dead)),
    )
