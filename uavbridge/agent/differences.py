"""Where the maps of two agents differ, found out over a radio with few bytes.

The cells in flat order are the leaves of a tree in which every node has 16 children; a
node's mark is the sum of its cells' (``planners.belief.marks``). An agent's frames
carry the mark of its whole map. Who sees another one in a neighbour's frame sends it a
*probe*: 16 bits of the mark of each child. Who is probed compares, and probes the
children that differ, down to single cells, which it tells. What one of the two knows
nothing of at all is told, or asked for, at once.

Much of what differs is on its way already. So a cell that changed within the last frames
is left out of a comparison, mostly, and how often an agent begins to probe is limited.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from planners.belief.marks import Marks
from planners.hashing import mixed, mixed_one
from planners.types import I64
from uavbridge.bus.wire import Probe

FAN = 16  # children of a node
SKIP, EMPTY = 0, 1  # in a probe: do not compare; nothing known
SETTLE_FRAMES = 5  # a cell that changed so lately is left out
PERIOD_FRAMES = 5  # between two probes of a whole map, while something still changes
ALL_FRAMES = 4  # in every fourth frame nothing is left out
_SKIPPED = FAN  # only of nodes up to so many cells; larger ones never rest


class Span(NamedTuple):
    """The cells of a node: of ``first`` to ``last``, exclusive, in parts of ``width`` a child."""

    first: int
    last: int
    width: int


@dataclass(frozen=True, slots=True)
class Found:
    """What a probe brought to light."""

    owed: tuple[Span, ...]  # the other knows nothing of them, or they are cells that differ
    probes: tuple[int, ...]  # nodes to look at more closely
    wanted: bool  # some of the cells in question may be known better there


class Differences:
    """One agent's tree of marks.

    Args:
        size: number of cells.
    """

    def __init__(self, size: int) -> None:
        self._marks: Marks = np.zeros(size, np.uint64)
        self._changed: I64 = np.full(size, -(1 << 62), np.int64)  # frame of the last change
        self._total = 0  # sum of all marks
        self.root = 0  # of the whole map, 32 bits; 0: nothing known
        self._depth = 1
        while FAN**self._depth < size:
            self._depth += 1

    def update(self, cells: I64, marks: Marks, frame: int) -> None:
        """Cells (m,) have marks (m,) since a frame of the own."""
        before = self._marks[cells].sum(dtype=np.uint64)
        self._total += int(marks.sum(dtype=np.uint64)) - int(before)
        self._marks[cells] = marks
        self._changed[cells] = frame
        total = self._total % (1 << 64)
        self.root = 0 if not total else max(1, mixed_one(total) >> 32)

    def span(self, node: int) -> Span | None:
        """The cells of a node that has children; None: there is no such node."""
        width, first_of_level, nodes = FAN**self._depth, 0, 1
        while width > 1:
            if first_of_level <= node < first_of_level + nodes:
                first = (node - first_of_level) * width
                size = len(self._marks)
                return Span(first, min(first + width, size), width // FAN) if first < size else None
            first_of_level += nodes
            nodes *= FAN
            width //= FAN
        return None

    def digests(self, node: int, frame: int, salt: int) -> npt.NDArray[np.uint16]:
        """What a probe says of a node's children (c,); none where there is no such node.

        Args:
            node: with children.
            frame: number of the own frame.
            salt: tick of the frame that the probe goes out with, so that two marks that look
                alike in one frame do not in the next.
        """
        span = self.span(node)
        if span is None:
            return np.zeros(0, np.uint16)
        starts = np.arange(0, span.last - span.first, span.width)
        marks = np.add.reduceat(self._marks[span.first : span.last], starts)
        digest = 2 + (mixed(marks ^ np.uint64(mixed_one(salt))) >> np.uint64(40)) % np.uint64(65534)
        digest[marks == 0] = EMPTY
        if span.width <= _SKIPPED and salt % ALL_FRAMES:
            last = np.maximum.reduceat(self._changed[span.first : span.last], starts)
            digest[last > frame - SETTLE_FRAMES] = SKIP
        return digest.astype(np.uint16)

    def compare(self, probe: Probe, frame: int, salt: int) -> Found | None:
        """What follows from another's probe; None: it makes no sense here."""
        span, mine = self.span(probe.node), self.digests(probe.node, frame, salt)
        if span is None or len(probe.digests) != len(mine):
            return None
        theirs = np.array(probe.digests, np.uint16)
        differs = (mine != theirs) & (mine != SKIP) & (theirs != SKIP)
        owed, probes, wanted = [], [], False
        for child in np.flatnonzero(differs).tolist():
            first = span.first + child * span.width
            part = Span(first, min(first + span.width, span.last), max(1, span.width // FAN))
            if theirs[child] == EMPTY or span.width == 1:
                if mine[child] != EMPTY:
                    owed.append(part)
                wanted |= bool(theirs[child] != EMPTY)
            else:
                probes.append(FAN * probe.node + 1 + child)
        return Found(tuple(owed), tuple(probes), wanted)

    def known(self, span: Span) -> I64:
        """The cells of which something is known."""
        return span.first + np.flatnonzero(self._marks[span.first : span.last])
