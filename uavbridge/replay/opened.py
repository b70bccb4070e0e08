"""A recording opened for its mission: by this version, or with the reason why not."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import msgspec

from uavbridge.config import Mission
from uavbridge.config.convert import convert
from uavbridge.config.field_error import FieldError, dotted
from uavbridge.config.load import placed
from uavbridge.errors import ConfigError
from uavbridge.recording.reader import Message, Recording
from uavbridge.recording.topics import MissionRecord, decode


@dataclass(frozen=True, slots=True)
class Opened:
    """A recording with its mission read.

    Attributes:
        recording: the file or files.
        head: its first message.
        mission: as it was flown, with the true targets; its planner need not be installed.
    """

    recording: Recording
    head: MissionRecord
    mission: Mission

    def messages(self) -> Iterator[Message]:
        """All that follows the mission."""
        messages = self.recording.messages()
        next(messages, None)
        return messages


def opened(path: Path) -> Opened:
    """Open a recording.

    Args:
        path: of ``mission.mcap``, or of the folder it lies in.

    Raises:
        ConfigError: it is no recording, or this version does not understand its mission.
    """
    recording = Recording(path)
    first = next(recording.messages(), None)
    if first is None or first.topic != "mission":
        raise ConfigError(f"{recording.path}: does not begin with its mission")
    try:
        head = decode(MissionRecord, first.data)
    except msgspec.DecodeError as error:
        raise ConfigError(f"{recording.path}: a message does not read: {error}") from None
    try:
        mission = placed(convert(tomllib.loads(head.text)), recording.path.parent)
    except (FieldError, ValueError, RecursionError) as fault:
        what = f"{dotted(fault.path)}: {fault}" if isinstance(fault, FieldError) else str(fault)
        by, ours = head.versions.get("uavbridge", "?"), version("uavbridge")
        raise ConfigError(
            f"{recording.path}: its mission does not read: {what} "
            f"(recorded by uavbridge {by}, this is {ours})"
        ) from None
    try:
        mission.terrain()
    except ValueError as fault:
        raise ConfigError(f"{recording.path}: its ground can not be read: {fault}") from None
    return Opened(recording, head, mission)
