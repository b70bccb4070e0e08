"""The place agents of one process: feeds each what reached it, carries out what it wants.

The stepped and the paced runner call ``step`` at every control tick, after the agents; a place
agent alone (``uavbridge agent --place``) does so, too. UAVs are heard over the emulated radio,
other place agents over a network of their own whose bytes are counted apart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, MutableMapping, Sequence

import numpy as np

from planners.grid import Grid
from planners.pheromone.field import Field
from planners.pheromone.keeper import KeeperLaw
from planners.pheromone.law import Weights
from planners.types import F64
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.layers import Layer, encode_layer
from uavbridge.clock import SECOND_US, to_us
from uavbridge.config.pheromones import Failure
from uavbridge.place.agent import STORE_S, PlaceAgent, Site, Telling
from uavbridge.place.channel import PlaceAir
from uavbridge.place.wire import Said

LAYERS_US = 5 * SECOND_US  # between two layers for people
LAYER_NAMES = ("pheromone-target", "pheromone-obstacle", "pheromone-path", "pheromone-combined")


class PlaceHost:
    """Runs place agents.

    Args:
        sites: of all place agents of the mission.
        here: ids of those that run in this process.
        grid: the whole map's.
        law: what it is kept by.
        step_us: between two updates.
        before: updates before the mission.
        bus: this process's session.
        air: the radio, of the place agents in this process.
        store: where each stores its tile; None: nowhere.
        failures: which are out of service, and when.

    Attributes:
        net_bytes: sent by each to other place agents.
        rejects: what other place agents sent that made no sense.
    """

    def __init__(
        self,
        sites: Sequence[Site],
        here: Sequence[int],
        *,
        grid: Grid,
        law: KeeperLaw,
        step_us: int,
        before: int,
        bus: Bus,
        air: PlaceAir,
        store: MutableMapping[int, bytes] | None,
        failures: Sequence[Failure] = (),
    ) -> None:
        self._sites = {site.place: site for site in sites}
        self._here = tuple(sorted(here))
        self._grid, self._law, self._step_us, self._before = grid, law, step_us, before
        self._bus, self._air, self._store, self._failures = bus, air, store, failures
        self._net = {place: bus.subscribe(keys.place_net(place)) for place in self._here}
        self._positions = {place: self._sites[place].position for place in self._here}
        self.net_bytes: Counter[int] = Counter()
        self.rejects: Counter[str] = Counter()
        self.places: dict[int, PlaceAgent | None] = {}
        for place in self._here:
            self.places[place] = self._fresh(place)
        for _ in range(before):
            self._update()
        for place, agent in self.places.items():
            assert agent is not None
            agent.keeper.steps = 0
            stored = None if store is None else store.get(place)
            self._send(place, agent.come_back(stored, 0))
        self._began = False

    def step(self, t_us: int) -> None:
        """One control tick, after the agents'."""
        if not self._began:  # maybe in the middle of a mission
            self._began = True
            for agent in self.places.values():
                assert agent is not None
                agent.keeper.steps = max(agent.keeper.steps, self._steps_before(t_us))
        self._fail_and_come_back(t_us)
        for place, heard in self._air.receive(self._positions, t_us).items():
            agent = self.places[place]
            for said in heard if agent is not None else ():
                assert agent is not None
                self._send(place, agent.heard(said.sender, said.body))
        self._listen()
        if t_us and t_us % self._step_us == 0:
            self._update()
        self._reply(t_us)
        if self._store is not None and t_us % to_us(STORE_S) == 0:
            for place, agent in self.places.items():
                if agent is not None:
                    self._store[place] = agent.stored()
        if t_us % LAYERS_US == 0:
            self._show(t_us)

    def _steps_before(self, t_us: int) -> int:
        """Updates that there have been before the one that may be due now."""
        return max(t_us - 1, 0) // self._step_us

    def _fresh(self, place: int) -> PlaceAgent:
        others = {other: site.tile for other, site in self._sites.items() if other != place}
        return PlaceAgent(self._sites[place], others, self._grid.shape, self._law)

    def _fail_and_come_back(self, t_us: int) -> None:
        for place in self._here:
            out = any(
                failure.place == place and to_us(failure.from_s) <= t_us < to_us(failure.to_s)
                for failure in self._failures
            )
            if out:
                self.places[place] = None
            elif self.places[place] is None:
                agent = self.places[place] = self._fresh(place)
                stored = None if self._store is None else self._store.get(place)
                self._net[place].drain()  # what came meanwhile
                self._send(place, agent.come_back(stored, self._steps_before(t_us)))

    def _update(self) -> None:
        for place, agent in self.places.items():
            if agent is not None:
                self._send(place, agent.update())
        self._listen()

    def _listen(self) -> None:
        """What other place agents say, and what they are answered."""
        for place, mailbox in self._net.items():
            agent = self.places[place]
            for sample in mailbox.drain():
                if agent is None:
                    continue
                before = agent.rejected
                self._send(place, agent.told(sample.data))
                self.rejects["place"] += agent.rejected - before

    def _send(self, place: int, tellings: Sequence[Telling]) -> None:
        for telling in tellings:
            self.net_bytes[place] += len(telling.data)
            self._bus.publish(keys.place_net(telling.to), telling.data)

    def _reply(self, t_us: int) -> None:
        for place, agent in self.places.items():
            if agent is None:
                continue
            position = self._sites[place].position
            for number, reply in enumerate(agent.replies()):
                self._air.send(Said(place, reply.to, t_us + number, position, reply.body))

    def _show(self, t_us: int) -> None:
        keepers = [agent.keeper for agent in self.places.values() if agent is not None]
        fields = [(keeper.tile.slices, keeper.field) for keeper in keepers]
        whole = Field.fresh(self._grid.shape, self._law.field)
        for where, field in fields:
            for name in ("target", "obstacle", "path"):
                getattr(whole, name)[where] = getattr(field, name)[where]
        publish_layers(self._bus, self._grid, whole, t_us)


def publish_layers(bus: Bus, grid: Grid, field: Field, t_us: int) -> None:
    """The three maps and the combined one, for people."""
    maps: tuple[F64, ...] = (field.target, field.obstacle, field.path, field.combined(Weights()))
    for name, values in zip(LAYER_NAMES, maps, strict=True):
        layer = Layer(t_us, grid.west_m, grid.south_m, grid.cell_m, np.asarray(values))
        bus.publish(keys.layer(name), encode_layer(layer))


def traffic_of(host: PlaceHost | None) -> Mapping[int, int]:
    """Bytes that place agents sent each other, by place agent."""
    return {} if host is None else dict(host.net_bytes)
