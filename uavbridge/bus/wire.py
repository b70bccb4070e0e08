"""Wire format v1 of what agents send each other: frames and position beacons.

Little-endian, described byte by byte in docs/reference/wire_format.md. Whatever
is malformed decodes to None and its reason is counted; decoding never raises.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass
from enum import IntEnum
from struct import Struct, error
from typing import TypeAlias, TypeVar

Vector: TypeAlias = tuple[float, float, float]
M = TypeVar("M")

MAGIC = b"UB"
VERSION = 1
POSITION_LIMIT_M = 1e6
SPEED_LIMIT_M_S = 1e4
TIME_LIMIT_US = 1 << 53  # also exact in a JSON number
CELLS_LIMIT = 1 << 24  # bytes

_HEAD = Struct("<2sBB")
_FRAME = Struct("<2sBBIIHHq3f3fI")
_SENDER_AND_TICK = Struct("<II")
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
    SIGNALS = 7


DELTA, KEYFRAME = Kind.DELTA, Kind.KEYFRAME
_FRAME_KINDS = {int(kind): kind for kind in (DELTA, KEYFRAME)}


class MalformedError(Exception):
    """A message cannot be read; the text is the reason that is counted. Never leaves the codec."""


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
    return accepted(_frame, data, rejects)


def sender_and_tick(data: bytes) -> tuple[int, int]:
    """Sender and tick of a frame that is known to be sound."""
    sender, tick = _SENDER_AND_TICK.unpack_from(data, 4)
    return sender, tick


def kind_of(data: bytes) -> int:
    """Fourth byte of a message, sound or not; 0 of one too short."""
    return data[3] if len(data) > 3 else 0


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
    return accepted(_beacon, data, rejects)


def accepted(
    parse: Callable[[bytes], M], data: bytes, rejects: Counter[str] | None = None
) -> M | None:
    """What ``parse`` reads in ``data``; None, the reason counted and logged, when malformed."""
    try:
        return parse(data)
    except MalformedError as fault:
        reason = str(fault)
        if rejects is not None:
            rejects[reason] += 1
        _log.debug("malformed message dropped: %s", reason)
        return None


def check_head(data: bytes, size: int, kinds: Collection[int]) -> None:
    """Raise MalformedError unless ``data`` is one of the kinds, ``size`` bytes or longer."""
    if len(data) < size:
        raise MalformedError("length")
    magic, version, kind = _HEAD.unpack_from(data)
    if magic != MAGIC:
        raise MalformedError("magic")
    if version != VERSION:
        raise MalformedError("version")
    if kind not in kinds:
        raise MalformedError("kind")


def check_length(data: bytes, size: int) -> None:
    """Raise MalformedError unless ``data`` is ``size`` long."""
    if len(data) != size:
        raise MalformedError("length")


def check_time(t_us: int) -> None:
    """Raise MalformedError for a time that no mission has."""
    if not 0 <= t_us <= TIME_LIMIT_US:
        raise MalformedError("time")


def _check_state(x: float, y: float, z: float, vx: float, vy: float, vz: float) -> None:
    far, fast = POSITION_LIMIT_M, SPEED_LIMIT_M_S
    # written out, as this runs for every frame; a comparison with NaN is false
    if not (-far <= x <= far and -far <= y <= far and -far <= z <= far):
        raise MalformedError("position")
    if not (-fast <= vx <= fast and -fast <= vy <= fast and -fast <= vz <= fast):
        raise MalformedError("velocity")


def _frame(data: bytes) -> Frame:
    check_head(data, _FRAME.size, _FRAME_KINDS)
    _, _, kind, sender, tick, rule, payload_size, t_us, x, y, z, vx, vy, vz, cells_size = (
        _FRAME.unpack_from(data)
    )
    if cells_size > CELLS_LIMIT:
        raise MalformedError("size")
    start = _FRAME.size + payload_size
    check_length(data, start + cells_size)
    check_time(t_us)
    _check_state(x, y, z, vx, vy, vz)
    payload, cells = data[_FRAME.size : start], data[start:]
    return Frame(
        _FRAME_KINDS[kind], sender, tick, t_us, (x, y, z), (vx, vy, vz), payload, rule, cells
    )


def _beacon(data: bytes) -> Beacon:
    check_head(data, _BEACON.size, (Kind.BEACON,))
    check_length(data, _BEACON.size)
    _, _, _, sender, t_us, x, y, z, vx, vy, vz = _BEACON.unpack(data)
    check_time(t_us)
    _check_state(x, y, z, vx, vy, vz)
    return Beacon(sender, t_us, (x, y, z), (vx, vy, vz))
