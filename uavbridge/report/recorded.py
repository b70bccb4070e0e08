"""A mission's result from its recording, for the report of a flight that is over.

The recording of a process that was killed gives what there is: no summary, so
the agents' accounts come from the frames that they sent.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import numpy as np

from planners.belief.merge import MERGE_RULES, BeliefMap, MergeRule, SensorModel, unpack
from planners.types import F64
from uavbridge.agent.phases import Phase
from uavbridge.agent.report import AgentReport
from uavbridge.bus.wire import decode as decode_frame
from uavbridge.clock import to_s
from uavbridge.config import Mission, parse
from uavbridge.errors import ConfigError
from uavbridge.recording.reader import Message, Recording
from uavbridge.recording.topics import EventRecord, MissionRecord, ScoreRecord, decode
from uavbridge.report.result import AgentResult, Event, MissionResult, Series, TargetResult
from uavbridge.report.summary import Summary

_CONNECT = Phase.CONNECT.value
_INCOMPLETE = "the recording ends before the mission does"


@dataclass(slots=True)
class _Collected:
    """What the messages of one recording said."""

    mission: Mission
    head: MissionRecord
    rule: MergeRule
    belief: BeliefMap
    last_us: int = 0
    scores: list[tuple[int, ScoreRecord]] = field(default_factory=list)
    states: dict[int, list[AgentReport]] = field(default_factory=dict)
    events: list[Event] = field(default_factory=list)
    frames: Counter[int] = field(default_factory=Counter)
    frame_bytes: Counter[int] = field(default_factory=Counter)
    summary: Summary | None = None


def recorded_result(path: Path) -> MissionResult:
    """The result of a recorded mission.

    Args:
        path: of ``mission.mcap``, or of the folder it lies in.

    Raises:
        ConfigError: it is no recording, or not one that this version can read.
    """
    recording = Recording(path)
    try:
        collected = _collect(recording)
    except msgspec.DecodeError as error:
        raise ConfigError(f"{recording.path}: a message does not read: {error}") from None
    return _result(collected, recording)


def _collect(recording: Recording) -> _Collected:
    messages = recording.messages()
    first = next(messages, None)
    if first is None or first.topic != "mission":
        raise ConfigError(f"{recording.path}: does not begin with its mission")
    head = decode(MissionRecord, first.data)
    mission = parse(head.text, str(recording.path))
    rule = MERGE_RULES[mission.belief.merge]
    prior = np.full(mission.grid.shape, mission.belief.prior)
    sensor = SensorModel(mission.sensor.p, mission.sensor.q, mission.belief.update)
    belief = rule.onlooker.empty(mission.grid, prior, sensor)
    collected = _Collected(mission, head, rule, belief)
    for message in messages:
        _take(collected, message)
    return collected


def _take(collected: _Collected, message: Message) -> None:
    kind, _, name = message.topic.partition("/")
    t_us, data = message.t_us, message.data
    collected.last_us = max(collected.last_us, t_us)
    if kind == "score":
        collected.scores.append((t_us, decode(ScoreRecord, data)))
    elif kind == "state":
        states = collected.states.setdefault(int(name), [])
        states.append(decode(AgentReport, data))
    elif kind == "event":
        record = decode(EventRecord, data)
        agent = record.agent if isinstance(record.agent, int) else None
        collected.events.append(Event(to_s(t_us), record.text, agent, record.kind))
    elif kind == "air":
        collected.frames[int(name)] += 1
        collected.frame_bytes[int(name)] += len(data)
        _merge(collected, data)
    elif kind == "summary":
        collected.summary = decode(Summary, data)


def _merge(collected: _Collected, data: bytes) -> None:
    frame = decode_frame(data)
    if frame is None or frame.rule != collected.rule.code:
        return
    records = unpack(collected.rule, frame.cells)
    if records is not None and len(records):
        collected.belief, _ = collected.rule.onlooker.merge(collected.belief, records)


def _result(collected: _Collected, recording: Recording) -> MissionResult:
    mission, summary = collected.mission, collected.summary
    series = _series(collected.scores)
    found = int(series.declared[-1]) if len(series.declared) else 0
    reached = (
        found == len(mission.target_cells()) and _last(series.coverage) >= mission.coverage_goal
    )
    separation = series.separation_m[np.isfinite(series.separation_m)]
    return MissionResult(
        mission=mission.name,
        seed=collected.head.seed,
        clock=collected.head.clock,
        duration_s=to_s(collected.last_us),
        wall_s=summary.wall_s if summary else 0.0,
        reached_goal=reached,
        grid=mission.grid,
        series=series,
        tracks={agent: _track(states) for agent, states in sorted(collected.states.items())},
        belief=collected.belief.probability,
        seen=collected.belief.seen,
        coverage=_last(series.coverage),
        uncertainty=_last(series.uncertainty),
        entropy=_last(series.entropy),
        targets=_targets(mission, summary),
        false_targets=tuple(summary.false_targets) if summary else (),
        agents=_agents(collected),
        min_separation_m=float(separation.min()) if len(separation) else np.nan,
        coverage_goal=mission.coverage_goal,
        separation_limit_m=mission.safety.separation_m if mission.safety.separation else np.nan,
        events=tuple(collected.events),
        failures=tuple(summary.failures) if summary else (_INCOMPLETE,),
        mission_text=collected.head.text,
        versions=collected.head.versions,
        digest=recording.digest(),
        out=str(recording.path.parent),
    )


def _series(scores: list[tuple[int, ScoreRecord]]) -> Series:
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


def _track(states: list[AgentReport]) -> F64:
    """(k, 3) from where the vehicle's position was known."""
    known = [state.position for state in states if state.phase != _CONNECT]
    return np.array(known, dtype=np.float64).reshape(-1, 3)


def _last(values: F64) -> float:
    return float(values[-1]) if len(values) else float("nan")


def _targets(mission: Mission, summary: Summary | None) -> tuple[TargetResult, ...]:
    fates = {fate.cell: fate for fate in summary.targets} if summary else {}
    places: dict[tuple[int, int], tuple[float, float]] = {}
    for target in mission.targets:
        column, row = mission.grid.cell_of(target.position).tolist()
        places.setdefault((column, row), target.position)
    return tuple(
        TargetResult(cell, fate.found_at_s, fate.by, place)
        if (fate := fates.get(cell))
        else TargetResult(cell, position=place)
        for cell, place in places.items()
    )


def _agents(collected: _Collected) -> tuple[AgentResult, ...]:
    if collected.summary:
        return tuple(AgentResult(**msgspec.structs.asdict(a)) for a in collected.summary.agents)
    return tuple(
        AgentResult(
            id=agent,
            state=states[-1].phase,
            distance_m=float(np.linalg.norm(np.diff(_track(states), axis=0), axis=1).sum()),
            frames_sent=collected.frames[agent],
            bytes_sent=collected.frame_bytes[agent],
        )
        for agent, states in sorted(collected.states.items())
    )
