"""All key spaces of the bus, in one table.

A key is ``uavbridge/<mission>/<space>/...``; everything but the two bus
implementations speaks of keys relative to the mission.

Planners, and the core of an agent, are fed from ``air/``, ``obs/`` and
``place/`` only. A monitor may read everything (``**``).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

Tile: TypeAlias = tuple[int, int]
TilePattern: TypeAlias = tuple[int | str, int | str]  # with "*" for any

TRUTH = "world/truth"
MISSION = "world/mission"
PAST = "world/past"
BRIEFING = "world/briefing"
RUN = "world/run"
REFUSED = "world/refused"
EVERYONE = "all"
ALL_ALIVE = "uavbridge/*/alive/*"  # of every mission, so not relative to one


@dataclass(frozen=True, slots=True)
class Space:
    """One key space: who writes, who may read, and how it is carried.

    Attributes:
        pattern: its keys, relative to the mission.
        writers: who publishes there.
        readers: who may be fed from it.
        essential: True: the sender waits when the network is busy; False: a
            sample may be lost then, as a newer one follows.
        urgent: it overtakes the rest.
    """

    pattern: str
    writers: str
    readers: str
    essential: bool = False
    urgent: bool = False


SPACES: dict[str, Space] = {
    # The emulated radio: one frame per agent and tick; the receiver's Radio decides.
    "air": Space("air/<tile x>/<tile y>/<agent>", "the agent", "agents in radio range"),
    # What the own payload sensor saw, from the simulated world or a real detector.
    "obs": Space("obs/<agent>", "the world, a detector", "the agent", essential=True),
    # Over the radio, what UAVs and place agents say to each other; over their own network, what
    # neighbouring place agents do (place/net).
    "place": Space(
        "place/air/<tile x>/<tile y>/<who>, place/net/<place>",
        "agents, place agents",
        "place agents, agents in radio range",
        essential=True,
    ),
    # Position beacon for separation, such as Remote ID gives; never fed to a planner.
    "safety": Space(
        "safety/<tile x>/<tile y>/<agent>", "the agent", "safety filters in range", urgent=True
    ),
    # Orders from people and from the mission's judge.
    "cmd": Space("cmd/<agent | all>", "operators", "the agent", essential=True, urgent=True),
    # Reports for people; state/<agent>/map is the whole map: on request and now and then.
    "state": Space("state/<agent>[/map | /ack]", "the agent", "people: monitor, recorder, judge"),
    # Where the simulated vehicles truly are: for Radio alone.
    # Beside them the mission as it is flown, targets and all, and its past: for people; and
    # world/briefing, what a process of agents is told before it flies; world/run, which flight of
    # the mission it is, for place agents alone; world/refused, whom the router turned away.
    "world": Space(
        "world/truth, world/mission, world/past, world/briefing, world/run, world/refused",
        "the simulation, the launcher, the router",
        "the radio's decision, recorder, people",
    ),
    # How far each process of agents is, for the launcher that paces the simulation.
    "pace": Space("pace/<agent>", "the agent's process", "the launcher"),
    # Maps of any numbers beside the belief, such as pheromones: of the mission, or of one agent.
    "layer": Space("layer/<name>[/<agent>]", "agents, place agents", "people"),
    # Liveliness tokens: people learn from them who died, agents do not.
    "alive": Space("alive/<agent>", "the agent's session", "people"),
}


def prefix(mission: str) -> str:
    """``uavbridge/<mission>/``, with what zenoh cannot have in a key replaced by ``-``.

    Raises:
        ValueError: the mission has no name.
    """
    if not mission:
        raise ValueError("a mission needs a name")
    return f"uavbridge/{re.sub(r'[^A-Za-z0-9._-]', '-', mission)}/"


def space_of(key: str) -> Space | None:
    """The key space that a relative key belongs to."""
    return SPACES.get(key.partition("/")[0])


@lru_cache(maxsize=4096)
def agent_of(key: str) -> int | None:
    """The agent named by a key's last chunk that is not ``map`` or ``cells``; None: none is."""
    last = key.removesuffix("/map").removesuffix("/cells").rpartition("/")[2]
    return int(last) if last.isascii() and last.isdigit() else None


def air(tile: TilePattern, agent: int | str) -> str:
    """Frames of one agent (or ``*``) sent from a tile."""
    return f"air/{tile[0]}/{tile[1]}/{agent}"


def safety(tile: TilePattern, agent: int | str) -> str:
    """Position beacons of one agent (or ``*``) sent from a tile."""
    return f"safety/{tile[0]}/{tile[1]}/{agent}"


def obs(agent: int | str) -> str:
    """Readings of an agent's payload sensor."""
    return f"obs/{agent}"


def place(tile: TilePattern, who: int | str) -> str:
    """What one agent or place agent (or ``*``) says from a tile."""
    return f"place/air/{tile[0]}/{tile[1]}/{who}"


def place_net(place: int | str) -> str:
    """What other place agents tell one of them."""
    return f"place/net/{place}"


def cmd(target: int | str = EVERYONE) -> str:
    """Orders to one agent, or to all."""
    return f"cmd/{target}"


def state(agent: int | str) -> str:
    """An agent's report for people."""
    return f"state/{agent}"


def state_map(agent: int | str) -> str:
    """An agent's whole map for people: published now and then, answered on request."""
    return f"state/{agent}/map"


def state_cells(agent: int | str) -> str:
    """All that an agent knows of the map, as a frame: for onlookers, on request."""
    return f"state/{agent}/cells"


def ack(agent: int | str) -> str:
    """An agent's answers to orders."""
    return f"state/{agent}/ack"


def event(agent: int | str) -> str:
    """What happened to an agent, in words for people."""
    return f"state/{agent}/event"


def pace(agent: int | str) -> str:
    """How far the process of an agent is, the first of several."""
    return f"pace/{agent}"


def layer(name: str, agent: int | None = None) -> str:
    """A layer of numbers over the ground, for people."""
    return f"layer/{name}" if agent is None else f"layer/{name}/{agent}"


@lru_cache(maxsize=256)
def layer_of(key: str) -> str | None:
    """The name in a layer's key, with its agent if it has one; None for what is no such key."""
    found = re.fullmatch(r"layer/([a-z0-9][a-z0-9_-]{0,39}(?:/\d{1,5})?)", key)
    return found[1] if found else None


def alive(agent: int | str) -> str:
    """An agent's liveliness token."""
    return f"alive/{agent}"
