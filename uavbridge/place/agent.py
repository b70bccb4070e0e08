"""A place agent: it stands somewhere, owns a tile of the pheromone maps, and answers for it.

It does no I/O. UAVs tell it words and are answered; neighbours are told, over a network of
their own, the words that reach into their tiles and, after every update, what lies along the
border. It stores its tile now and then; when it comes back after a failure it has what it
stored, and what its neighbours still know of its border.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

from planners.memory import dumps, loads
from planners.pheromone.keeper import Box, Keeper, KeeperLaw, Patch, reaches
from planners.pheromone.words import Word, decode_word, encode_local, encode_word
from uavbridge.bus.wire import Vector

STORE_S = 10.0  # between two stores


class News(IntEnum):
    """First byte of what place agents tell each other."""

    WORD = 1  # of a UAV: its id as 4 bytes, then the word
    BORDER = 2  # a patch: after an update
    BACK = 3  # who says so lost its memory: its id as 4 bytes
    RECALL = 4  # a patch of the other's tile


@dataclass(frozen=True, slots=True)
class Site:
    """One place agent of a mission."""

    place: int
    tile: Box
    position: Vector


@dataclass(frozen=True, slots=True)
class Telling:
    """What is to be told to another place agent."""

    to: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer to a UAV."""

    to: int
    body: bytes


class PlaceAgent:
    """One place agent.

    Args:
        site: where it stands, and its tile.
        others: the tiles of the other place agents.
        shape: columns and rows of the whole map.
        law: what it is kept by.
    """

    def __init__(
        self, site: Site, others: Mapping[int, Box], shape: tuple[int, int], law: KeeperLaw
    ) -> None:
        self.site = site
        self.keeper = Keeper(shape, law, site.tile)
        wide = site.tile.grown(law.margin, shape)
        self._others = {
            place: tile for place, tile in others.items() if not wide.common(tile).empty
        }
        self._asked: dict[int, Word] = {}
        self.rejected = 0  # what made no sense

    def heard(self, uav: int, body: bytes) -> list[Telling]:
        """A UAV's word arrived; what the neighbours are to know of it."""
        word = decode_word(body)
        if word is None:
            self.rejected += 1
            return []
        if word.radius:
            self._asked[uav] = word
        if not self.keeper.hear(uav, word):
            return []
        plain = Word(word.number, word.cell, 0, word.path, word.obstacles, word.targets)
        news = bytes((News.WORD,)) + uav.to_bytes(4, "little") + encode_word(plain)
        return [
            Telling(place, news)
            for place, tile in self._others.items()
            if reaches(plain, tile, self.keeper.law, self.keeper.shape)
        ]

    def told(self, data: bytes) -> list[Telling]:
        """Another place agent's news; what it is to be answered."""
        kind, rest = data[:1], data[1:]
        if kind == bytes((News.WORD,)):
            word = decode_word(rest[4:])
            if word is not None:
                self.keeper.hear(int.from_bytes(rest[:4], "little"), word)
                return []
        elif kind == bytes((News.BACK,)) and len(rest) == 4:
            place = int.from_bytes(rest, "little")
            if place in self._others:
                return self._recall(place)
        elif kind in (bytes((News.BORDER,)), bytes((News.RECALL,))):
            patch = patch_of(rest)
            if patch is not None and self.keeper.take(patch, own=kind[0] == News.RECALL):
                return []
        self.rejected += 1
        return []

    def update(self) -> list[Telling]:
        """One update; what the neighbours are to know after it."""
        self.keeper.update()
        tellings = []
        for place, tile in self._others.items():
            news = bytes((News.BORDER,)) + dumps(self.keeper.margin_of(tile))
            tellings.append(Telling(place, news))
        return tellings

    def replies(self) -> list[Reply]:
        """Answers to what UAVs have asked since the last call, ascending ids."""
        asked, self._asked = self._asked, {}
        return [
            Reply(uav, encode_local(self.keeper.local(word.cell, word.radius)))
            for uav, word in sorted(asked.items())
        ]

    def stored(self) -> bytes:
        """Its tile, to be kept in a store."""
        return dumps(self.keeper.patch(self.site.tile))

    def come_back(self, stored: bytes | None, steps: int) -> list[Telling]:
        """Begin again after a failure.

        Args:
            stored: what it stored last; None: nothing.
            steps: updates that there have been by now.
        """
        patch = None if stored is None else patch_of(stored)
        if patch is not None:
            self.keeper.take(patch, own=True)
        self.keeper.steps = max(self.keeper.steps, steps)
        news = bytes((News.BACK,)) + self.site.place.to_bytes(4, "little")
        return [Telling(place, news) for place in self._others]

    def _recall(self, place: int) -> list[Telling]:
        """What is still known of another's tile."""
        wide = self.site.tile.grown(self.keeper.law.margin, self.keeper.shape)
        box = wide.common(self._others[place])
        if not self.keeper.known[box.slices].all():
            return []
        news = bytes((News.RECALL,)) + dumps(self.keeper.patch(box))
        return [Telling(place, news)]


def patch_of(data: bytes) -> Patch | None:
    """The patch in ``data``; None when it is none."""
    try:
        return loads(Patch, data)
    except (ValueError, TypeError):
        return None
