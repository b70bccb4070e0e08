"""How good links are: one set of numbers for all, and what is different on some."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from math import inf, isinf

import numpy as np

from planners.types import F64, I64


@dataclass(frozen=True, slots=True, kw_only=True)
class Quality:
    """What a link does to what is sent.

    Attributes:
        range_m: longest link, inclusive, straight-line distance; infinity: unlimited.
        loss: probability that a frame is lost, each by itself.
        burst_enter: probability a tick that a burst of losses begins (Gilbert-Elliott).
        burst_leave: probability a tick that it ends; enter + leave <= 1.
        burst_loss: probability that a frame is lost in a burst.
        delay_s: time that every frame takes.
        jitter_s: and at most so much more, uniformly.
        bytes_per_s: bandwidth; infinity: unlimited.
        queue_s: how long a frame may wait for it; what would wait longer is lost.

    Raises:
        ValueError: one of them is out of its bounds; the message names it.
    """

    range_m: float = inf
    loss: float = 0.0
    burst_enter: float = 0.0
    burst_leave: float = 0.1
    burst_loss: float = 1.0
    delay_s: float = 0.0
    jitter_s: float = 0.0
    bytes_per_s: float = inf
    queue_s: float = 2.0

    def __post_init__(self) -> None:
        if not self.range_m >= 0:
            raise ValueError(f"radio range must not be negative, not {self.range_m}")
        for name in ("loss", "burst_enter", "burst_leave", "burst_loss"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} must lie between 0 and 1, not {getattr(self, name)}")
        if self.burst_enter > 0.0 and not 0.0 < self.burst_leave <= 1.0 - self.burst_enter:
            raise ValueError(
                "bursts need burst_leave above 0 and burst_enter + burst_leave of at most 1, "
                f"not {self.burst_enter} and {self.burst_leave}"
            )
        for name in ("delay_s", "jitter_s", "queue_s"):
            if not 0.0 <= getattr(self, name) < inf:
                raise ValueError(f"{name} must not be negative, not {getattr(self, name)}")
        if not self.bytes_per_s > 0.0:
            raise ValueError(f"bytes_per_s must be positive, not {self.bytes_per_s}")

    @property
    def loss_share(self) -> float:
        """Frames lost in the long run, within range."""
        if not self.burst_enter:
            return self.loss
        bad = self.burst_enter / (self.burst_enter + self.burst_leave)
        return 1.0 - (1.0 - self.loss) * (1.0 - bad * self.burst_loss)

    def words(self) -> list[str]:
        """What is emulated, in short."""
        said = []
        if not isinf(self.range_m):
            said.append(f"range {self.range_m:g} m")
        if self.loss:
            said.append(f"loss {self.loss:.3g}")
        if self.burst_enter:
            length = 1.0 / self.burst_leave
            said.append(f"bursts of {length:.3g} ticks ({self.loss_share:.3g} lost in all)")
        if self.delay_s or self.jitter_s:
            late = f"delay {self.delay_s:g} s"
            said.append(f"{late} and up to {self.jitter_s:g} s more" if self.jitter_s else late)
        if not isinf(self.bytes_per_s):
            said.append(f"{self.bytes_per_s:g} B/s")
        return said


PLAIN = Quality()


@dataclass(frozen=True, slots=True)
class Link:
    """What is different on some links; None: as on all.

    Attributes:
        sender: agent id; None: every one.
        receiver: likewise.
    """

    sender: int | None = None
    receiver: int | None = None
    range_m: float | None = None
    loss: float | None = None
    burst_enter: float | None = None
    burst_leave: float | None = None
    burst_loss: float | None = None
    delay_s: float | None = None
    jitter_s: float | None = None
    bytes_per_s: float | None = None

    def changes(self) -> dict[str, float]:
        """Field of ``Quality`` -> value."""
        names = [each.name for each in fields(self) if each.name not in ("sender", "receiver")]
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}

    @property
    def slows(self) -> bool:
        """Whether anything of it takes time."""
        return bool(self.delay_s or self.jitter_s) or self.bytes_per_s is not None

    def over(self, quality: Quality) -> Quality:
        """The quality of these links. Raises ValueError as ``Quality`` does."""
        return replace(quality, **self.changes())


def spread(name: str, quality: Quality, links: Sequence[Link], sender: I64, receiver: I64) -> F64:
    """One of the numbers for every link: (f, k), or (1, 1) where it is the same on all.

    Args:
        name: of a field of ``Quality``.
        quality: of all links.
        links: exceptions; of two for one link the later one counts.
        sender: (f,) ids.
        receiver: (k,) ids.
    """
    common: float = getattr(quality, name)
    special = [link for link in links if getattr(link, name) is not None]
    if not special:
        return np.full((1, 1), common)
    value = np.full((len(sender), len(receiver)), common)
    for link in special:
        rows = np.ones(len(sender), bool) if link.sender is None else sender == link.sender
        columns = (
            np.ones(len(receiver), bool) if link.receiver is None else receiver == link.receiver
        )
        value[np.ix_(rows, columns)] = getattr(link, name)
    return value
