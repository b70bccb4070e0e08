"""What an earlier bridge left: a mission that a restarted one goes on with.

The vehicles were left to themselves: they hold, then return. The recording says how far the
mission was, what each agent had told the others, where each took off, and what its autopilot's
own safety net was before.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from uavbridge.agent.phases import Phase
from uavbridge.agent.report import decode as decode_report
from uavbridge.bus.wire import Frame, Vector
from uavbridge.bus.wire import decode as decode_frame
from uavbridge.config import Mission, parse
from uavbridge.errors import ConfigError
from uavbridge.mavlink.parameters import Kind
from uavbridge.recording.reader import Message, Recording
from uavbridge.recording.topics import EventRecord, MissionRecord, decode

NET = "net"  # kind of the event that keeps an autopilot's own settings
_ON_GROUND = frozenset({Phase.ARM.value, Phase.TAKEOFF.value})

Settings = dict[str, tuple[float, Kind]]


@dataclass(slots=True, eq=False)
class Earlier:
    """The part of a mission that was flown."""

    folder: Path
    mission: Mission
    epoch_ns: int
    part: int  # of the recording, to be written next
    t_us: int = 0  # mission time of the last message
    frames: dict[int, list[Frame]] = field(default_factory=dict)  # sent, by agent
    homes: dict[int, Vector] = field(default_factory=dict)
    nets: dict[int, Settings] = field(default_factory=dict)  # before the mission


def read_earlier(folder: Path) -> Earlier:
    """Read the recording of a bridge that is no more.

    Raises:
        ConfigError: there is none, or it can not be gone on with.
    """
    recording = Recording(folder)
    messages = recording.messages()
    head = next(messages, None)
    if head is None or head.topic != "mission":
        raise ConfigError(f"{recording.path}: does not begin with its mission")
    record = msgspec.json.decode(head.data, type=MissionRecord)
    mission = parse(record.text, str(recording.path))
    simulated = [m.id for m in mission.team() if mission.endpoint(m.id) is None]
    if mission.clock == "stepped" or simulated:
        raise ConfigError(
            f"{recording.path}: simulated vehicles ended with their bridge; only missions whose "
            "vehicles are all elsewhere can be resumed"
        )
    earlier = Earlier(folder, mission, recording.epoch_ns, max(recording.parts) + 1)
    for message in messages:
        _take(earlier, message)
    return earlier


def _take(earlier: Earlier, message: Message) -> None:
    earlier.t_us = max(earlier.t_us, message.t_us)
    space, _, name = message.topic.partition("/")
    if space == "air":
        frame = decode_frame(message.data)
        if frame is not None:
            earlier.frames.setdefault(frame.sender, []).append(frame)
    elif space == "state":
        report = decode_report(message.data)
        if report.phase in _ON_GROUND and not report.in_air:
            earlier.homes[int(name)] = report.position
    elif space == "event":
        event = decode(EventRecord, message.data)
        if event.kind == NET and isinstance(event.agent, int):
            earlier.nets[event.agent] = settings_of(event.text)


def text_of(settings: Settings) -> str:
    """An autopilot's settings as they are recorded."""
    rows = {name: (value, int(kind)) for name, (value, kind) in settings.items()}
    return msgspec.json.encode(rows).decode()


def settings_of(text: str) -> Settings:
    """Back from the recording."""
    rows = msgspec.json.decode(text, type=dict[str, tuple[float, int]])
    return {name: (value, Kind(kind)) for name, (value, kind) in rows.items()}
