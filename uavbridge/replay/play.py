"""A recording on the bus again, for any monitor."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import msgspec

from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.clock import Clock
from uavbridge.errors import ConfigError
from uavbridge.recording.reader import Message, Recording
from uavbridge.recording.topics import EventRecord, decode

_WORLD = {"mission": keys.MISSION, "truth": keys.TRUTH, "past": keys.PAST}
TILE = (0, 0)  # a monitor hears all tiles; which one it was is not recorded


def mission_name(path: Path) -> str:
    """The name of the mission that was recorded. Raises ConfigError for no recording."""
    name: str = Recording(path).mission_name
    return name


def play(
    path: Path,
    bus: Bus,
    clock: Clock,
    *,
    stop: Callable[[], bool] = lambda: False,
    progress: Callable[[int], None] = lambda _t_us: None,
) -> int:
    """Publish what was recorded when it is due again; the number of messages published.

    Args:
        path: of ``mission.mcap``, or of the folder it lies in.
        bus: of the mission's name.
        clock: begins with the replay; its speed is the replay's.
        stop: asked before each message.
        progress: told the mission time of each message.

    Raises:
        ConfigError: it is no recording.
    """
    recording = Recording(path)
    published = 0
    for message in recording.messages():
        if stop():
            break
        key = key_of(message)
        if key is None:
            continue
        clock.wait_until(message.t_us)
        progress(message.t_us)
        if key == keys.MISSION:
            text = message.data
            bus.serve(keys.MISSION, lambda _key, text=text: text)  # type: ignore[misc]
        bus.publish(key, message.data)
        published += 1
    if not published:
        raise ConfigError(f"{recording.path}: nothing in it to play")
    return published


def key_of(message: Message) -> str | None:
    """The key that a recorded message was published on; None for what never was."""
    space, _, name = message.topic.partition("/")
    if space == "air":
        return keys.air(TILE, name)
    if space == "state":
        return keys.state(name)
    if space == "cmd":
        return keys.cmd(name)
    if space == "layer":
        return message.topic
    if space == "fullmap":
        return keys.state_map(name)
    if space in _WORLD:
        return _WORLD[space]
    if space == "event":
        try:
            agent = decode(EventRecord, message.data).agent
        except msgspec.DecodeError:
            return None
        return keys.event(agent) if isinstance(agent, int) else None
    return None
