r"""The way of the flock: RRT ways judged by Dubins lengths, and one way for all.

Chen 2023, section 4.2. Every way is judged by Eq. (27) with airplane lengths,

    J = sum_k L_D(x_k, x_k+1),

its nodes being corners of smoothed RRT ways that lead to the aim, so that Eq. (27)'s last term,
which sees no obstacle, is zero. The paper plans for each aircraft and each second anew; then a
flock may pass an obstacle on both sides, and sides change. Here the best placed aircraft plans,
its way goes from neighbour to neighbour, and a new one must be better by a few percent.
``prediction`` has the paper's own scheme.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from planners.flocking.starling.wing import Wing
from planners.paths import rrt
from planners.paths.dubins import airplane_lengths
from planners.paths.ground import path_gap
from planners.terrain import Terrain
from planners.types import F64


@dataclass(frozen=True, slots=True)
class RouteRules:
    """How ways are planned and followed."""

    clearance_m: float = 40.0  # of the way above ground
    ceiling_m: float = 300.0
    climb_rad: float = 0.25
    margins_m: tuple[float, ...] = (150.0, 100.0, 60.0, 30.0, 0.0)  # to the sides, tried in order
    step_m: float = 150.0
    samples: int = 2500
    goal_bias: float = 0.15
    ways: int = 3  # RRT ways among which the best is taken
    better: float = 0.07  # share of J by which a new way must be better
    ahead_m: float = 300.0  # aircraft fly to the point this far along the way


def widened(terrain: Terrain, margin_m: float) -> Terrain:
    """Ground as high as the highest point within ``margin_m`` to the sides."""
    reach = math.ceil(margin_m / terrain.cell_m - 1e-9)
    padded = np.pad(terrain.heights, reach, mode="edge")
    columns, rows = terrain.heights.shape
    out = terrain.heights.copy()
    for east in range(-reach, reach + 1):
        for north in range(-reach, reach + 1):
            if math.hypot(east, north) * terrain.cell_m <= margin_m + 1e-9:
                at = padded[reach + east : reach + east + columns, reach + north :][:, :rows]
                np.maximum(out, at, out=out)
    return replace(terrain, heights=out)


def grounds(terrain: Terrain, rules: RouteRules) -> list[Terrain]:
    """The terrain widened by each of the margins."""
    return [widened(terrain, margin) for margin in rules.margins_m]


def plan(
    ground: Terrain,
    start: F64,
    course_rad: float,
    aim: F64,
    rules: RouteRules,
    wing: Wing,
    speed_m_s: float,
    rng: Generator,
) -> F64 | None:
    """The best way (k, 3) found from ``start`` (3,) to ``aim`` (3,), or None.

    None too where start or aim is nearer to the ground than a way may come.
    """
    grow = rrt.RrtRules(
        step_m=rules.step_m,
        clearance_m=rules.clearance_m,
        ceiling_m=rules.ceiling_m,
        climb_rad=rules.climb_rad,
        goal_bias=rules.goal_bias,
        nodes=rules.samples,
    )
    found = _ways(ground, start, aim, grow, rules.ways, rng)
    return min(found, key=lambda way: score(way, course_rad, wing, speed_m_s), default=None)


def score(way: F64, course_rad: float, wing: Wing, speed_m_s: float) -> float:
    """Eq. (27) of a way (k, 3) that ends at the aim, m. Headings at corners halve the turn."""
    legs = np.diff(way[:, :2], axis=0)
    course = np.arctan2(legs[:, 1], legs[:, 0])
    turn = np.angle(np.exp(1j * np.diff(course)))
    heading = np.concatenate(([course_rad], course[:-1] + turn / 2.0, course[-1:]))
    poses = np.column_stack((way, heading))
    radius, climb = wing.radius(speed_m_s), min(wing.climb_rad, wing.sink_rad)
    return float(airplane_lengths(poses[:-1], poses[1:], radius, climb).sum())


def blocked(terrain: Terrain, way: F64, clearance_m: float) -> bool:
    """Whether a way (k, 3) comes nearer to the ground than that."""
    return path_gap(terrain, way) < clearance_m


def ahead(way: F64, position: F64, ahead_m: float) -> F64:
    """Points (n, 3) to fly to: ``ahead_m`` along the way (k, 3) from where each is beside it.

    Beyond its end the way goes straight on.
    """
    legs = np.diff(way, axis=0)
    lengths = np.sqrt((legs * legs).sum(axis=-1))
    towards = legs / np.maximum(lengths, 1e-9)[:, None]
    offset = position[:, None] - way[:-1]
    along = np.clip((offset * towards).sum(axis=-1), 0.0, lengths)
    away = offset - along[..., None] * towards
    leg = np.argmin((away * away).sum(axis=-1), axis=-1)
    ends = np.concatenate(([0.0], np.cumsum(lengths)))
    travelled = ends[leg] + along[np.arange(len(position)), leg] + ahead_m
    points = np.stack([np.interp(travelled, ends, way[:, axis]) for axis in range(3)], axis=-1)
    beyond = np.maximum(travelled - ends[-1], 0.0)
    return np.asarray(points + beyond[:, None] * towards[-1])


def remaining(way: F64, position: F64) -> F64:
    """What of a way (k, 3) is left to one that is beside it at ``position`` (3,): from there on.

    To one that is past its end, a metre straight on.
    """
    legs = np.diff(way, axis=0)
    square = np.maximum((legs * legs).sum(axis=-1), 1e-9)
    along = np.clip(((position - way[:-1]) * legs).sum(axis=-1) / square, 0.0, 1.0)
    away = position - way[:-1] - along[:, None] * legs
    leg = int(np.argmin((away * away).sum(axis=-1)))
    if leg == len(legs) - 1 and along[leg] >= 1.0:
        return np.stack((position, position + legs[leg] / np.sqrt(square[leg])))
    return np.concatenate((position[None], way[leg + 1 :]))


def _ways(
    ground: Terrain, start: F64, aim: F64, grow: rrt.RrtRules, count: int, rng: Generator
) -> list[F64]:
    found: list[F64] = []
    for _ in range(count):
        try:
            path = rrt.plan(ground, start, aim, grow, rng)
        except ValueError:  # start or aim too near the ground for this margin
            return []
        if path is None:
            break
        found.append(path.points)
        if not path.samples:  # straight
            break
    return found
