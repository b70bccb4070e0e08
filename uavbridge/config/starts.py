"""Who flies and from where: agent ids, given starts, and starts placed on a lattice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from planners.grid import Grid
from planners.types import F64, Bools
from uavbridge.config.tables import MAX_VEHICLES, Agent, Fleet, Kind, Point

Stands: TypeAlias = Callable[[F64], Bools]


@dataclass(frozen=True, slots=True)
class Member:
    """One agent of the team, with everything settled."""

    id: int
    start: Point  # ENU m
    altitude_m: float  # search altitude above home, or above the terrain; 0 on the ground
    kind: Kind = "multirotor"


def team(
    grid: Grid,
    fleet: Fleet,
    agents: tuple[Agent, ...],
    vehicles: int,
    stands: Stands | None = None,
) -> tuple[Member, ...]:
    """The members by ascending id.

    The first ``vehicles`` agents listed belong to the team, and further ids are the lowest free
    ones from 1. A member starts at its own start, else at its place in ``fleet.starts``, else
    at a free point of the lattice, of those that vehicles can stand on.

    Raises:
        ValueError: the area has no room for so many at this spacing.
    """
    own = {agent.id: agent for agent in agents[:vehicles]}
    free = (number for number in range(1, MAX_VEHICLES + 1) if number not in own)
    ids = sorted([*own, *(next(free) for _ in range(vehicles - len(own)))])
    given: list[Point | None] = [*fleet.starts[:vehicles]]
    given += [None] * (vehicles - len(given))
    for place, number in enumerate(ids):
        if number in own and (start := own[number].start) is not None:
            given[place] = start
    placed = iter(
        lattice(
            grid, [point for point in given if point], fleet.spacing_m, given.count(None), stands
        )
    )
    return tuple(
        _member(number, point or next(placed), own.get(number), fleet)
        for number, point in zip(ids, given, strict=True)
    )


def _member(number: int, start: Point, agent: Agent | None, fleet: Fleet) -> Member:
    kind = fleet.kind if agent is None or agent.kind is None else agent.kind
    given = None if agent is None else agent.altitude_m
    altitude_m = fleet.altitude_m if given is None else given
    return Member(number, start, 0.0 if kind == "rover" else altitude_m, kind)


def lattice(
    grid: Grid,
    taken: list[Point],
    spacing_m: float,
    count: int,
    stands: Stands | None = None,
) -> list[Point]:
    """Points of a square lattice in the area, one spacing from each other and from those taken.

    With points taken, the lattice goes through the first one and the nearest to their
    middle come first; else it fills the area from its south-western corner.

    Raises:
        ValueError: fewer than ``count`` fit.
    """
    if count == 0:
        return []
    west, south, east, north = grid.bounds
    anchor = taken[0] if taken else (west + spacing_m / 2, south + spacing_m / 2)
    xs, ys = _axis(anchor[0], west, east, spacing_m), _axis(anchor[1], south, north, spacing_m)
    points = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
    middle = np.mean(taken, axis=0) if taken else np.array([west, south])
    for point in taken:
        points = points[np.hypot(*(points - point).T) > spacing_m - 1e-6]
    if stands is not None:
        points = points[stands(points)]
    if len(points) < count:
        where = "" if stands is None else ", on ground no steeper than terrain.alpha_deg,"
        raise ValueError(
            f"only {len(points)} more starts fit into the area{where} at a spacing of "
            f"{spacing_m:g} m, {count} are needed"
        )
    distance = np.round(np.hypot(*(points - middle).T), 3)
    order = np.lexsort((points[:, 1], points[:, 0], distance))[:count]
    return [(float(x), float(y)) for x, y in points[order]]


def _axis(anchor: float, low: float, high: float, spacing_m: float) -> F64:
    """Lattice lines between low and high, at most as many to each side as there are vehicles."""
    first = max(np.ceil((low - anchor) / spacing_m - 1e-9), -MAX_VEHICLES)
    last = min(np.floor((high - anchor) / spacing_m + 1e-9), MAX_VEHICLES)
    lines: F64 = anchor + np.arange(first, last + 1) * spacing_m
    return np.clip(lines, low, high)
