"""A mission's result from its recording, for the report of a flight that is over.

What no message says is derived where it can be: the recording of a killed process has no
summary, that of an onlooker has no scores of the judge's either. What cannot be is left open, and
said in ``MissionResult.notes``.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np

from planners.types import F64
from uavbridge.agent.phases import ENDED, Phase
from uavbridge.clock import to_s
from uavbridge.config import Mission
from uavbridge.config.radio import radio_of
from uavbridge.errors import ConfigError
from uavbridge.replay.opened import Opened, opened
from uavbridge.report.collected import Collected, Scores, derived_scores
from uavbridge.report.quantity import duration
from uavbridge.report.result import AgentResult, MissionResult, Series, TargetResult

LATE_US = 5_000_000  # a recorder that hears the first report later than this came in between
_ENDED = {phase.value for phase in ENDED}
_FAILED = Phase.FAILED.value
_INCOMPLETE = "the recording ends before the mission does"
_OVERHEARD = (
    "recorded from the bus: what each radio delivered, and what the planners decided, is not in it"
)


def recorded_result(
    path: Path, progress: Callable[[int], None] = lambda _t_us: None
) -> MissionResult:
    """The result of a recorded mission.

    Args:
        path: of ``mission.mcap``, or of the folder it lies in.
        progress: told the mission time as it reads.

    Raises:
        ConfigError: it is no recording, or not one that this version can read.
    """
    whole = opened(path)
    collected = Collected(whole)
    try:
        for message in whole.messages():
            progress(message.t_us)
            collected.take(message)
    except msgspec.DecodeError as error:
        raise ConfigError(f"{whole.recording.path}: a message does not read: {error}") from None
    return _result(collected, whole)


def _result(collected: Collected, whole: Opened) -> MissionResult:
    mission, summary, recording = whole.mission, collected.summary, whole.recording
    series = _series(collected.scores or derived_scores(whole))
    probability, stamp_us = collected.union.shown()
    targets, cells = _targets(mission, collected), set(mission.target_cells())
    found = sum(target.found_at_s is not None for target in targets)
    enough = _last(series.coverage) >= mission.coverage_goal
    separation = series.separation_m[np.isfinite(series.separation_m)]
    by_signal = mission.signals is not None
    false = {cell for cell in collected.declared if cell not in cells}
    return MissionResult(
        mission=mission.name,
        seed=whole.head.seed,
        clock=whole.head.clock,
        duration_s=to_s(collected.last_us),
        wall_s=summary.wall_s if summary else 0.0,
        reached_goal=_flown(collected, mission)
        if mission.only_flies
        else (enough or by_signal) and found == len(targets),
        grid=mission.grid,
        series=series,
        tracks={agent: collected.track(agent) for agent in sorted(collected.tracks)},
        belief=None if by_signal else probability,
        seen=None if by_signal else stamp_us >= 0,
        by_signal=by_signal,
        terrain=mission.terrain(),
        climb_rad=np.nan if mission.ground is None else mission.ground.beta_rad,
        planes=any(member.kind == "plane" for member in mission.team()),
        layers=dict(sorted(collected.layers.items())),
        columns=mission.all_columns(),
        alliances=None if collected.rosters is None else collected.rosters.alliances(),
        coverage=np.nan if by_signal else _last(series.coverage),
        uncertainty=np.nan if by_signal else _last(series.uncertainty),
        entropy=np.nan if by_signal else _last(series.entropy),
        targets=targets,
        false_targets=tuple(summary.false_targets) if summary else tuple(sorted(false)),
        agents=_agents(collected),
        radio=radio_of(mission).words(),
        min_separation_m=float(separation.min()) if len(separation) else np.nan,
        coverage_goal=np.nan if by_signal else mission.coverage_goal,
        separation_limit_m=mission.safety.separation_m if mission.safety.separation else np.nan,
        events=tuple(sorted(collected.events, key=lambda event: event.t_s)),
        failures=_failures(collected),
        notes=_notes(collected, whole),
        mission_text=whole.head.text,
        versions=whole.head.versions,
        repeat=f"uavbridge launch mission.toml --clock {mission.clock} --seed {mission.seed}",
        digest=recording.digest(),
        out=str(recording.path.parent),
        ticks=summary.ticks if summary else 0,
        late_ticks=summary.late_ticks if summary else 0,
    )


def _flown(collected: Collected, mission: Mission) -> bool:
    """Whether a team that had nothing to find flew on to the end."""
    phases = {report.phase for report in collected.reports.values()}
    return len(collected.reports) == mission.vehicles and phases == {Phase.ALOFT.value}


def _series(scores: Scores) -> Series:
    records = [record for _, record in scores]
    apart = [r.separation if isinstance(r.separation, float) else np.nan for r in records]
    return Series(
        np.array([to_s(t_us) for t_us, _ in scores]),
        np.array([r.coverage for r in records]),
        np.array([r.entropy for r in records]),
        np.array([r.uncertainty for r in records]),
        np.array([r.declared for r in records], dtype=np.int64),
        np.array(apart, dtype=np.float64),
    )


def _last(values: F64) -> float:
    return float(values[-1]) if len(values) else float("nan")


def _targets(mission: Mission, collected: Collected) -> tuple[TargetResult, ...]:
    if mission.signals is not None:
        return _reached(mission, collected)
    summary = collected.summary
    fates: dict[tuple[int, int], tuple[float | None, int | None]] = {
        cell: (to_s(t_us), by) for cell, (t_us, by) in collected.declared.items()
    }
    if summary is not None:
        fates |= {fate.cell: (fate.found_at_s, fate.by) for fate in summary.targets}
    places: dict[tuple[int, int], tuple[float, float]] = {}
    for target in mission.targets:
        column, row = mission.grid.cell_of(target.position).tolist()
        places.setdefault((column, row), target.position)
    return tuple(
        TargetResult(cell, *fates.get(cell, (None, None)), place) for cell, place in places.items()
    )


def _reached(mission: Mission, collected: Collected) -> tuple[TargetResult, ...]:
    """Targets that gave signals, each for itself."""
    results = []
    for number, target in enumerate(mission.targets):
        column, row = mission.grid.cell_of(target.position).tolist()
        t_us, by = collected.reached.get(number, (None, None))
        at_s = None if t_us is None else to_s(t_us)
        results.append(TargetResult((column, row), at_s, by, target.position))
    return tuple(results)


def _agents(collected: Collected) -> tuple[AgentResult, ...]:
    if collected.summary:
        return tuple(AgentResult(**msgspec.structs.asdict(a)) for a in collected.summary.agents)
    results = []
    for agent, report in sorted(collected.reports.items()):
        flown = np.linalg.norm(np.diff(collected.track(agent), axis=0), axis=1).sum()
        results.append(
            AgentResult(
                id=agent,
                state=report.phase,
                distance_m=report.distance_m or float(flown),
                frames_sent=report.frames_sent or collected.frames[agent],
                frames_heard=report.frames_heard,
                bytes_sent=report.bytes_sent or collected.frame_bytes[agent],
                bytes_heard=report.bytes_heard,
                bytes_offered=report.bytes_offered,
                map_bytes_sent=report.map_bytes_sent,
                dropped=report.dropped,
                dropped_bytes=report.dropped_bytes,
                rejected=report.rejected,
            )
        )
    return tuple(results)


def _failures(collected: Collected) -> tuple[str, ...]:
    if collected.summary:
        return tuple(collected.summary.failures)
    reports = collected.reports.values()
    failed = [
        f"agent {report.agent}: {report.failure or 'failed'}"
        for report in sorted(reports, key=lambda report: report.agent)
        if report.phase == _FAILED or report.failure
    ]
    ended = bool(reports) and all(report.phase in _ENDED for report in reports)
    return (*failed, *(() if ended else (_INCOMPLETE,)))


def _notes(collected: Collected, whole: Opened) -> tuple[str, ...]:
    notes = [_OVERHEARD] if whole.recording.from_bus else []
    first_us = collected.first_us
    if first_us is not None and first_us > LATE_US:
        past = (
            " (what was before is told by its judge)"
            if collected.scores and (collected.scores[0][0] < first_us - LATE_US)
            else ""
        )
        notes.append(f"it begins {duration(to_s(first_us))} into the mission{past}")
    return tuple(notes)
