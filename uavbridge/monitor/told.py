"""What is told to people as JSON, read: what does not read is counted and is None."""

from __future__ import annotations

import logging
import tomllib
from collections import Counter
from collections.abc import Callable
from math import isfinite
from typing import TypeVar

from msgspec import DecodeError
from msgspec.json import Decoder

from planners.terrain import Terrain
from uavbridge.agent.orders import Ack, decode_ack
from uavbridge.agent.report import AgentReport
from uavbridge.agent.report import decode as decode_report
from uavbridge.bus.text import read
from uavbridge.bus.wire import POSITION_LIMIT_M
from uavbridge.config import Mission
from uavbridge.config.convert import convert
from uavbridge.config.field_error import FieldError
from uavbridge.monitor.past import Past
from uavbridge.monitor.past import decode as decode_past
from uavbridge.recording.topics import EventRecord, MissionRecord
from uavbridge.recording.topics import decode as decode_record

_log = logging.getLogger(__name__)
T = TypeVar("T")
Rejects = Counter[str]

_ANYTHING = Decoder(dict[str, object])


def report_of(data: bytes, rejects: Rejects) -> AgentReport | None:
    """What an agent says of itself, if it can be."""
    report = _read(decode_report, "report", data, rejects)
    if report is not None and not _possible(report):
        rejects["report"] += 1
        return None
    return report


def event_of(data: bytes, rejects: Rejects) -> EventRecord | None:
    """What happened to an agent."""
    return _read(lambda data: decode_record(EventRecord, data), "event", data, rejects)


def ack_of(data: bytes, rejects: Rejects) -> Ack | None:
    """An agent's answer to an order."""
    return _read(decode_ack, "ack", data, rejects)


def past_of(data: bytes, rejects: Rejects) -> Past | None:
    """What was before we came."""
    return _read(decode_past, "past", data, rejects)


def verb_of(data: bytes, rejects: Rejects) -> str | None:
    """The word of an order, whether an agent would know it or not."""
    order = _read(lambda data: read(_ANYTHING, data), "order", data, rejects)
    return None if order is None else str(order.get("order", ""))


def mission_of(
    data: bytes, rejects: Rejects, known: MissionRecord | None
) -> tuple[MissionRecord, Mission] | None:
    """The mission as it is flown; None too where it is the one known already."""
    record = _read(lambda data: decode_record(MissionRecord, data), "mission", data, rejects)
    if record is None or (known is not None and record.text == known.text):
        return None
    try:
        # Not ``config.parse``: the planner need not be installed where people watch.
        return record, convert(tomllib.loads(record.text))
    except (ValueError, FieldError, RecursionError):
        rejects["mission"] += 1
        return None


def terrain_of(mission: Mission) -> Terrain | None:
    """The ground, where it is known here: its file may be on the machine that flies alone."""
    try:
        return mission.terrain()
    except ValueError as fault:
        _log.info("no terrain: %s", fault)
        return None


def _read(decode: Callable[[bytes], T], what: str, data: bytes, rejects: Rejects) -> T | None:
    try:
        return decode(data)
    except DecodeError:
        rejects[what] += 1
        return None


def _possible(report: AgentReport) -> bool:
    numbers = (*report.position, *report.velocity, report.heading, report.distance_m)
    return all(isfinite(n) and abs(n) <= POSITION_LIMIT_M for n in numbers) and report.t_us >= 0
