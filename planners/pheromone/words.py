"""What UAVs and place agents say to each other, as bytes.

A UAV says in one word where it has moved, which obstacles it has seen, which targets it visits,
and what it wants to be told; a place agent answers with the field around a cell. Both decode to
None from bytes that are none. Little-endian; cells are pairs of 16 bit, (column, row).

| message | bytes |
| --- | --- |
| word | ``W``, number u32, radius u8 (0: no answer), cell, 3 x count u8, cells of each |
| local | ``L``, step u32, radius u8, cell, count of marks u8, the own cell and then three layers |
| | as float32 (NaN: not known), a bit a cell (1: obstacle), marks: a cell and a byte, 1: it waits |
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct, error

import numpy as np

from planners.pheromone.look import Look
from planners.pheromone.sectors import sectors
from planners.types import F64, I64, Bools

ASK = "pheromone"  # the key of ``Ask`` and ``Answer``, and the begin of the names of layers
PATH, OBSTACLE, TARGET = "pheromone/path", "pheromone/obstacle", "pheromone/target"
LAYERS = (PATH, OBSTACLE, TARGET)
MOST = 255  # cells of a kind in one word
MOST_RADIUS = 20

_WORD = Struct("<cIBhhBBB")
_LOCAL = Struct("<cIBhhB")
_QUERY = Struct("<Bhh")
_MARK = Struct("<hhB")
_CELL = 4


def _no_cells() -> I64:
    return np.zeros((0, 2), np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Word:
    """What one UAV deposits and asks at one tick."""

    number: int  # of the tick: the same one twice counts once
    cell: tuple[int, int]  # that it asks about
    radius: int  # of the answer, cells; 0: none is asked for
    path: I64  # (k, 2) cells that it moves to
    obstacles: I64  # (k, 2) cells seen to be obstacles
    targets: I64  # (k, 2) targets that it visits


@dataclass(frozen=True, slots=True, eq=False)
class Local:
    """The field around a cell, in the order of ``sectors(radius)``."""

    step: int  # updates of the map so far
    cell: tuple[int, int]
    radius: int
    target: F64  # (k,)
    obstacle: F64  # (k,)
    path: F64  # (k,)
    own: F64  # (3,) target, obstacle and path pheromone of the cell itself
    known: Bools  # (k,) which the place agent knows
    closed: Bools  # (k,) obstacles
    marks: I64  # (m, 2) cells of found targets in the radius
    due: Bools  # (m,) that wait for a visit

    def look(self) -> Look:
        """As the kernels take it, without leading axes."""
        return Look(self.target, self.obstacle, self.path, self.known, float(self.radius))

    def cells(self) -> I64:
        """The cells (k, 2) that the layers tell of."""
        return np.asarray(sectors(float(self.radius))[0] + np.array(self.cell))


def encode_query(cell: tuple[int, int], radius: int) -> bytes:
    """The data of an ``Ask``."""
    return _QUERY.pack(radius, *cell)


def decode_query(data: bytes) -> tuple[tuple[int, int], int] | None:
    """Cell and radius of an ``Ask``'s data."""
    try:
        radius, column, row = _QUERY.unpack(data)
    except error:
        return None
    return ((column, row), radius) if 0 < radius <= MOST_RADIUS else None


def encode_word(word: Word) -> bytes:
    """The bytes of a word; of more than 255 cells of a kind the first ones."""
    lots = [cells[:MOST] for cells in (word.path, word.obstacles, word.targets)]
    counts = [len(cells) for cells in lots]
    head = _WORD.pack(b"W", word.number, word.radius, *word.cell, *counts)
    return head + b"".join(cells.astype("<i2").tobytes() for cells in lots)


def decode_word(data: bytes) -> Word | None:
    """The word in ``data``."""
    try:
        kind, number, radius, column, row, *counts = _WORD.unpack_from(data)
    except error:
        return None
    if kind != b"W" or radius > MOST_RADIUS or len(data) != _WORD.size + _CELL * sum(counts):
        return None
    cells = np.frombuffer(data, "<i2", offset=_WORD.size).astype(np.int64).reshape(-1, 2)
    path, obstacles, targets = np.split(cells, np.cumsum(counts)[:2])
    return Word(number, (column, row), radius, path, obstacles, targets)


def encode_local(local: Local) -> bytes:
    """The bytes of an answer. A layer's value is NaN where it is not known."""
    marks = min(len(local.marks), MOST)
    head = _LOCAL.pack(b"L", local.step, local.radius, *local.cell, marks)
    layers = (local.target, local.obstacle, local.path)
    parts = [np.where(local.known, layer, np.nan).astype("<f4").tobytes() for layer in layers]
    told = zip(local.marks[:marks].tolist(), local.due.tolist(), strict=False)
    named = b"".join(_MARK.pack(column, row, due) for (column, row), due in told)
    own = local.own.astype("<f4").tobytes()
    return head + own + b"".join(parts) + np.packbits(local.closed).tobytes() + named


def decode_local(data: bytes) -> Local | None:
    """The answer in ``data``."""
    try:
        kind, step, radius, column, row, marks = _LOCAL.unpack_from(data)
    except error:
        return None
    if kind != b"L" or not 0 < radius <= MOST_RADIUS:
        return None
    count = len(sectors(float(radius))[0])
    flags = -(-count // 8)
    end = _LOCAL.size + 12 * (count + 1) + flags
    if len(data) != end + _MARK.size * marks:
        return None
    with np.errstate(invalid="ignore"):  # signalling NaN
        numbers = np.frombuffer(data, "<f4", 3 * count + 3, _LOCAL.size).astype(np.float64)
    own, layers = numbers[:3], numbers[3:].reshape(3, count)
    if np.isinf(numbers).any() or (numbers < 0.0).any() or np.isnan(own).any():
        return None
    known: Bools = np.asarray(~np.isnan(layers).any(axis=0))
    closed = np.unpackbits(np.frombuffer(data, np.uint8, flags, end - flags), count=count)
    target, obstacle, path = np.where(known, layers, 0.0)
    told = list(_MARK.iter_unpack(data[end:]))
    return Local(
        step,
        (column, row),
        radius,
        target,
        obstacle,
        path,
        own,
        known,
        closed.astype(np.bool_),
        np.array([mark[:2] for mark in told], np.int64).reshape(-1, 2),
        np.array([mark[2] > 0 for mark in told], np.bool_),
    )


def no_word(number: int, cell: tuple[int, int]) -> Word:
    """A word that says nothing."""
    return Word(number, cell, 0, _no_cells(), _no_cells(), _no_cells())
