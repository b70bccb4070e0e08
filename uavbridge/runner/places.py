"""From a mission to whoever keeps its pheromone maps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, MutableMapping, Sequence
from contextlib import suppress
from pathlib import Path

from msgspec import DecodeError

from uavbridge.agent.report import decode as decode_report
from uavbridge.bus import keys
from uavbridge.bus.air import Air
from uavbridge.bus.api import Bus
from uavbridge.bus.messages import decode_truth
from uavbridge.bus.security import Identity
from uavbridge.bus.truth import TruthTrack
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.clock import SECOND_US, pause, to_us
from uavbridge.config import Mission
from uavbridge.config.pheromones import Pheromones, keeper_law
from uavbridge.config.radio import radio_of
from uavbridge.place.channel import PlaceAir
from uavbridge.place.host import PlaceHost
from uavbridge.place.layout import sites_of
from uavbridge.place.service import Asking, Copies, Service
from uavbridge.place.store import Store
from uavbridge.runner import assemble

CONTROL_US = 100_000  # between two steps of place agents alone
BEHIND_US = 60 * SECOND_US  # so much later they do not make up for what they have missed
LOOK_S = 0.02


def service_of(mission: Mission, bus: Bus, air: Air, truth: TruthTrack) -> Service | None:
    """What the agents of one process have; None: the mission has no pheromones."""
    table = mission.stigmergy()
    if table is None:
        return None
    if table.form == "places":
        radio = PlaceAir(bus, air.radio, air.agents, assemble.radio_tiling(mission), truth)
        radio.share(air)
        return Asking(sites_of(mission, table), radio)
    return copies_of(mission, bus, air.agents)


def copies_of(mission: Mission, bus: Bus | None, agents: Sequence[int]) -> Copies | None:
    """A copy of the pheromone maps for each of some agents; None: the mission has none.

    Args:
        mission: whichever form it asks for.
        bus: where one copy is shown to people; None: nowhere.
        agents: ids.
    """
    table = mission.stigmergy()
    if table is None:
        return None
    law, step_us = keeper_law(mission, table), to_us(table.step_s)
    return Copies(bus, agents, mission.grid, law, step_us, table.before)


def places_of(
    mission: Mission,
    bus: Bus,
    here: Sequence[int] | None = None,
    store: MutableMapping[int, bytes] | None = None,
) -> PlaceHost | None:
    """The place agents of one process; None where there are none.

    Args:
        mission: with or without targets: they do not matter.
        bus: this process's session.
        here: their ids; None: all that the launcher hosts.
        store: where they keep their tiles; None: in this process, if the mission says so.
    """
    table = mission.stigmergy()
    if table is None or table.form != "places":
        return None
    sites = sites_of(mission, table)
    mine = _hosted(table, [site.place for site in sites]) if here is None else list(here)
    if not mine:
        return None
    air = PlaceAir(bus, radio_of(mission), mine, assemble.radio_tiling(mission), TruthTrack(bus))
    kept = {} if store is None and table.store else store
    return PlaceHost(
        sites,
        mine,
        grid=mission.grid,
        law=keeper_law(mission, table),
        step_us=to_us(table.step_s),
        before=table.before,
        bus=bus,
        air=air,
        store=kept,
        failures=table.failures,
    )


def keep_alone(
    mission: Mission,
    places: Sequence[int],
    *,
    router: str,
    store: Path | None,
    identity: Identity | None,
    wait_s: float,
    stop: Callable[[], bool],
    tell: Callable[[str], None],
) -> None:
    """Place agents in a process of their own, until they are told to stop.

    They follow mission time by the true positions and the messages that the bus brings, and go
    on while a mission of the name flies; a store lets them go on from where they were.

    Args:
        mission: as the launcher flies it.
        places: their ids.
        router: zenoh endpoint.
        store: folder for their tiles; None: they forget.
        identity: of this session.
        wait_s: for the router.
        stop: asked again and again.
        tell: is told what people need to know.

    Raises:
        BusError: no router.
        ConfigError: the store cannot be written to.
    """
    kept = None if store is None else Store(store)
    with ZenohBus(router, mission.name, wait_s=wait_s, identity=identity) as bus:
        clock = _Heard(bus)
        keepers = places_of(mission, bus, places, {} if kept is None else kept)
        assert keepers is not None
        tell(f"place agents {', '.join(map(str, places))}: router {router}")
        done_us = -1
        while not stop():
            now_us = clock.now_us() // CONTROL_US * CONTROL_US
            begins = now_us if done_us < 0 or now_us - done_us > BEHIND_US else done_us + CONTROL_US
            for t_us in range(begins, now_us + 1, CONTROL_US):
                keepers.step(t_us)
                done_us = t_us
            pause(LOOK_S)


class _Heard:
    """Mission time, as the bus tells it."""

    def __init__(self, bus: Bus) -> None:
        self._mailboxes = [bus.subscribe(keys.TRUTH), bus.subscribe("state/*")]
        self._rejects: Counter[str] = Counter()
        self._now_us = 0

    def now_us(self) -> int:
        truths, states = (mailbox.drain() for mailbox in self._mailboxes)
        for sample in truths:
            truth = decode_truth(sample.data, self._rejects)
            self._now_us = max(self._now_us, 0 if truth is None else truth.t_us)
        for sample in states:
            with suppress(DecodeError):
                self._now_us = max(self._now_us, decode_report(sample.data).t_us)
        return self._now_us


def _hosted(table: Pheromones, places: Sequence[int]) -> list[int]:
    return [place for place in places if place not in table.remote]
