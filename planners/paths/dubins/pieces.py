"""Paths made of arcs and straight lines, seen from above."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

F64: TypeAlias = npt.NDArray[np.float64]
Pose: TypeAlias = Sequence[float] | F64  # x, y, psi


@dataclass(frozen=True, slots=True)
class Piece:
    """An arc or a straight line; ``turn`` is 1 to the left, -1 to the right, 0 straight on."""

    turn: int
    length: float  # m


def turned(pose: F64, turn: F64 | int, angle: F64 | float, radius: F64 | float) -> F64:
    """Poses (..., 3) after arcs of ``angle`` (...) rad; a negative one goes backwards."""
    after = pose[..., 2] + turn * angle
    x = pose[..., 0] + turn * radius * (np.sin(after) - np.sin(pose[..., 2]))
    y = pose[..., 1] - turn * radius * (np.cos(after) - np.cos(pose[..., 2]))
    return np.stack(np.broadcast_arrays(x, y, after), axis=-1)


def along(start: Pose, pieces: Sequence[Piece], radius: float, distance: F64) -> F64:
    """Poses (n, 3) at distances (n,) m from the start; the heading is continuous, not wrapped."""
    joints, pose = [], np.asarray(start, dtype=np.float64)
    for piece in pieces:
        joints.append(pose)
        pose = _on(pose, piece, radius, np.asarray(piece.length))
    ends = np.cumsum([piece.length for piece in pieces])
    out = np.empty((len(distance), 3))
    which = np.minimum(np.searchsorted(ends, distance), len(pieces) - 1)
    for place, (piece, joint) in enumerate(zip(pieces, joints, strict=True)):
        mine = which == place
        travelled = np.clip(distance[mine] - (ends[place] - piece.length), 0.0, piece.length)
        out[mine] = _on(joint, piece, radius, travelled)
    return out


def misses(start: Pose, pieces: Sequence[Piece], radius: float, end: Pose) -> bool:
    """Whether the pieces, flown forwards, end anywhere but at the pose ``end``."""
    total = math.fsum(piece.length for piece in pieces)
    reached = along(start, pieces, radius, np.array([total]))[0]
    slack = 1e-8 * (radius + total)
    angle = math.remainder(float(reached[2]) - float(end[2]), math.tau)
    offset = math.hypot(float(reached[0]) - float(end[0]), float(reached[1]) - float(end[1]))
    return not (offset <= slack and abs(angle) <= 1e-7)


def _on(pose: F64, piece: Piece, radius: float, distance: F64) -> F64:
    if piece.turn:
        return turned(pose, piece.turn, distance / radius, radius)
    x = pose[0] + distance * math.cos(pose[2])
    y = pose[1] + distance * math.sin(pose[2])
    return np.stack(np.broadcast_arrays(x, y, pose[2]), axis=-1)
