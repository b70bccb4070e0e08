"""How far each process of agents is, so that the simulation does not run away from them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from msgspec import DecodeError, Struct
from msgspec.json import Decoder, Encoder

from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.text import read
from uavbridge.clock import wall_s

# Wall time after which a process that says nothing is not waited for; shorter than the
# patience of ``LedClock``, so that the others do not take the simulation for dead meanwhile.
PATIENCE_S = 0.5


PRESENCE_S = 2.0  # wall time for which a process that waits counts as there


class Here(Struct, frozen=True):
    """JSON on ``pace/<first agent>``."""

    agents: list[int]
    t_us: int  # mission time that they are done with; -1: they wait for the beginning


_ENCODER = Encoder()
_DECODER = Decoder(Here)


class Pace:
    """Tells how far the agents of this process are."""

    def __init__(self, bus: Bus, agents: Sequence[int]) -> None:
        self._bus = bus
        self._agents = list(agents)
        self._key = keys.pace(min(agents))

    def tell(self, t_us: int) -> None:
        """Done with ``t_us``."""
        self._bus.publish(self._key, _ENCODER.encode(Here(self._agents, t_us)))


class Followed:
    """What the launcher knows of the processes.

    Args:
        bus: its session.
    """

    def __init__(self, bus: Bus) -> None:
        self._mailbox = bus.subscribe(keys.pace("*"))
        self._reached: dict[str, tuple[Here, float]] = {}

    def poll(self) -> None:
        """Take in what the bus brought."""
        for sample in self._mailbox.drain():
            try:
                here = read(_DECODER, sample.data)
            except DecodeError:
                continue
            self._reached[sample.key] = (here, wall_s())

    def here(self) -> frozenset[int]:
        """Agents that somebody has spoken for lately."""
        since_s = wall_s() - PRESENCE_S
        return frozenset(agent for here in self._since(since_s) for agent in here.agents)

    def slowest_us(self, agents: Iterable[int]) -> int | None:
        """Mission time that all processes of these agents are done with.

        Who has been silent for a while, or still waits, does not count; None: nobody does.
        """
        wanted = set(agents)
        lately = self._since(wall_s() - PATIENCE_S)
        reached = (h.t_us for h in lately if wanted & set(h.agents) and h.t_us >= 0)
        return min(reached, default=None)

    def _since(self, since_s: float) -> list[Here]:
        return [here for here, heard_s in self._reached.values() if heard_s >= since_s]
