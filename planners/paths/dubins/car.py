r"""Dubins' car: the shortest way between two poses at a least turning radius.

Dubins 1957; Chen 2023, section 4.1. A word names three pieces, such as LSR: an arc to the left,
a straight line, an arc to the right. With the circles' centres c_s and c_e, D = c_e - c_s at the
angle theta and lambda = 1 to the left, -1 to the right:

- CSC: the straight line has length p = sqrt(|D|^2 - ((lambda_e - lambda_s) R)^2) and heading
  chi = theta - atan2((lambda_e - lambda_s) R, p);
- CCC: the middle circle touches both; seen from c_s it lies at theta + lambda beta with
  cos beta = |D| / 4R, and the middle arc is pi + 2 beta.

Everything is batched: a thousand pairs of poses cost little more than one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from planners.paths.dubins.pieces import F64, Piece, Pose, along, misses

WORDS = ("LSL", "LSR", "RSL", "RSR", "RLR", "LRL")
TURNS = tuple(tuple({"L": 1, "S": 0, "R": -1}[letter] for letter in word) for word in WORDS)

_FIRST = np.array([turns[0] for turns in TURNS], dtype=np.float64)
_LAST = np.array([turns[2] for turns in TURNS], dtype=np.float64)
_TOUCHING = 1e-9  # rad, and in radii: smaller arcs and lines are rounding
_FULL = 2.0 * math.pi


@dataclass(frozen=True, slots=True)
class CarPath:
    """A path of a car."""

    word: str
    length: float  # m
    radius: float  # m
    start: tuple[float, float, float]
    pieces: tuple[Piece, ...]

    def points(self, step: float) -> F64:
        """Poses (n, 3) x, y, psi from start to end, no more than ``step`` m apart.

        psi is continuous: at the end it may differ from the end's by whole turns.
        """
        return along(self.start, self.pieces, self.radius, distances(self.length, step))


def shortest_car(start: Pose, end: Pose, r_min: float) -> CarPath:
    """The shortest path between two poses x, y, psi.

    Raises:
        ValueError: a pose is not three finite numbers, or the radius is not positive.
    """
    first, last = _pose(start), _pose(end)
    radius = positive(r_min, "r_min")
    for path in by_length(first, last, radius):
        if not misses(path.start, path.pieces, radius, last):
            return path
    raise ValueError(f"no path from {first} to {last} at radius {radius:g} m in double precision")


def by_length(start: Pose, end: Pose, radius: float) -> list[CarPath]:
    """The words that exist between two poses, the shortest first."""
    lengths = words(np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64), radius)
    total = lengths.sum(axis=-1)
    order = [place for place in np.argsort(total, kind="stable") if np.isfinite(total[place])]
    origin = (float(start[0]), float(start[1]), float(start[2]))
    return [
        CarPath(WORDS[at], float(total[at]), radius, origin, pieces_of(at, lengths[at]))
        for at in order
    ]


def car_lengths(start: F64, end: F64, r_min: float | F64) -> F64:
    """Lengths (...) m of the shortest paths between poses (..., 3)."""
    return np.asarray(words(start, end, r_min).sum(axis=-1).min(axis=-1))


def words(start: F64, end: F64, radius: float | F64) -> F64:
    """Lengths (..., 6, 3) m of the pieces of all six words; inf where a word does not exist.

    Args:
        start: (..., 3) x, y, psi.
        end: (..., 3).
        radius: (...) m.
    """
    around = np.asarray(radius, dtype=np.float64)[..., None]
    leaving, arriving = start[..., 2, None], end[..., 2, None]
    dx = end[..., 0, None] - start[..., 0, None]
    dy = end[..., 1, None] - start[..., 1, None]
    dx = dx - around * (_LAST * np.sin(arriving) - _FIRST * np.sin(leaving))
    dy = dy + around * (_LAST * np.cos(arriving) - _FIRST * np.cos(leaving))
    apart, theta = np.hypot(dx, dy), np.arctan2(dy, dx)
    csc = _csc(apart[..., :4], theta[..., :4], leaving, arriving, around)
    ccc = _ccc(apart[..., 4:], theta[..., 4:], leaving, arriving, around)
    return np.concatenate((csc, ccc), axis=-2)


def pieces_of(word: int, lengths: F64) -> tuple[Piece, ...]:
    """Pieces of the word numbered ``word`` from their lengths (3,)."""
    return tuple(
        Piece(turn, float(length)) for turn, length in zip(TURNS[word], lengths, strict=True)
    )


def distances(length: float, step: float) -> F64:
    """Distances (n,) from 0 to ``length``, evenly spaced, no more than ``step`` apart."""
    count = max(math.ceil(length / positive(step, "step") - 1e-9), 1)
    return np.linspace(0.0, length, count + 1)


def positive(value: float, name: str) -> float:
    """The value. Raises ValueError when it is not a positive finite number."""
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name} must be positive and finite, not {value}")
    return float(value)


def _csc(apart: F64, theta: F64, leaving: F64, arriving: F64, radius: F64) -> F64:
    first, last = _FIRST[:4], _LAST[:4]
    across = (last - first) * radius
    width = np.abs(across)
    exists = apart >= width
    line = np.sqrt(np.where(exists, (apart - width) * (apart + width), 0.0))
    heading = theta - np.arctan2(across, line)
    # One circle for both arcs: theta is noise there, and the first arc may take it all.
    same = (across == 0.0) & (apart < _TOUCHING * radius)
    heading = np.where(same, leaving, heading)
    line = np.where(same, 0.0, line)
    begin = _arc(first * (heading - leaving)) * radius
    finish = _arc(last * (arriving - heading)) * radius
    out = np.stack(np.broadcast_arrays(begin, line, finish), axis=-1)
    return np.where(exists[..., None], out, np.inf)


def _ccc(apart: F64, theta: F64, leaving: F64, arriving: F64, radius: F64) -> F64:
    turn = _FIRST[4:]
    ratio = apart / (4.0 * radius)
    exists = ratio <= 1.0
    beta = np.arccos(np.where(exists, ratio, 1.0))
    begin = _arc(turn * (theta - leaving) + beta + math.pi / 2.0) * radius
    middle = (math.pi + 2.0 * beta) * radius
    finish = _arc(turn * (arriving - theta) + beta + math.pi / 2.0) * radius
    out = np.stack(np.broadcast_arrays(begin, middle, finish), axis=-1)
    return np.where(exists[..., None], out, np.inf)


def _arc(angle: F64) -> F64:
    """Angles (...) in [0, 2 pi), those that are a full turn but for rounding taken as none."""
    inside = np.mod(angle, _FULL)
    return np.where(inside > _FULL - _TOUCHING, 0.0, inside)


def _pose(pose: Pose) -> tuple[float, float, float]:
    values = tuple(float(value) for value in pose)
    if len(values) != 3 or not all(math.isfinite(value) for value in values):
        raise ValueError(f"a pose is x, y, psi, three finite numbers, not {pose}")
    return values[0], values[1], values[2]
