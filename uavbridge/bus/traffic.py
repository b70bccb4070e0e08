"""What one agent sent and heard over one kind of radio."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field


@dataclass(slots=True)
class Traffic:
    """Counters of one agent; bytes are whole messages, header included.

    Attributes:
        frames_offered: what the agent wanted to send.
        frames_sent: what its radio had room for.
        frames_heard: what the radio delivered to it.
        map_bytes_sent: of what was sent, for cells and for finding out who lacks what.
        dropped: frames that did not reach it, by reason (``Verdict.reason``); "queue" also of
            its own, which its radio had no room for.
        dropped_bytes: the same in bytes.
    """

    frames_offered: int = 0
    bytes_offered: int = 0
    frames_sent: int = 0
    bytes_sent: int = 0
    map_bytes_sent: int = 0
    frames_heard: int = 0
    bytes_heard: int = 0
    dropped: Counter[str] = field(default_factory=Counter)
    dropped_bytes: Counter[str] = field(default_factory=Counter)

    def offer(self, size: int) -> None:
        """The agent wants to send a message of so many bytes."""
        self.frames_offered += 1
        self.bytes_offered += size

    def send(self, size: int) -> None:
        """It is on the air."""
        self.frames_sent += 1
        self.bytes_sent += size

    def hear(self, frames: int, size: int) -> None:
        """So many frames of so many bytes together were delivered."""
        self.frames_heard += frames
        self.bytes_heard += size

    def drop(self, reason: str, frames: int, size: int) -> None:
        """So many frames of so many bytes together were not."""
        self.dropped[reason] += frames
        self.dropped_bytes[reason] += size
