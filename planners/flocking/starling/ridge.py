"""Escape from the ground: the ground is a danger that is seen ahead.

The paper names obstacles and has no rule for them. An aircraft follows what it wants ahead for
some seconds; where that comes too near the ground, it tries harder turns to both sides, climbing
or not, and takes the clear one nearest to what it wanted, or else the one that stays highest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.flocking.starling import wing as wings
from planners.flocking.starling.wing import Wing
from planners.terrain import Terrain
from planners.types import F64, Bools

_SIDES = np.array((-1.0, -0.6, -0.3, 0.0, 0.3, 0.6, 1.0))
_RISES = np.array((0.0, 0.5, 1.0))
_LOOK_S = 0.5
_TURN_LIMIT = 2.0  # rad: a trial turn goes no further


@dataclass(frozen=True, slots=True)
class Watch:
    """How the ground is watched."""

    clearance_m: float = 25.0
    ahead_s: float = 7.0
    ceiling_m: float = 350.0  # climbs beyond are taken only when nothing else is clear


def avoid(
    position: F64, velocity: F64, wish: F64, terrain: Terrain, wing: Wing, watch: Watch
) -> tuple[F64, Bools]:
    """Accelerations (..., n, 3) clear of the ground, and who (..., n) had to change its wish."""
    lead = position.shape[:-1]
    place, moving = position.reshape(-1, 3), velocity.reshape(-1, 3)
    out = wish.reshape(-1, 3).copy()
    speed, course, climb = wings.parts(moving)
    _, left, up = wings.split(out, course, climb)
    left = np.clip(left, -wing.across_m_s2, wing.across_m_s2)
    aimed = climb + np.clip(up, -wing.pull_m_s2, wing.pull_m_s2) / np.maximum(speed, 1.0)
    aimed = np.clip(aimed, -wing.sink_rad, wing.climb_rad)
    own, _ = _gap(place, moving, left[:, None], aimed[:, None], terrain, wing, watch)
    blocked = own[:, 0] < 0.0
    who = np.nonzero(blocked)[0]
    if len(who):
        trial_left, trial_climb = _trials(aimed[who], wing)
        gap, top = _gap(place[who], moving[who], trial_left, trial_climb, terrain, wing, watch)
        cost = np.abs(trial_left - left[who, None]) / wing.across_m_s2
        cost = cost + 1.5 * np.abs(trial_climb - aimed[who, None]) / wing.climb_rad
        cost = cost + 2.0 * (top > watch.ceiling_m)
        cost = np.where(gap >= 0.0, cost, 1e6 - gap)
        rows = np.arange(len(who))
        best = np.argmin(cost, axis=-1)
        rise = trial_climb[rows, best] - climb[who]
        out[who] = _acceleration(
            out[who], course[who], climb[who], trial_left[rows, best], rise * speed[who]
        )
    return out.reshape(wish.shape), blocked.reshape(lead)


def _trials(aimed: F64, wing: Wing) -> tuple[F64, F64]:
    left = np.repeat(_SIDES, len(_RISES)) * wing.across_m_s2
    rise = np.tile(_RISES, len(_SIDES))
    target = aimed[:, None] + rise * (wing.climb_rad - aimed[:, None])
    return np.broadcast_to(left, target.shape), target


def _gap(
    place: F64, moving: F64, left: F64, target: F64, terrain: Terrain, wing: Wing, watch: Watch
) -> tuple[F64, F64]:
    """Least height over the clearance (m, c) of trial turns, and where they end (m, c), in m."""
    speed, course, climb = wings.parts(moving)
    time = np.arange(1, round(watch.ahead_s / _LOOK_S) + 1) * _LOOK_S
    rate = left / np.maximum(speed, 1.0)[:, None]
    turned = np.clip(rate[..., None] * time, -_TURN_LIMIT, _TURN_LIMIT)
    most = (wing.pull_m_s2 / np.maximum(speed, 1.0))[:, None, None] * time
    rise = np.clip((target - climb[:, None])[..., None], -most, most)
    pace = wings.whole(
        speed[:, None, None], course[:, None, None] + turned, climb[:, None, None] + rise
    )
    points = place[:, None, None] + np.cumsum(pace * _LOOK_S, axis=-2)
    above = points[..., 2] - terrain.height_at(points) - watch.clearance_m
    return above.min(axis=-1), points[..., -1, 2]


def _acceleration(wish: F64, course: F64, climb: F64, left: F64, up: F64) -> F64:
    """The wish (m, 3) with its parts across the path replaced."""
    along, _, _ = wings.split(wish, course, climb)
    level = along * np.cos(climb) - up * np.sin(climb)
    return np.stack(
        (
            level * np.cos(course) - left * np.sin(course),
            level * np.sin(course) + left * np.cos(course),
            along * np.sin(climb) + up * np.cos(climb),
        ),
        axis=-1,
    )
