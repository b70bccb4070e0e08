"""Tiles in the key: a traffic filter on top of the radio, never the decision itself."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from uavbridge.bus.keys import Tile

MARGIN_S = 2.0  # subscriptions are this much flight ahead, of sender and receiver each
MARGIN_M = 10.0  # and this much, for the error of the position that chose the tile


@dataclass(frozen=True, slots=True)
class Tiling:
    """Square tiles over the plane; tile (0, 0) starts at home.

    Attributes:
        width_m: side of a tile; infinity: one tile for all.
        reach_m: a receiver must hear every tile within this distance, at most width_m.
        leave_m: a tile is left when it is this much farther away; at most width_m / 2, so
            that there are never more than 16.
    """

    width_m: float = math.inf
    reach_m: float = math.inf
    leave_m: float = 0.0

    @staticmethod
    def of(range_m: float, speed_m_s: float) -> Tiling:
        """Tiles a little wider than the longest link, by some seconds of flight.

        The margin covers what both ends fly while a subscription takes effect, and
        the error of the position by which the sender chose its tile.

        Args:
            range_m: longest link.
            speed_m_s: fastest vehicle.
        """
        if math.isinf(range_m):
            return Tiling()
        margin_m = 2.0 * MARGIN_S * speed_m_s + MARGIN_M
        return Tiling(range_m + margin_m, range_m + margin_m, margin_m / 2.0)

    def tile_of(self, position: tuple[float, ...]) -> Tile:
        """The tile that holds an ENU position (x, y, ...) in m."""
        if math.isinf(self.width_m):
            return 0, 0
        return math.floor(position[0] / self.width_m), math.floor(position[1] / self.width_m)

    def around(self, positions: Iterable[tuple[float, ...]], extra_m: float = 0.0) -> set[Tile]:
        """Every tile within ``reach_m + extra_m`` of one of the positions."""
        if math.isinf(self.width_m):
            return {(0, 0)}
        tiles: set[Tile] = set()
        radius = self.reach_m + extra_m
        for x, y, *_ in positions:
            columns = self._span(x - radius, x + radius)
            rows = self._span(y - radius, y + radius)
            tiles.update((i, j) for i in columns for j in rows if self._near(i, j, x, y, radius))
        return tiles

    def _span(self, low: float, high: float) -> range:
        return range(math.floor(low / self.width_m), math.floor(high / self.width_m) + 1)

    def _near(self, i: int, j: int, x: float, y: float, radius: float) -> bool:
        """Whether the circle around (x, y) meets the tile."""
        nearest_x = min(max(x, i * self.width_m), (i + 1) * self.width_m)
        nearest_y = min(max(y, j * self.width_m), (j + 1) * self.width_m)
        return math.hypot(nearest_x - x, nearest_y - y) <= radius
