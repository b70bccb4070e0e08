"""Which tiles a process is subscribed to, as its agents fly."""

from __future__ import annotations

from collections.abc import Callable, Collection, Set

from uavbridge.bus.api import Bus, Mailbox, Sample
from uavbridge.bus.keys import TilePattern
from uavbridge.bus.tiles import Tiling

MOST_TILES = 16  # beyond that one subscription to all of them costs less
STRIDE_M = 10.0  # nothing is looked at anew until an agent has moved this far
WIDE: TilePattern = ("*", "*")


class Listening:
    """A small set of subscriptions that covers every tile near the own agents.

    Until the first ``follow`` it hears everything. A tile is entered ahead of need
    and left late, so that no frame in reach is missed and few subscriptions change.

    Args:
        bus: where to subscribe.
        key: of a tile (or of ``*, *``) and an agent (or ``*``).
        tiling: tiles and margins.
    """

    def __init__(self, bus: Bus, key: Callable[[TilePattern, str], str], tiling: Tiling) -> None:
        self._bus = bus
        self._key = key
        self._tiling = tiling
        self._boxes: dict[TilePattern, Mailbox] = {}
        self._leaving: list[Mailbox] = []
        self._followed: list[tuple[float, ...]] = []
        self._enter({WIDE})

    @property
    def subscriptions(self) -> int:
        """How many there are now."""
        return len(self._boxes)

    def follow(self, positions: Collection[tuple[float, ...]]) -> None:
        """Cover what is in reach of the agents at these ENU positions (m)."""
        if self._near_the_last(positions):
            return
        self._followed = list(positions)
        near: set[TilePattern] = set(self._tiling.around(positions, STRIDE_M))
        if near <= self._boxes.keys():
            if len(self._boxes) > len(near):
                self._leave(self._tiling.around(positions, STRIDE_M + self._tiling.leave_m))
            return
        stay = self._tiling.around(positions, STRIDE_M + self._tiling.leave_m)
        if len(stay) > MOST_TILES:
            self._enter({WIDE})
            self._leave({WIDE})
        else:
            self._enter(near)
            self._leave(stay)

    def _near_the_last(self, positions: Collection[tuple[float, ...]]) -> bool:
        """Whether nobody has moved a stride since the subscriptions were looked at."""
        return len(positions) == len(self._followed) and all(
            abs(now[0] - then[0]) < STRIDE_M and abs(now[1] - then[1]) < STRIDE_M
            for now, then in zip(positions, self._followed, strict=True)
        )

    def drain(self) -> list[Sample]:
        """All samples since the last call; one that two subscriptions brought may come twice."""
        samples = [sample for box in self._leaving for sample in box.drain()]
        self._leaving.clear()
        for box in self._boxes.values():
            samples += box.drain()
        return samples

    def close(self) -> None:
        """Hear nothing more."""
        self._leave(set())

    def _enter(self, tiles: Set[TilePattern]) -> None:
        for tile in sorted(tiles - self._boxes.keys(), key=str):
            self._boxes[tile] = self._bus.subscribe(self._key(tile, "*"))

    def _leave(self, stay: Collection[TilePattern]) -> None:
        for tile in [tile for tile in self._boxes if tile not in stay]:
            box = self._boxes.pop(tile)
            box.close()
            self._leaving.append(box)
