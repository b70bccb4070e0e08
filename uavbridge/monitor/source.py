"""Where what is shown comes from: a bus, or a recording."""

from __future__ import annotations

import os
from collections.abc import Callable
from math import nan
from typing import Protocol

from uavbridge.agent.orders import Verb
from uavbridge.bus.api import Bus
from uavbridge.clock import wall_s
from uavbridge.command import Reply, send_order
from uavbridge.errors import UavbridgeError
from uavbridge.monitor.replayed import Player
from uavbridge.monitor.watch import MissionWatch

SILENT_S = 3.0
ANSWER_S = 5.0


class Source(Protocol):
    """A mission to show."""

    @property
    def name(self) -> str: ...
    @property
    def watch(self) -> MissionWatch: ...
    @property
    def player(self) -> Player | None:
        """Of a recording; None: it flies now."""
        ...

    @property
    def orders(self) -> list[str]:
        """What may be ordered."""
        ...

    @property
    def connected(self) -> bool:
        """Whether the bus is there."""
        ...

    @property
    def silent(self) -> bool:
        """Nothing new came for some seconds, though the mission is not over."""
        ...

    def step(self) -> None:
        """Take in what is new. Does not block."""
        ...

    def order(self, verb: Verb, agent: int | None, to: tuple[float, float] | None) -> list[Reply]:
        """Give an order and wait for the answers; may be called from another thread."""
        ...


class Live:
    """A mission on a bus.

    Args:
        bus: its session.
        name: of the mission.
        watch: of the same bus; None: a new one.
        connected: tells whether the bus is there.
    """

    player = None

    def __init__(
        self,
        bus: Bus,
        name: str,
        watch: MissionWatch | None = None,
        connected: Callable[[], bool] = lambda: True,
    ) -> None:
        self.name = name
        self.watch = MissionWatch(bus) if watch is None else watch
        self.orders = [verb.value for verb in Verb]
        self._bus, self._is_connected = bus, connected
        self._news = (-1, wall_s())  # newest mission time, and when it came

    @property
    def connected(self) -> bool:
        return self._is_connected()

    @property
    def silent(self) -> bool:
        return wall_s() - self._news[1] > SILENT_S and not self.watch.ended

    def step(self) -> None:
        self.watch.poll()
        if self.watch.restarted:
            self.watch.close()
            self.watch = MissionWatch(self._bus)
        if self.watch.t_us != self._news[0]:
            self._news = (self.watch.t_us, wall_s())

    def order(self, verb: Verb, agent: int | None, to: tuple[float, float] | None) -> list[Reply]:
        there = list(self.watch.agents.values())  # at once: ``step`` may add to them meanwhile
        everybody = tuple(sorted(one.id for one in there if one.alive is not False))
        return send_order(
            self._bus,
            verb,
            agents=everybody if agent is None else (agent,),
            everyone=agent is None,
            name=os.urandom(8).hex(),
            position=None if to is None else (*to, nan),
            timeout_s=ANSWER_S,
        )


class Recorded:
    """A mission that is over.

    Args:
        player: of its recording.
    """

    connected = True
    silent = False

    def __init__(self, player: Player) -> None:
        self.player = player
        self.name = player.name
        self.orders: list[str] = []

    @property
    def watch(self) -> MissionWatch:
        return self.player.watch

    def step(self) -> None:
        self.player.step()

    def order(self, verb: Verb, agent: int | None, to: tuple[float, float] | None) -> list[Reply]:
        raise UavbridgeError("a recording cannot be told anything")
