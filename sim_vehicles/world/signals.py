"""The receiver of target signals: how strong, not from where.

Zhou 2023, section 2: a robot hears a target within d_tar, and has found it within d_0.
The law of the strength, Eq. (1), is the caller's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from planners.terrain import Terrain

_F64 = npt.NDArray[np.float64]


class SignalHeard(NamedTuple):
    """One target's signal at one vehicle."""

    vehicle: int  # its row
    target: int  # its row
    strength: float
    arrived: bool


@dataclass(frozen=True, slots=True)
class ReceiverSpec:
    """True properties of receivers and targets."""

    strength: Callable[[_F64, _F64], _F64]  # of distances (m) and standard normal draws
    range_m: float = 100.0  # d_tar
    arrival_m: float = 10.0  # d_0
    period_s: float = 1.0
    silent_when_found: bool = True


class SignalReceiver:
    """One receiver a vehicle, each with its own random stream.

    Strengths are those of the distance in space. Whether a vehicle has arrived is told by the
    distance of the ground below it, so that one in the air can find a target too.

    Args:
        targets: (m, 2) ENU m, on the ground.
        terrain: the ground; None: level, at height 0.
        spec: of all receivers.
        generators: one a vehicle; draws depend on nothing but how often it listened.
    """

    def __init__(
        self,
        targets: _F64,
        terrain: Terrain | None,
        spec: ReceiverSpec,
        generators: Sequence[np.random.Generator],
    ) -> None:
        self._terrain = terrain
        self._spec = spec
        self._generators = generators
        self._targets = self._ground(np.reshape(targets, (-1, 2)))
        self._found = np.zeros(len(self._targets), dtype=np.bool_)
        self._period_us = round(spec.period_s * 1e6)
        self._next_us = 0

    def listen(self, t_us: int, position: _F64) -> list[SignalHeard]:
        """Signals due at ``t_us`` at positions (n, 3) ENU m, in order of vehicles, then targets."""
        if t_us < self._next_us or not len(self._targets):
            return []
        self._next_us = t_us + self._period_us
        spec = self._spec
        distance = _length(position[:, None] - self._targets)
        below = self._ground(position[:, :2])
        arrived = _length(below[:, None] - self._targets) < spec.arrival_m
        audible = (distance <= spec.range_m) & ~(self._found & spec.silent_when_found)
        self._found |= arrived.any(axis=0)
        noise = np.stack([one.standard_normal(len(self._targets)) for one in self._generators])
        strength = np.where(audible, spec.strength(distance, noise), 0.0)
        return [
            SignalHeard(i, j, float(strength[i, j]), bool(arrived[i, j]))
            for i, j in np.argwhere(audible | arrived).tolist()
        ]

    def _ground(self, points: _F64) -> _F64:
        terrain = self._terrain
        z = np.zeros(len(points)) if terrain is None else terrain.height_at(points)
        return np.column_stack((points, z))


def _length(vectors: _F64) -> _F64:
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    return np.asarray(np.sqrt(x * x + y * y + z * z))
