"""Wire format v1 of what is no radio traffic: whole maps, what is sensed, the truth.

Same header and same manners as ``uavbridge.bus.wire``: malformed decodes to
None, counted. Described in docs/reference/wire_format.md.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from struct import Struct, error
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from uavbridge.bus.wire import (
    MAGIC,
    POSITION_LIMIT_M,
    VERSION,
    Kind,
    MalformedError,
    accepted,
    check_head,
    check_length,
    check_time,
)

CELL_COUNT_LIMIT = 1 << 24
RADIUS_LIMIT_M = 1e4  # of an obstacle, and of the room to it
NEVER = -1  # stamp of a cell that nobody saw

_FULL_MAP = Struct("<2sBBIqII3d")
_READINGS = Struct("<2sBBIq")
_READING = Struct("<HHB")
_SIGNAL = Struct("<HfB")
_OBSTACLE = Struct("<H4d")
_TRUTH = Struct("<2sBBIq")


@dataclass(frozen=True, slots=True, eq=False)
class FullMap:
    """One agent's whole belief map at one moment.

    Attributes:
        agent: whose it is.
        t_us: when.
        west_m: western edge, ENU m.
        south_m: southern edge, ENU m.
        cell_m: side of a cell.
        probability: (columns, rows) P(target in cell); float32 on the wire.
        stamp_us: (columns, rows) int64 time of the newest look at the cell, -1: never.
    """

    agent: int
    t_us: int
    west_m: float
    south_m: float
    cell_m: float
    probability: npt.NDArray[np.float64]
    stamp_us: npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Readings:
    """What a payload sensor saw at one time: (column, row, detected) of each look."""

    t_us: int
    looks: tuple[tuple[int, int, bool], ...]


@dataclass(frozen=True, slots=True)
class Signals:
    """What a receiver heard at one time: (target, strength, arrived) of each target."""

    t_us: int
    heard: tuple[tuple[int, float, bool], ...]  # strengths are float32 on the wire


class Obstacle(NamedTuple):
    """A column, from the ground up, that nobody may fly through."""

    number: int  # which; what is told of it later takes the place of this
    x: float  # of its axis, ENU m
    y: float
    radius_m: float
    room_m: float  # to be kept to it


@dataclass(frozen=True, slots=True)
class Obstacles:
    """What a detector saw at one time of the obstacles around its vehicle."""

    t_us: int
    seen: tuple[Obstacle, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Where the simulated vehicles are: ids (n,) ascending, positions (n, 3) ENU m."""

    t_us: int
    ids: tuple[int, ...]
    position: npt.NDArray[np.float64]


def encode_map(full: FullMap) -> bytes:
    """The bytes of a whole map.

    Raises:
        ValueError: shapes differ, or a number does not fit its field.
    """
    if full.probability.shape != full.stamp_us.shape or full.probability.ndim != 2:
        raise ValueError(f"map {full.probability.shape} with stamps {full.stamp_us.shape}")
    columns, rows = full.probability.shape
    head = _packed(
        _FULL_MAP,
        Kind.FULL_MAP,
        full.agent,
        full.t_us,
        columns,
        rows,
        full.west_m,
        full.south_m,
        full.cell_m,
    )
    return head + full.stamp_us.astype("<i8").tobytes() + full.probability.astype("<f4").tobytes()


def decode_map(data: bytes, rejects: Counter[str] | None = None) -> FullMap | None:
    """The map in ``data``; None, and its reason counted, when malformed."""
    return accepted(_map, data, rejects)


def encode_readings(readings: Readings) -> bytes:
    """The bytes of sensor readings. Raises ValueError when a number does not fit its field."""
    head = _packed(_READINGS, Kind.READINGS, len(readings.looks), readings.t_us)
    return head + _rows("reading", _READING, readings.looks)


def decode_readings(data: bytes, rejects: Counter[str] | None = None) -> Readings | None:
    """The readings in ``data``; None, and its reason counted, when malformed."""
    return accepted(_readings, data, rejects)


def encode_signals(signals: Signals) -> bytes:
    """The bytes of target signals. Raises ValueError when a number does not fit its field."""
    head = _packed(_READINGS, Kind.SIGNALS, len(signals.heard), signals.t_us)
    return head + _rows("signal", _SIGNAL, signals.heard)


def decode_signals(data: bytes, rejects: Counter[str] | None = None) -> Signals | None:
    """The signals in ``data``; None, and its reason counted, when malformed."""
    return accepted(_signals, data, rejects)


def encode_obstacles(obstacles: Obstacles) -> bytes:
    """The bytes of obstacles seen. Raises ValueError when a number does not fit its field."""
    head = _packed(_READINGS, Kind.OBSTACLES, len(obstacles.seen), obstacles.t_us)
    return head + _rows("obstacle", _OBSTACLE, obstacles.seen)


def decode_obstacles(data: bytes, rejects: Counter[str] | None = None) -> Obstacles | None:
    """The obstacles in ``data``; None, and its reason counted, when malformed."""
    return accepted(_obstacles, data, rejects)


def _rows(name: str, row: Struct, rows: Iterable[Iterable[object]]) -> bytes:
    try:
        return b"".join(row.pack(*one) for one in rows)
    except (error, OverflowError) as fault:
        raise ValueError(f"{name}: {fault}") from None


def encode_truth(truth: Truth) -> bytes:
    """The bytes of the true positions. Raises ValueError when ids and positions differ."""
    count = len(truth.ids)
    if truth.position.shape != (count, 3):
        raise ValueError(f"{count} ids with positions {truth.position.shape}")
    head = _packed(_TRUTH, Kind.TRUTH, count, truth.t_us)
    return head + truth.position.astype("<f8").tobytes() + np.array(truth.ids, "<u4").tobytes()


def decode_truth(data: bytes, rejects: Counter[str] | None = None) -> Truth | None:
    """The true positions in ``data``; None, and its reason counted, when malformed."""
    return accepted(_truth, data, rejects)


def _packed(form: Struct, kind: Kind, *values: float) -> bytes:
    try:
        return form.pack(MAGIC, VERSION, kind, *values)
    except (error, OverflowError) as fault:
        raise ValueError(f"{kind.name.lower()}: {fault}") from None


def _map(data: bytes) -> FullMap:
    check_head(data, _FULL_MAP.size, (Kind.FULL_MAP,))
    _, _, _, agent, t_us, columns, rows, west_m, south_m, cell_m = _FULL_MAP.unpack_from(data)
    count = columns * rows
    if not 0 < count <= CELL_COUNT_LIMIT:
        raise MalformedError("size")
    check_length(data, _FULL_MAP.size + 12 * count)
    check_time(t_us)
    if not (abs(west_m) <= POSITION_LIMIT_M and abs(south_m) <= POSITION_LIMIT_M):
        raise MalformedError("position")
    stamp_us = np.frombuffer(data, "<i8", count, _FULL_MAP.size)
    probability = np.frombuffer(data, "<f4", count, _FULL_MAP.size + 8 * count)
    with np.errstate(invalid="ignore"):  # signalling NaN
        likely = np.all((probability >= 0) & (probability <= 1))
    if not (0 < cell_m <= POSITION_LIMIT_M and likely and np.all(stamp_us >= NEVER)):
        raise MalformedError("value")
    return FullMap(
        agent,
        t_us,
        west_m,
        south_m,
        cell_m,
        probability.astype(np.float64).reshape(columns, rows),
        stamp_us.astype(np.int64).reshape(columns, rows),
    )


def _readings(data: bytes) -> Readings:
    check_head(data, _READINGS.size, (Kind.READINGS,))
    _, _, _, count, t_us = _READINGS.unpack_from(data)
    check_length(data, _READINGS.size + count * _READING.size)
    check_time(t_us)
    looks = tuple(_READING.iter_unpack(data[_READINGS.size :]))
    if any(detected > 1 for _, _, detected in looks):
        raise MalformedError("value")
    return Readings(t_us, tuple((c, r, bool(detected)) for c, r, detected in looks))


def _signals(data: bytes) -> Signals:
    check_head(data, _READINGS.size, (Kind.SIGNALS,))
    _, _, _, count, t_us = _READINGS.unpack_from(data)
    check_length(data, _READINGS.size + count * _SIGNAL.size)
    check_time(t_us)
    heard = tuple(_SIGNAL.iter_unpack(data[_READINGS.size :]))
    if any(arrived > 1 or not isfinite(strength) for _, strength, arrived in heard):
        raise MalformedError("value")
    return Signals(t_us, tuple((t, strength, bool(arrived)) for t, strength, arrived in heard))


def _obstacles(data: bytes) -> Obstacles:
    check_head(data, _READINGS.size, (Kind.OBSTACLES,))
    _, _, _, count, t_us = _READINGS.unpack_from(data)
    check_length(data, _READINGS.size + count * _OBSTACLE.size)
    check_time(t_us)
    seen = tuple(Obstacle(*row) for row in _OBSTACLE.iter_unpack(data[_READINGS.size :]))
    if not all(max(abs(one.x), abs(one.y)) <= POSITION_LIMIT_M for one in seen):
        raise MalformedError("position")
    sizes = [size for one in seen for size in (one.radius_m, one.room_m)]
    if not all(0.0 <= size <= RADIUS_LIMIT_M for size in sizes):
        raise MalformedError("value")
    return Obstacles(t_us, seen)


@lru_cache(maxsize=4)  # in one process the radio and the judge read the same bytes
def _truth(data: bytes) -> Truth:
    check_head(data, _TRUTH.size, (Kind.TRUTH,))
    _, _, _, count, t_us = _TRUTH.unpack_from(data)
    check_length(data, _TRUTH.size + 28 * count)
    check_time(t_us)
    position = np.frombuffer(data, "<f8", 3 * count, _TRUTH.size).astype(np.float64)
    with np.errstate(invalid="ignore"):  # signalling NaN
        low, high = position.min(initial=0.0), position.max(initial=0.0)
    if not (low >= -POSITION_LIMIT_M and high <= POSITION_LIMIT_M):  # NaN neither
        raise MalformedError("position")
    ids = np.frombuffer(data, "<u4", count, _TRUTH.size + 24 * count).tolist()
    if ids != sorted(set(ids)):
        raise MalformedError("value")
    position.flags.writeable = False  # others have it too
    return Truth(t_us, tuple(ids), position.reshape(count, 3))
