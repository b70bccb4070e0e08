"""Who passes on what: only what a neighbour did not hear itself, and one of those who can tell it.

Every frame says of which agents its sender heard the frames of one tick before. So an agent knows
which of its neighbours do not hear whom, and who else could tell them. Of those who could, the
first of the team does. Links change: whether neighbours heard a frame, as they mostly do, their
next frames tell. Until then what is in it is held back, and passed on after all if they did not.
Whatever still gets lost, ``CatchingUp`` finds.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from uavbridge.bus.wire import Frame

RECENT_FRAMES: Final = 3  # a neighbour not heard for so many is none


class Sources(NamedTuple):
    """Whose frames of a tick told something: bit i for the i-th of the team; 0: nobody knows."""

    tick: int
    agents: int

    def joined(self, other: Sources) -> Sources:
        """With another one of the same; of several ticks the last counts."""
        if self.tick != other.tick:
            return max(self, other)
        return Sources(self.tick, self.agents | other.agents)


UNKNOWN: Final = Sources(-1, 0)


def always(_: Sources) -> bool:
    """Pass on everything."""
    return True


class Relaying:
    """One agent's part in it.

    Args:
        agent: its id.
        team: all ids, ascending.
    """

    def __init__(self, agent: int, team: Sequence[int]) -> None:
        self._bits = {member: 1 << i for i, member in enumerate(team)}
        self._own = self._bits.get(agent, 0)
        self._frame = 0  # own frames so far
        self._tick = -1  # of the own frame before
        self._heard: dict[int, int] = {}  # tick -> agents whose frames of it were heard
        # by bit, of its newest frame: heard at which own frame, its tick, whom its sender heard
        self._peers: dict[int, tuple[int, int, int]] = {}
        self._needed: dict[Sources, bool] = {}

    def heard(self, frames: Iterable[Frame]) -> None:
        """Frames that were merged."""
        bits, own, heard, peers, now = self._bits, self._own, self._heard, self._peers, self._frame
        for frame in frames:
            bit, tick = bits.get(frame.sender, own), frame.tick
            if bit != own:
                heard[tick] = heard.get(tick, 0) | bit
                if bit not in peers or tick > peers[bit][1]:
                    peers[bit] = now, tick, frame.heard

    def source(self, frame: Frame) -> Sources:
        """A frame as a source of what it tells."""
        return Sources(frame.tick, self._bits.get(frame.sender, 0))

    def tell(self, tick: int) -> int:
        """Of whom the frames of one tick before were heard; call it once an own frame.

        Args:
            tick: of the own frame.
        """
        oldest = self._frame - RECENT_FRAMES
        self._peers = {bit: peer for bit, peer in self._peers.items() if peer[0] >= oldest}
        heard = self._heard.get(tick - 1, 0)
        self._heard = {t: agents for t, agents in self._heard.items() if tick <= t <= tick + 1}
        self._needed = {}
        self._tick = tick
        self._frame += 1
        return heard

    def needed(self, sources: Sources) -> bool:
        """Whether to pass on what was heard so: a neighbour lacks it, and nobody else should.

        Of what was told one tick before the own frame that is likely, two ticks before certain.
        """
        known = self._needed.get(sources)
        if known is None:
            known = self._needed[sources] = self._lacking(sources)
        return known

    def _lacking(self, sources: Sources) -> bool:
        told = sources.agents
        if not told or not self._tick - 2 <= sources.tick <= self._tick:
            return True
        peers = self._peers.items()
        others = [  # who could tell it, and come before this one
            (bit, heard) for bit, (_, _, heard) in peers if bit < self._own and heard & told
        ]
        for bit, (_, _, heard) in peers:
            served = heard & told or bit & told
            if not served and not any([heard & other and bit & theirs for other, theirs in others]):
                return True
        return False
