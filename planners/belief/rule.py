"""The seam of the merge rules: how maps take in own readings and what others send.

Records travel between agents; they may be lost, late, or come twice, and
nobody knows who heard them. Rules are frozen values and change no argument.
"""

from __future__ import annotations

from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from planners.belief.maps import BeliefMap, SensorModel
from planners.grid import Grid
from planners.types import I64, Bools

Records: TypeAlias = npt.NDArray[np.void]

LAST_US = 2**62  # no honest stamp comes near
GRACE_US = 1000  # stamps may run ahead of the clock by a microsecond a reading


class MergeRule(Protocol):
    """How a map takes in own readings and what others send. Changes no argument."""

    @property
    def name(self) -> str:
        """As mission files spell it."""
        ...

    @property
    def code(self) -> int:
        """On the wire."""
        ...

    @property
    def record(self) -> np.dtype[Any]:
        """Packed little-endian wire record; its first field is ``cell``."""
        ...

    @property
    def item(self) -> tuple[str, ...]:
        """Fields of a record that name what it tells of; a later one of the same replaces it."""
        ...

    @property
    def compared(self) -> tuple[str, ...]:
        """Fields in which two agents' records of a cell differ if one can learn from the other.

        Empty: nobody learns anything from anybody.
        """
        ...

    @property
    def onlooker(self) -> MergeRule:
        """The rule by which one who only listens unites the records of all agents.

        It reads the same records, and the order in which they come does not matter to it.
        """
        ...

    def empty(
        self, grid: Grid, prior: npt.ArrayLike, sensor: SensorModel | None = None
    ) -> BeliefMap:
        """Map of an agent that has seen nothing.

        Args:
            grid: its cells.
            prior: (columns, rows) or one number.
            sensor: that the team's readings come from; rules that share readings need it.
        """
        ...

    def observe(
        self,
        belief: BeliefMap,
        cell: tuple[int, int],
        detected: bool,
        sensor: SensorModel,
        *,
        t_us: int,
        agent: int,
    ) -> BeliefMap:
        """Map after an own reading of ``cell`` (column, row)."""
        ...

    def valid(self, belief: BeliefMap, records: Records, until_us: int | None = None) -> Bools:
        """Which records (k,) make sense; ``until_us``: none can have been observed after it."""
        ...

    def merge(self, belief: BeliefMap, records: Records) -> tuple[BeliefMap, I64]:
        """Map after received records (k,), and the flat cells that changed, ascending.

        Records that are not ``valid`` are ignored. What was heard together should be
        merged together: some rules weigh the senders' values against each other.
        """
        ...

    def records(self, belief: BeliefMap, cells: npt.ArrayLike) -> Records:
        """What to send of the flat cells (column * rows + row); none of a cell never seen."""
        ...


def unpack(rule: MergeRule, data: bytes) -> Records | None:
    """Records (k,) that a frame carries, or None when the bytes are not whole records."""
    if len(data) % rule.record.itemsize:
        return None
    return np.frombuffer(data, rule.record)


def latest_us(until_us: int | None) -> int:
    """Stamps above it make no sense in a record sent at ``until_us``."""
    return LAST_US if until_us is None else min(until_us + GRACE_US, LAST_US)
