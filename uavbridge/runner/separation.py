"""How near any two vehicles came to each other in the air."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, nan

import numpy as np

from planners.terrain import Terrain
from planners.types import F64, I64
from uavbridge.config import Mission

AIRBORNE_M = 0.5  # above the ground; below it a vehicle is not in the air


@dataclass(frozen=True, slots=True)
class Floor:
    """Heights below which vehicles do not count as near each other; rovers always do.

    Attributes:
        terrain: None: level.
        driving: agents whose vehicles are rovers.
    """

    terrain: Terrain | None = None
    driving: frozenset[int] = frozenset()

    @staticmethod
    def of(mission: Mission, terrain: Terrain | None) -> Floor:
        """Of a mission and its terrain."""
        return Floor(terrain, frozenset(m.id for m in mission.team() if m.kind == "rover"))

    def under(self, ids: Sequence[int], position: F64) -> float | F64:
        """Ground height (n,) in m under vehicles (n, 3), or one for all."""
        if self.terrain is None and not self.driving:
            return 0.0
        ground = np.zeros(len(ids)) if self.terrain is None else self.terrain.height_at(position)
        return np.where([agent in self.driving for agent in ids], -inf, ground)


class SeparationWatch:
    """Closest approach of airborne pairs, also between two samples of the positions."""

    def __init__(self) -> None:
        self.closest_m = inf
        self.at_us = 0
        self._recent = inf
        self._last: F64 | None = None
        self._pairs: tuple[I64, I64] = (np.zeros(0, np.int64), np.zeros(0, np.int64))

    def add(self, t_us: int, position: F64, *, ground_m: float | F64 = 0.0) -> None:
        """Positions (n, 3) ENU m of the same vehicles in the same order as before.

        Args:
            t_us: mission time.
            position: theirs.
            ground_m: height of the ground, of all or (n,); -inf: one that counts there too.
        """
        last = self._last
        self._last = position
        if last is None or len(last) != len(position):
            last = position
        flying = position[:, 2] > ground_m + AIRBORNE_M
        if len(self._pairs[0]) != len(position) * (len(position) - 1) // 2:
            self._pairs = np.triu_indices(len(position), 1)
        i, j = self._pairs
        both = flying[i] & flying[j]
        if not both.any():
            return
        i, j = i[both], j[both]
        closest = float(np.sqrt(_approach(last[i] - last[j], position[i] - position[j]).min()))
        self._recent = min(self._recent, closest)
        if closest < self.closest_m:
            self.closest_m, self.at_us = closest, t_us

    def recall(self, t_us: int, closest_m: float) -> None:
        """What was closest at a moment before the first positions, as somebody else tells it."""
        if closest_m < self.closest_m:
            self.closest_m, self.at_us = closest_m, t_us

    def take_recent(self) -> float:
        """Closest (m) since the last call; NaN with fewer than two in the air."""
        recent, self._recent = self._recent, inf
        return recent if recent < inf else nan

    @property
    def closest(self) -> float:
        """Closest (m) so far; NaN when there never were two in the air."""
        return self.closest_m if self.closest_m < inf else nan


def _approach(before: F64, after: F64) -> F64:
    """Smallest squared distance (k,) on the way from one offset (k, 3) to another."""
    move = after - before
    length = np.einsum("ij,ij->i", move, move)
    along = -np.einsum("ij,ij->i", before, move)
    share = np.clip(along / np.maximum(length, 1e-12), 0.0, 1.0)
    nearest = before + share[:, None] * move
    squares: F64 = np.einsum("ij,ij->i", nearest, nearest)
    return squares
