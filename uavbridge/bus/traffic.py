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
        dropped: what did not reach it, by reason (``Verdict.reason``); not the own frames.
    """

    frames_offered: int = 0
    bytes_offered: int = 0
    frames_sent: int = 0
    bytes_sent: int = 0
    frames_heard: int = 0
    bytes_heard: int = 0
    dropped: Counter[str] = field(default_factory=Counter)
