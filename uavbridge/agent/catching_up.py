"""How an agent finds what its map lacks, and what others lack that it knows.

Nothing is remembered of a conversation but the probes that wait to go out: any frame
may be lost, late or doubled, and what was missed is found again by the next probe.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from planners.belief.maps import BeliefMap
from planners.belief.marks import cell_marks
from planners.belief.merge import MergeRule
from planners.types import I64
from uavbridge.agent.differences import PERIOD_FRAMES, Differences
from uavbridge.agent.outbox import Outbox
from uavbridge.bus.wire import Frame, Probe

RECENT_FRAMES = 3  # a neighbour not heard for so many is not asked
QUIET_FRAMES = 2  # between two probes of a whole map, when nothing changes any more
MOST_PENDING = 256  # probes; what is left out is found again
MOST_AT_ONCE = 16  # in one frame


class _Peer(NamedTuple):
    """What a neighbour's newest frame said."""

    heard: int  # at which of the own frames
    tick: int
    root: int
    same: bool  # as in its frame before


class CatchingUp:
    """One agent's part in it.

    Args:
        agent: its id.
        rule: of its map.
        size: number of cells.
        outbox: gets the cells that others lack.
    """

    def __init__(self, agent: int, rule: MergeRule, size: int, outbox: Outbox) -> None:
        self._agent, self._rule, self._outbox = agent, rule, outbox
        self._takes_part = bool(rule.compared)
        self._tree = Differences(size)
        self._peers: dict[int, _Peer] = {}
        self._probed: dict[int, int] = {}  # peer -> the own frame at which it was probed last
        self._pending: dict[tuple[int, int, bool], None] = {}  # to whom, node, echo
        self._frame = 0  # own frames so far
        self._began = agent % PERIOD_FRAMES - PERIOD_FRAMES  # to probe a whole map
        self._told_root = -1

    @property
    def root(self) -> int:
        """Mark of the whole map; 0: nothing known."""
        return self._tree.root

    def learned(self, belief: BeliefMap, cells: I64) -> None:
        """Ascending flat cells (m,) of the own map changed."""
        if self._takes_part and len(cells):
            marks = cell_marks(self._rule, belief, cells)
            self._tree.update(cells, marks, self._frame)

    def heard(self, frames: Iterable[Frame]) -> int:
        """What frames of this rule tell and ask, after their cells were merged.

        Returns:
            how many probes made no sense.
        """
        senseless = 0
        if not self._takes_part:
            return senseless
        for frame in frames:
            before = self._peers.get(frame.sender)
            if before is None or frame.tick > before.tick:
                same = before is not None and before.root == frame.root
                self._peers[frame.sender] = _Peer(self._frame, frame.tick, frame.root, same)
            for probe in frame.probes:
                if probe.to == self._agent:
                    senseless += not self._answer(frame, probe)
        return senseless

    def _answer(self, frame: Frame, probe: Probe) -> bool:
        found = self._tree.compare(probe, self._frame, frame.tick)
        if found is None:
            return False
        for span in found.owed:
            self._outbox.asked_for(self._tree.known(span))
        for node in found.probes:
            self._pend(frame.sender, node)
        if found.wanted and not probe.echo:
            self._pend(frame.sender, probe.node, echo=True)
        return True

    def _pend(self, to: int, node: int, *, echo: bool = False) -> None:
        if len(self._pending) < MOST_PENDING:
            self._pending[to, node, echo] = None

    def probes(self, tick: int, room: float) -> tuple[Probe, ...]:
        """What goes out with the next own frame, in at most ``room`` bytes; call it once a frame.

        Args:
            tick: of the frame.
            room: bytes.
        """
        if not self._takes_part:
            return ()
        if not self._pending:
            self._begin()
        probes: list[Probe] = []
        for to, node, echo in list(self._pending)[:MOST_AT_ONCE]:
            digests = self._tree.digests(node, self._frame, tick)
            probe = Probe(to, node, tuple(digests.tolist()), echo)
            room -= probe.size
            if room < 0:
                break
            del self._pending[to, node, echo]
            probes.append(probe)
        self._frame += 1
        self._told_root = self.root
        return tuple(probes)

    def _begin(self) -> None:
        """Probe a neighbour that knows something else, if it is time to."""
        now = self._frame
        others = {
            sender: peer
            for sender, peer in self._peers.items()
            if peer.root not in (self.root, 0) and now - peer.heard <= RECENT_FRAMES
        }  # who knows nothing asks by itself
        if not others:
            return
        quiet = self.root == self._told_root and any(peer.same for peer in others.values())
        ignorant = self.root == 0 and not self._probed
        if not ignorant and now - self._began < (QUIET_FRAMES if quiet else PERIOD_FRAMES):
            return
        longest = min(
            others,
            key=lambda peer: (quiet and not others[peer].same, self._probed.get(peer, -1), peer),
        )
        self._probed[longest] = self._began = now
        self._pend(longest, 0)
