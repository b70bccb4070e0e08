"""A suballiance message as bytes: the planner's payload of a frame.

Little-endian: version (1), flags (1: class I, 2: free, 4: leads), task (i4, -1 none),
strength, best and its place (f8 each: I, I, x, y, z), number of the roster (u1) and its
ids (u4 each), number of found targets (u1) and those (u4 each). More found targets than
fit take turns.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

VERSION = 1
FOUND_AT_ONCE = 32
_HEAD = struct.Struct("<BBi5d")


@dataclass(frozen=True, slots=True)
class Told:
    """One robot's message; targets and robots by their ids."""

    task: int = -1
    first: bool = False
    free: bool = False
    leads: bool = False
    strength: float = 0.0
    best: float = -math.inf
    best_place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    roster: tuple[int, ...] = ()
    found: tuple[int, ...] = ()


def encode(told: Told, tick: int) -> bytes:
    """Bytes of a message; ``tick`` chooses among more found targets than fit."""
    flags = told.first + 2 * told.free + 4 * told.leads
    found = told.found
    if len(found) > FOUND_AT_ONCE:
        first = tick * FOUND_AT_ONCE % len(found)
        found = (found + found)[first : first + FOUND_AT_ONCE]
    head = _HEAD.pack(VERSION, flags, told.task, told.strength, told.best, *told.best_place)
    return head + _ids(told.roster) + _ids(found)


def decode(data: bytes, members: int) -> Told:
    """The message of a payload; an empty one when the bytes are none, or say nonsense."""
    if len(data) < _HEAD.size or data[0] != VERSION:
        return Told()
    _, flags, task, strength, best, x, y, z = _HEAD.unpack_from(data)
    lists = _lists(data, _HEAD.size)
    if lists is None or task < -1 or not all(map(math.isfinite, (strength, x, y, z))):
        return Told()
    if math.isnan(best) or best == math.inf or len(lists[0]) > members:
        return Told()
    first, free, leads = (bool(flags & bit) for bit in (1, 2, 4))
    return Told(task, first, free, leads, strength, best, (x, y, z), *lists)


def _ids(ids: tuple[int, ...]) -> bytes:
    return struct.pack(f"<B{len(ids)}I", len(ids), *ids)


def _lists(data: bytes, at: int) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
    """The two lists of ids that end the payload, or None when they do not."""
    lists = []
    for _ in range(2):
        if at >= len(data) or at + 1 + 4 * data[at] > len(data):
            return None
        lists.append(struct.unpack_from(f"<{data[at]}I", data, at + 1))
        at += 1 + 4 * data[at]
    return (lists[0], lists[1]) if at == len(data) else None
