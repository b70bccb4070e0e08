"""Wire format v1 of what agents send each other: frames and position beacons.

Little-endian, described byte by byte in docs/reference/wire_format.md. Whatever
is malformed decodes to None and its reason is counted; decoding never raises.
"""

from __future__ import annotations

import logging
from collections import Counter
from dataclasses import dataclass
from enum import IntEnum
from struct import Struct, error
from typing import TypeAlias

Vector: TypeAlias = tuple[float, float, float]

MAGIC = b"UB"
VERSION = 1
POSITION_LIMIT_M = 1e6
SPEED_LIMIT_M_S = 1e4
TIME_LIMIT_US = 1 << 53  # also exact in a JSON number
CELLS_LIMIT = 1 << 24  # bytes

_HEAD = Struct("<2sBB")
_FRAME = Struct("<2sBBIIHHq3f3fI")
_BEACON = Struct("<2sBBIq3f3f")

_log = logging.getLogger(__name__)


class Kind(IntEnum):
    """Fourth byte of every message."""

    DELTA = 1  # frame with the cells that changed
    KEYFRAME = 2  # frame with every cell known
    BEACON = 3
    FULL_MAP = 4
    READINGS = 5
    TRUTH = 6


DELTA, KEYFRAME = Kind.DELTA, Kind.KEYFRAME


@dataclass(frozen=True, slots=True)
class Frame:
    """What an agent sends once a tick: beacon, planner payload and map cells.

    Attributes:
        kind: DELTA or KEYFRAME.
        sender: agent id.
        tick: decisions of the sender since the search began.
        t_us: sending time.
        position: ENU m, as the sender knows it; float32 on the wire.
        velocity: m/s; float32 on the wire.
        payload: the planner's, up to 65,535 bytes.
        rule: code of the merge rule that reads the cells.
        cells: packed records of that rule.
    """

    kind: Kind
    sender: int
    tick: int
    t_us: int
    position: Vector
    velocity: Vector
    payload: bytes = b""
    rule: int = 0
    cells: bytes = b""


@dataclass(frozen=True, slots=True)
class Beacon:
    """A position for separation: sender id, time, ENU m, m/s (float32 on the wire)."""

    sender: int
    t_us: int
    position: Vector
    velocity: Vector


def encode(frame: Frame) -> bytes:
    """The bytes of a frame.

    Raises:
        ValueError: a number does not fit its field, or payload or cells are too long.
    """
    payload, cells = frame.payload, frame.cells
    if len(cells) > CELLS_LIMIT:
        raise ValueError(f"{len(cells)} bytes of cells do not fit a frame")
    try:
        head = _FRAME.pack(
            MAGIC,
            VERSION,
            frame.kind,
            frame.sender,
            frame.tick,
            frame.rule,
            len(payload),
            frame.t_us,
            *frame.position,
            *frame.velocity,
            len(cells),
        )
    except (error, OverflowError) as fault:
        raise ValueError(f"frame of agent {frame.sender}: {fault}") from None
    return head + payload + cells


def decode(data: bytes, rejects: Counter[str] | None = None) -> Frame | None:
    """The frame in ``data``; None, and its reason counted, when malformed."""
    if fault := fault_in_head(data, _FRAME.size, (Kind.DELTA, Kind.KEYFRAME)):
        return refused(fault, rejects)
    _, _, kind, sender, tick, rule, payload_size, t_us, *vectors, cells_size = _FRAME.unpack_from(
        data
    )
    x, y, z, vx, vy, vz = vectors
    start = _FRAME.size + payload_size
    if cells_size > CELLS_LIMIT:
        return refused("size", rejects)
    if len(data) != start + cells_size:
        return refused("length", rejects)
    if fault := fault_in_state(t_us, (x, y, z), (vx, vy, vz)):
        return refused(fault, rejects)
    return Frame(
        Kind(kind),
        sender,
        tick,
        t_us,
        (x, y, z),
        (vx, vy, vz),
        data[_FRAME.size : start],
        rule,
        data[start:],
    )


def encode_beacon(beacon: Beacon) -> bytes:
    """The bytes of a position beacon. Raises ValueError as ``encode`` does."""
    try:
        return _BEACON.pack(
            MAGIC,
            VERSION,
            Kind.BEACON,
            beacon.sender,
            beacon.t_us,
            *beacon.position,
            *beacon.velocity,
        )
    except (error, OverflowError) as fault:
        raise ValueError(f"beacon of agent {beacon.sender}: {fault}") from None


def decode_beacon(data: bytes, rejects: Counter[str] | None = None) -> Beacon | None:
    """The beacon in ``data``; None, and its reason counted, when malformed."""
    if fault := fault_in_head(data, _BEACON.size, (Kind.BEACON,)):
        return refused(fault, rejects)
    if len(data) != _BEACON.size:
        return refused("length", rejects)
    _, _, _, sender, t_us, x, y, z, vx, vy, vz = _BEACON.unpack(data)
    if fault := fault_in_state(t_us, (x, y, z), (vx, vy, vz)):
        return refused(fault, rejects)
    return Beacon(sender, t_us, (x, y, z), (vx, vy, vz))


def fault_in_head(data: bytes, size: int, kinds: tuple[Kind, ...]) -> str:
    """What is wrong with the first bytes of a message at least ``size`` long, or nothing."""
    if len(data) < size:
        return "length"
    magic, version, kind = _HEAD.unpack_from(data)
    if magic != MAGIC:
        return "magic"
    if version != VERSION:
        return "version"
    return "" if kind in kinds else "kind"


def fault_in_state(t_us: int, position: Vector, velocity: Vector) -> str:
    """What is impossible in a time, position and velocity, or nothing."""
    if not 0 <= t_us <= TIME_LIMIT_US:
        return "time"
    # a comparison with NaN is false
    if not all(-POSITION_LIMIT_M <= p <= POSITION_LIMIT_M for p in position):
        return "position"
    if not all(-SPEED_LIMIT_M_S <= v <= SPEED_LIMIT_M_S for v in velocity):
        return "velocity"
    return ""


def refused(reason: str, rejects: Counter[str] | None) -> None:
    """Count and log one malformed message."""
    if rejects is not None:
        rejects[reason] += 1
    _log.debug("malformed message dropped: %s", reason)
