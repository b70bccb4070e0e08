"""Decisions as they are recorded, and compared when a recording is verified."""

from __future__ import annotations

from base64 import b64encode
from typing import Any

from planners.memory import dumps
from planners.types import FlySegment, FlyVelocity, Goal, GoTo
from uavbridge.agent.effects import Decided
from uavbridge.recording.topics import DecisionRecord


def decision_record(decided: Decided) -> DecisionRecord:
    """A decision's record."""
    kind, values, yaw, speed = _setpoint(decided.goal)
    return DecisionRecord(
        tick=decided.tick,
        position=decided.position.tolist(),
        velocity=decided.velocity.tolist(),
        heading=decided.heading_rad,
        setpoint=kind,
        values=values,
        yaw=yaw,
        speed=speed,
        payload=b64encode(decided.goal.payload).decode(),
        note=decided.goal.note,
        memory=_memory(decided.memory),
    )


def differences(recorded: DecisionRecord, again: DecisionRecord) -> list[str]:
    """The fields in which two decisions differ."""
    return [
        name
        for name in DecisionRecord.__struct_fields__
        if getattr(recorded, name) != getattr(again, name)
    ]


def _setpoint(goal: Goal) -> tuple[str, list[float], float | None, float | None]:
    setpoint = goal.setpoint
    if isinstance(setpoint, GoTo):
        return "goto", setpoint.position.tolist(), setpoint.yaw_rad, setpoint.speed_m_s
    if isinstance(setpoint, FlyVelocity):
        return "velocity", setpoint.velocity.tolist(), setpoint.yaw_rad, None
    assert isinstance(setpoint, FlySegment)
    return "segment", [*setpoint.start.tolist(), *setpoint.end.tolist()], None, setpoint.speed_m_s


def _memory(memory: Any) -> str:
    try:
        return b64encode(dumps(memory)).decode()
    except TypeError:  # a planner whose memory has no bytes flies, but cannot be verified
        return ""
