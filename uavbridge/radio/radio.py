"""Who hears whom: the one place that decides a delivery, live and in experiments.

The decision is a function of what was sent and where both ends were; nothing
here depends on the order of arrival. What comes beside range (loss, bandwidth)
is drawn from (seed, sender, receiver, tick) and answers with a verdict of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from planners.types import F64, I64, Bools


class Verdict(IntEnum):
    """What becomes of one transmission at one receiver."""

    DELIVERED = 0
    OWN = 1  # an agent does not hear itself
    OUT_OF_RANGE = 2

    @property
    def reason(self) -> str:
        """In words, as accounts and recordings have it."""
        return self.name.lower().replace("_", " ")


@dataclass(frozen=True, slots=True, eq=False)
class Transmissions:
    """What was sent, one a row, with where the sender was at that time."""

    sender: I64  # (f,) ids
    tick: I64  # (f,) with sender and receiver, the key of every draw
    position: F64  # (f, 3) ENU m at sending time
    size: I64  # (f,) bytes


@dataclass(frozen=True, slots=True)
class Radio:
    """One kind of link, the same for every pair.

    Attributes:
        range_m: longest link, inclusive, straight-line distance; infinity: unlimited.
        seed: of the mission.

    Raises:
        ValueError: the range is negative or not a number.
    """

    range_m: float
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.range_m >= 0:
            raise ValueError(f"radio range must not be negative, not {self.range_m}")

    @property
    def needs_positions(self) -> bool:
        """Whether a verdict depends on where anybody is."""
        return not np.isinf(self.range_m)

    def reaches(self, sender: npt.ArrayLike, receivers: npt.ArrayLike) -> Bools:
        """Which links are short enough.

        Args:
            sender: (..., 3) ENU m at sending time.
            receivers: (..., 3) ENU m at the same time; broadcast against ``sender``.

        Returns:
            (...) bools. A position that is not a number reaches nobody.
        """
        apart = np.asarray(receivers, np.float64) - np.asarray(sender, np.float64)
        if not self.needs_positions:
            return np.ones(apart.shape[:-1], np.bool_)
        distance: F64 = np.sqrt(np.einsum("...i,...i->...", apart, apart))
        within: Bools = np.asarray(distance <= self.range_m)
        return within

    def judge(self, sent: Transmissions, receiver: I64, position: F64) -> npt.NDArray[np.uint8]:
        """The verdict on each transmission at each receiver.

        Args:
            sent: f transmissions.
            receiver: (k,) ids.
            position: (f, k, 3) ENU m of the receivers when each was sent.

        Returns:
            (f, k) values of ``Verdict``.
        """
        within = self.reaches(sent.position[:, None, :], position)
        verdict = np.where(within, np.uint8(Verdict.DELIVERED), np.uint8(Verdict.OUT_OF_RANGE))
        verdict[sent.sender[:, None] == receiver] = Verdict.OWN
        return verdict
