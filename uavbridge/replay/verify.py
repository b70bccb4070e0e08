"""Do the planners decide the same again on what a recording says they knew?

Each agent's hearing and map are put together anew from the frames that the radio
delivered to it and from its own readings, in recorded order; each decision is
taken again from the recorded own state and the recorded memory after the one
before, so that verifying may begin at any point.
"""

from __future__ import annotations

from base64 import b64decode
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from planners.memory import loads
from planners.planner import PlannerKind
from planners.types import Answer, Reading, Signal
from uavbridge.agent.agent import Sensed, view_of
from uavbridge.agent.effects import Decided
from uavbridge.agent.hearing import Hearing
from uavbridge.agent.mapping import Mapping
from uavbridge.agent.plan import AgentPlan
from uavbridge.bus.messages import Obstacle
from uavbridge.bus.wire import Frame, decode
from uavbridge.clock import to_s, to_us
from uavbridge.errors import ConfigError, UavbridgeError
from uavbridge.recording.decisions import decision_record, differences
from uavbridge.recording.parts import MCAP_NAME
from uavbridge.recording.reader import Message
from uavbridge.recording.topics import (
    AnswerRecord,
    DecisionRecord,
    ObstacleRecord,
    ReadingRecord,
    SignalRecord,
    unpack_heard,
)
from uavbridge.recording.topics import decode as decode_record
from uavbridge.replay.opened import opened
from uavbridge.rng import stream
from uavbridge.runner import assemble
from uavbridge.runner.crew import FOLDER

DELIVERED = 0  # outcome code in ``heard``
FRAMES_KEPT = 200_000  # then the older half goes: no radio is so slow


@dataclass(frozen=True, slots=True)
class Verified:
    """What came of it."""

    decisions: int  # taken again
    difference: str = ""  # the first one that is not as recorded; empty: none

    @property
    def ok(self) -> bool:
        """Every decision was taken again as recorded."""
        return not self.difference


@dataclass(slots=True, eq=False)
class _Mind:
    """What one agent knew."""

    plan: AgentPlan
    mapping: Mapping
    hearing: Hearing = field(default_factory=Hearing)
    sensed: Sensed = field(default_factory=Sensed)
    memory: str = ""  # after the decision before, as recorded


class _DiffersError(UavbridgeError):
    """A decision is not as recorded."""


def verify(
    path: Path,
    *,
    from_s: float = 0.0,
    kind: PlannerKind | None = None,
    progress: Callable[[int], None] = lambda _t_us: None,
) -> Verified:
    """Take the decisions of a recording again.

    Those of agents that flew in processes of their own are in recordings of their own, below
    the launcher's: they are taken again one after the other.

    Args:
        path: of ``mission.mcap``, or of the folder it lies in.
        from_s: mission time from which on decisions are compared.
        kind: the planner; None: the installed one that the mission names.
        progress: told the mission time as it goes.

    Raises:
        ConfigError: no recording, its planner is not there, or there is nothing to verify.
    """
    return _verified(path, from_s, kind, progress, {})


def _verified(
    path: Path,
    from_s: float,
    kind: PlannerKind | None,
    progress: Callable[[int], None],
    frames: dict[tuple[int, int], Frame],
) -> Verified:
    """``verify``, with the frames that other recordings of the flight hold."""
    whole = opened(path)
    if not whole.recording.from_start:
        raise ConfigError(f"{path}: is not the first part: what was known before it is missing")
    mission = whole.mission
    planner = assemble.planner_of(mission, kind)
    plans = assemble.agent_plans(mission.for_agents(), planner)
    minds = {plan.agent: _Mind(plan, Mapping(plan)) for plan in plans}
    taken = 0
    try:
        for message in whole.messages():
            progress(message.t_us)
            taken += _take(message, minds, frames, to_us(from_s))
    except _DiffersError as difference:
        return Verified(taken, str(difference))
    except (ValueError, KeyError, TypeError) as fault:  # msgspec's are ValueErrors
        raise ConfigError(f"{path}: {message.topic} at {to_s(message.t_us):g} s: {fault}") from None
    apart = sorted((whole.recording.path.parent / FOLDER).glob(f"*/{MCAP_NAME}"))
    if not taken and apart:
        return _verify_apart(apart, from_s, kind, progress, frames)
    if not taken:
        what = (
            "it was recorded from the bus" if whole.recording.from_bus else f"from {from_s:g} s on"
        )
        raise ConfigError(f"{path}: holds no decisions to verify: {what}")
    return Verified(taken)


def _verify_apart(
    paths: list[Path],
    from_s: float,
    kind: PlannerKind | None,
    progress: Callable[[int], None],
    frames: dict[tuple[int, int], Frame],
) -> Verified:
    """What each process took down of its own, with the frames that the launcher has of all."""
    taken = 0
    for path in paths:
        result = _verified(path, from_s, kind, progress, dict(frames))
        taken += result.decisions
        if not result.ok:
            return Verified(taken, result.difference)
    return Verified(taken)


def _take(
    message: Message, minds: dict[int, _Mind], frames: dict[tuple[int, int], Frame], from_us: int
) -> int:
    """One recorded message; 1 when it was a decision that was compared."""
    space, _, name = message.topic.partition("/")
    if space == "air":
        frame = decode(message.data)
        if frame is not None:
            frames[frame.sender, frame.tick] = frame
        if len(frames) > FRAMES_KEPT:
            for old in list(frames)[: FRAMES_KEPT // 2]:
                del frames[old]
    elif space == "heard":
        _hear(minds[int(name)], message.data, frames)
    elif space == "obs":
        record = decode_record(ReadingRecord, message.data)
        reading = Reading(record.taken_us, (record.column, record.row), record.detected)
        mind = minds[int(name)]
        mind.mapping.observe(reading)
        mind.sensed.readings.append(reading)
    elif space == "signal":
        heard = decode_record(SignalRecord, message.data)
        signal = Signal(heard.taken_us, heard.target, heard.strength, heard.arrived)
        minds[int(name)].sensed.signals.append(signal)
    elif space == "obstacle":
        seen = decode_record(ObstacleRecord, message.data)
        column = Obstacle(seen.number, seen.x, seen.y, seen.radius_m, seen.room_m)
        minds[int(name)].mapping.obstacles.learn([column])
    elif space == "answer":
        told = decode_record(AnswerRecord, message.data)
        answer = Answer(told.key, b64decode(told.data), told.age_s)
        minds[int(name)].sensed.answers.append(answer)
    elif space == "decision":
        decision = decode_record(DecisionRecord, message.data)
        return _decide(minds[int(name)], message.t_us, decision, message.t_us >= from_us)
    return 0


def _hear(mind: _Mind, data: bytes, frames: dict[tuple[int, int], Frame]) -> None:
    rows = unpack_heard(data)
    keys = rows[rows["outcome"] == DELIVERED][["sender", "tick"]].tolist()
    heard = [frames[key] for key in keys if key in frames]
    for frame in heard:
        mind.hearing.frame(frame)
    mind.mapping.merge(heard)


def _decide(mind: _Mind, t_us: int, recorded: DecisionRecord, compare: bool) -> int:
    plan = mind.plan
    position, velocity = np.array(recorded.position), np.array(recorded.velocity)
    own = (position, velocity, recorded.heading)
    if compare:
        view = view_of(plan, recorded.tick, t_us, own, mind.hearing, mind.mapping, mind.sensed)
        rng = stream(plan.seed, "planner", plan.agent, recorded.tick)
        memory = _memory(mind, view, recorded)
        try:
            goal, memory = plan.planner.plan(view, memory, rng)
        except Exception as fault:  # noqa: BLE001 - other people's planners may raise anything
            raise _DiffersError(
                f"agent {plan.agent}, decision {recorded.tick} at {to_s(t_us):.1f} s: "
                f"the planner raised {type(fault).__name__}: {fault}"
            ) from None
        again = decision_record(
            Decided(recorded.tick, position, velocity, recorded.heading, goal, memory)
        )
        if differing := differences(recorded, again):
            name = differing[0]
            raise _DiffersError(
                f"agent {plan.agent}, decision {recorded.tick} at {to_s(t_us):.1f} s: {name} "
                f"recorded {getattr(recorded, name)!r}, decided {getattr(again, name)!r}"
            )
    mind.sensed = Sensed()
    mind.memory = recorded.memory
    return int(compare)


def _memory(mind: _Mind, view: Any, recorded: DecisionRecord) -> Any:
    """The memory with which a decision was taken: the one after the decision before."""
    initial = mind.plan.planner.init(view)
    if recorded.tick == 0 or initial is None:
        return initial
    if not mind.memory:
        raise ConfigError("this planner's memory has no bytes: its decisions cannot be verified")
    return loads(type(initial), b64decode(mind.memory))
