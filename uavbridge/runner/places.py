"""From a mission to whoever keeps its pheromone maps."""

from __future__ import annotations

from collections.abc import MutableMapping, Sequence

from uavbridge.bus.air import Air
from uavbridge.bus.api import Bus
from uavbridge.bus.truth import TruthTrack
from uavbridge.clock import SECOND_US, to_us
from uavbridge.config import Mission
from uavbridge.config.pheromones import Pheromones, keeper_law
from uavbridge.config.radio import radio_of
from uavbridge.place.channel import PlaceAir
from uavbridge.place.host import PlaceHost
from uavbridge.place.layout import sites_of
from uavbridge.place.service import Asking, Copies, Service
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
        radio = PlaceAir(
            bus,
            air.radio,
            air.agents,
            assemble.radio_tiling(mission),
            truth,
            tick_us=to_us(mission.tick),
        )
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
    air = PlaceAir(
        bus,
        radio_of(mission),
        mine,
        assemble.radio_tiling(mission),
        TruthTrack(bus),
        tick_us=to_us(mission.tick),
    )
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


def _hosted(table: Pheromones, places: Sequence[int]) -> list[int]:
    return [place for place in places if place not in table.remote]
