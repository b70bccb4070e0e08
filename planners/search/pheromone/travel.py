"""How a leader and its followers travel, one row of the kernels (Shao 2020, Algorithms 2, 3).

Lengths are cells, a cell's centre at its number; velocities are cells in a step of the leader.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.grid import Grid
from planners.pheromone.field import Field, disc
from planners.pheromone.follow import follow
from planners.pheromone.lead import cell_of, sensed, vector_step
from planners.pheromone.words import Local
from planners.search.pheromone.columns import closed_cells
from planners.search.pheromone.params import ScenarioParams
from planners.types import F64, I64, Bools

_FASTEST = 1e6  # the printed form leaves all bounds
_TURNS = np.deg2rad((0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0, 130.0, -130.0, 180.0))


def in_cells(grid: Grid, points: F64) -> F64:
    """ENU m (..., 2 or more) as cells (..., 2)."""
    origin = np.array((grid.west_m, grid.south_m))
    return np.asarray((points[..., :2] - origin) / grid.cell_m - 0.5)


@dataclass(frozen=True, slots=True)
class Travel:
    """The rules of travel.

    Args:
        grid: the lattice.
        params: Table 2.
        centre: cell of the target region's centre.
    """

    grid: Grid
    params: ScenarioParams
    centre: tuple[int, int]

    def led(self, place: F64, way: F64, local: Local | None, columns: F64) -> F64:
        """Velocity (2,) of a leader's next step, Algorithm 2; zero when it is there.

        Args:
            place: (2,) where the last step ended.
            way: (2,) velocity of the last step.
            local: the field there; None: not known, then straight to the region.
            columns: (k, 3) those known, in m.
        """
        params = self.params
        ahead = np.array(self.centre) - place
        distance = float(np.hypot(ahead[0], ahead[1]))
        if distance <= params.leader_sensor or local is None:
            way = ahead * min(1.0, params.length / max(distance, 1e-9))
            return self._round_columns(place, way, columns)
        total, closed = self._maps(place, local, columns)
        radius = float(params.leader_sensor)
        return vector_step(place, way, total, closed, radius, params.length)

    def _maps(self, place: F64, local: Local, columns: F64) -> tuple[F64, Bools]:
        """What the leader senses, and what is closed, as far as it knows."""
        params, shape = self.params, self.grid.shape
        names = (local.target, local.obstacle, local.path)
        parts = Field(*(np.append(layer, own) for layer, own in zip(names, local.own, strict=True)))
        values = sensed(parts, params.weights, params.scale, params.sense == "log")
        total = np.full(shape, values[-1])  # what is not known has no slope
        cells = local.cells()
        known = cells[local.known]
        total[known[:, 0], known[:, 1]] = values[:-1][local.known]
        closed = np.zeros(shape, np.bool_)
        shut = cells[local.closed & local.known]
        closed[shut[:, 0], shut[:, 1]] = True
        seen = self.closed_near(place, columns)
        closed[seen[:, 0], seen[:, 1]] = True
        return total, closed

    def closed_near(self, place: F64, columns: F64) -> I64:
        """Cells (k, 2) of columns in the leader's range."""
        around = cell_of(place) + disc(float(self.params.leader_sensor))
        around = around[self.grid.inside(around)]
        shut = closed_cells(self.grid, columns, around, self.params.clearance_m)
        return np.asarray(around[shut])

    def followed(
        self,
        place: F64,
        way: F64,
        others: tuple[F64, F64],
        leader: tuple[F64, F64],
        columns: F64,
    ) -> F64:
        """Velocity (2,) of a follower after a whole step, Algorithm 3.

        Args:
            place: (2,) where it is.
            way: (2,) its velocity.
            others: places and velocities (k, 2) of the other followers heard.
            leader: place and velocity (2,) of the leader.
            columns: (k, 3) those in sight, in m.
        """
        present = np.ones(len(others[0]), np.bool_)
        law = self.params.law
        velocity = follow(place, way, others[0], others[1], present, leader[0], leader[1], law)
        velocity = np.clip(np.nan_to_num(velocity), -_FASTEST, _FASTEST)
        return self._round_columns(place, velocity, columns)

    def _round_columns(self, place: F64, velocity: F64, columns: F64) -> F64:
        """The velocity, turned as little as keeps its next step out of columns."""
        if not len(columns):
            return velocity
        point = (place + 0.5) * self.grid.cell_m + (self.grid.west_m, self.grid.south_m)
        step = velocity * self.grid.cell_m
        length = float(np.hypot(step[0], step[1]))
        reach = np.minimum(np.linspace(0.25, 1.0, 4) * length, 2.0 * self.grid.cell_m)
        for turn in _TURNS:
            cos, sin = np.cos(turn), np.sin(turn)
            way = np.array((cos * step[0] - sin * step[1], sin * step[0] + cos * step[1]))
            track = point + reach[:, None] * way / max(length, 1e-9)
            apart = track[:, None] - columns[:, :2]
            room = np.hypot(apart[..., 0], apart[..., 1]) - columns[:, 2]
            if (room >= self.params.clearance_m).all():
                return np.asarray(way / self.grid.cell_m)
        return velocity
