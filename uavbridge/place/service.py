"""How a UAV comes by the pheromone maps: by asking place agents, or by a copy of its own.

What its planner deposits and asks (``Goal.edits``, ``Goal.asks``) becomes a word; the answer is
in the planner's next view. Both ways charge the radio: words and answers as messages, copies by
what they add to the UAV's frames.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import dist, inf
from typing import Protocol

import msgspec
import numpy as np

from planners.grid import Grid
from planners.pheromone.keeper import Keeper, KeeperLaw
from planners.pheromone.words import (
    ASK,
    OBSTACLE,
    PATH,
    TARGET,
    Word,
    decode_query,
    decode_word,
    encode_local,
    encode_word,
)
from planners.types import Answer, Goal
from uavbridge.bus.api import Bus
from uavbridge.bus.wire import Frame, Vector
from uavbridge.clock import SECOND_US, to_s
from uavbridge.place import trailer
from uavbridge.place.agent import Site
from uavbridge.place.channel import PlaceAir
from uavbridge.place.host import LAYERS_US, publish_layers
from uavbridge.place.wire import Said

DEAF_S = 3.0  # a place agent that has not answered for so long is not asked
AGAIN_S = 15.0  # but once more after this time
RETOLD = 3  # words in each frame of a copy: one that is lost comes again


class Service(Protocol):
    """What the agents of one process have."""

    def receive(
        self, where: Mapping[int, Vector], frames: Mapping[int, Sequence[Frame]], t_us: int
    ) -> dict[int, list[Answer]]:
        """Answers by agent, before the agents' step."""
        ...

    def wish(self, agent: int, goal: Goal, tick: int, position: Vector, t_us: int) -> None:
        """A planner decided."""
        ...

    def outgoing(self, frame: Frame) -> Frame:
        """A frame as it is sent."""
        ...

    def step(self, t_us: int) -> None:
        """After the agents' step."""
        ...


def word_of(goal: Goal, number: int) -> Word | None:
    """What a goal says to whoever keeps the maps; None: nothing."""
    none = np.zeros((0, 2), np.int64)
    cells = {edit.layer: np.asarray(edit.cells, np.int64) for edit in goal.edits}
    asked = [query for ask in goal.asks if ask.key == ASK and (query := decode_query(ask.data))]
    named = [cells.get(layer, none) for layer in (PATH, OBSTACLE, TARGET)]
    if not asked and not any(len(each) for each in named):
        return None
    cell, radius = asked[-1] if asked else ((0, 0), 0)
    return Word(number, cell, radius, *named)


class Asking:
    """Place agents are asked: the nearest one in range that answers.

    Args:
        sites: of all place agents.
        air: the radio of the agents in this process.
    """

    def __init__(self, sites: Sequence[Site], air: PlaceAir) -> None:
        self._sites, self._air = tuple(sites), air
        self._asked: dict[tuple[int, int], int] = {}  # (agent, place): since when no answer
        self._deaf: dict[tuple[int, int], int] = {}  # and until when it is not asked

    def receive(
        self, where: Mapping[int, Vector], frames: Mapping[int, Sequence[Frame]], t_us: int
    ) -> dict[int, list[Answer]]:
        answers: dict[int, list[Answer]] = {}
        for agent, heard in self._air.receive(where, t_us).items():
            for said in heard:
                if said.to == agent:
                    self._asked.pop((agent, said.sender), None)
                    age_s = max(to_s(t_us - said.t_us), 0.0)
                    answers.setdefault(agent, []).append(Answer(ASK, said.body, age_s))
        return answers

    def wish(self, agent: int, goal: Goal, tick: int, position: Vector, t_us: int) -> None:
        word = word_of(goal, tick)
        place = None if word is None else self._nearest(agent, position, t_us)
        if word is None or place is None:
            return
        self._air.send(Said(agent, place, t_us, position, encode_word(word)))
        if word.radius:
            self._asked.setdefault((agent, place), t_us)

    def outgoing(self, frame: Frame) -> Frame:
        return frame

    def step(self, t_us: int) -> None:
        """Nothing: the place agents have a host of their own."""

    def _nearest(self, agent: int, position: Vector, t_us: int) -> int | None:
        best, least_m = None, inf
        for site in self._sites:
            pair, far_m = (agent, site.place), dist(position, site.position)
            since_us = self._asked.get(pair)
            if since_us is not None and to_s(t_us - since_us) > DEAF_S:
                self._deaf[pair] = t_us + round(AGAIN_S * SECOND_US)
                del self._asked[pair]
            if self._deaf.get(pair, 0) > t_us or far_m > self._air.radio.range_m:
                continue
            if far_m < least_m:
                best, least_m = site.place, far_m
        return best


class Copies:
    """Each UAV keeps a copy of the whole map, and tells the others its own words.

    Args:
        bus: where the first one's copy is shown to people; None: nowhere.
        agents: ids of those in this process.
        grid: of the map.
        law: what it is kept by.
        step_us: between two updates.
        before: updates before the mission.
    """

    def __init__(
        self,
        bus: Bus | None,
        agents: Sequence[int],
        grid: Grid,
        law: KeeperLaw,
        step_us: int,
        before: int,
    ) -> None:
        self.keepers = {agent: Keeper(grid.shape, law) for agent in agents}
        self._bus, self._grid = bus, grid
        self._step_us = step_us
        self._said: dict[int, list[bytes]] = {agent: [] for agent in agents}
        self._asked: dict[int, Word] = {}
        self._answers: dict[int, list[Answer]] = {}
        for keeper in self.keepers.values():
            for _ in range(before):
                keeper.update()
            keeper.steps = 0

    def receive(
        self, where: Mapping[int, Vector], frames: Mapping[int, Sequence[Frame]], t_us: int
    ) -> dict[int, list[Answer]]:
        for agent, heard in frames.items():
            for frame in heard:
                for data in trailer.words(frame.payload):
                    word = decode_word(data)
                    if word is not None:
                        self.keepers[agent].hear(frame.sender, word)
        answers, self._answers = self._answers, {}
        return answers

    def wish(self, agent: int, goal: Goal, tick: int, position: Vector, t_us: int) -> None:
        word = word_of(goal, tick)
        if word is None:
            return
        if word.radius:
            self._asked[agent] = word
        plain = replace(word, radius=0)
        if len(word.path) or len(word.obstacles) or len(word.targets):
            self.keepers[agent].hear(agent, plain)
            self._said[agent] = [*self._said[agent], encode_word(plain)][-RETOLD:]

    def outgoing(self, frame: Frame) -> Frame:
        said = self._said[frame.sender]
        if not said:
            return frame
        return msgspec.structs.replace(frame, payload=trailer.joined(frame.payload, said))

    def step(self, t_us: int) -> None:
        if t_us and t_us % self._step_us == 0:
            for keeper in self.keepers.values():
                keeper.update()
        if self._bus is not None and t_us % LAYERS_US == 0:
            shown = min(self.keepers)
            publish_layers(self._bus, self._grid, self.keepers[shown].field, t_us)
        asked, self._asked = self._asked, {}
        for agent, word in asked.items():
            local = self.keepers[agent].local(word.cell, word.radius)
            self._answers.setdefault(agent, []).append(Answer(ASK, encode_local(local), 0.0))
