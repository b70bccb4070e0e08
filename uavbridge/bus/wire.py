"""Wire format v3 of what agents send each other: frames and position beacons.

Little-endian, described byte by byte in docs/reference/wire_format.md. Whatever
is malformed decodes to None and its reason is counted; decoding never raises.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Collection
from enum import IntEnum
from functools import lru_cache
from struct import Struct, error, pack, unpack_from
from typing import NamedTuple, TypeAlias, TypeVar

import msgspec

Vector: TypeAlias = tuple[float, float, float]
M = TypeVar("M")

MAGIC = b"UB"
VERSION = 3
POSITION_LIMIT_M = 1e6
SPEED_LIMIT_M_S = 1e4
TIME_LIMIT_US = 1 << 53  # also exact in a JSON number
CELLS_LIMIT = 1 << 24  # bytes
DIGESTS_LIMIT = 16  # of one probe
WAITED_LIMIT_S = 65.0
WAITED_BYTES = 2  # of a frame that waited

_HEAD = Struct("<2sBB")
_HEAD_OF_ALL = MAGIC + bytes((VERSION,))
_FRAME = Struct("<3sBHHIBBffffffI")
_TIME = Struct("<q")
_WAITED, _PAYLOAD, _PROBES, _CELLS = 0x80, 0x40, 0x20, 0x10  # what a frame says the length of
_LENGTHS = {
    parts: Struct("<" + "".join([field for i, field in enumerate("HHBI") if parts & 0x80 >> i]))
    for parts in range(0, 0x100, 0x10)
}
_CELLS_LENGTH, _cells_length = _LENGTHS[_CELLS].pack, _LENGTHS[_CELLS].unpack_from
_RULES_MASK = 0x0F
_TICKS = 1 << 24
_PERIOD_US = 100_000
_OTHER_TIME = 255  # in place of a tick's length
_TICK_OF_WORD = _TICKS - 1
_SENDER_AND_TICK = Struct("<HI")
_PROBE = Struct("<HIB")
_ECHO = 0x80  # in the count of a probe's digests
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
    LAYER = 8
    PLACE = 9
    OBSTACLES = 10


DELTA, KEYFRAME = Kind.DELTA, Kind.KEYFRAME
_FRAME_KINDS = {int(kind): kind for kind in (DELTA, KEYFRAME)}


class MalformedError(Exception):
    """A message cannot be read; the text is the reason that is counted. Never leaves the codec."""


class Probe(NamedTuple):
    """What the sender knows of a part of the map, for one agent to find out where theirs differ.

    The parts are the nodes of a tree, see ``uavbridge.agent.differences``.
    """

    to: int  # agent id
    node: int
    digests: tuple[int, ...]  # 16 bits of each child
    echo: bool = False  # the answer to a probe of single cells; not answered by another

    @property
    def size(self) -> int:
        """Bytes on the wire."""
        return _PROBE.size + 2 * len(self.digests)


class Frame(msgspec.Struct, frozen=True, gc=False):
    """What an agent sends once a tick: beacon, planner payload, map cells, and what it lacks.

    Attributes:
        kind: DELTA or KEYFRAME.
        sender: agent id.
        tick: number of the sender's tick, below 2^24.
        t_us: sending time.
        position: ENU m, as the sender knows it; float32 on the wire.
        velocity: m/s; float32 on the wire.
        payload: the planner's, up to 65,535 bytes.
        rule: code of the merge rule that reads the cells, below 16.
        cells: packed records of that rule.
        mission: mark of the mission, 16 bits; frames of another one are dropped.
        root: mark of all that the sender knows of the map; 0: nothing.
        heard: whose frames of one tick before the sender heard: bit i for the i-th of the team.
        probes: at most 255.
        waited_s: in the queue of the sender's radio, in whole ms.
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
    mission: int = 0
    root: int = 0
    heard: int = 0
    probes: tuple[Probe, ...] = ()
    waited_s: float = 0.0

    @property
    def map_bytes(self) -> int:
        """Of its bytes, those for the map: cells and probes."""
        size = len(self.cells)
        return size + sum([probe.size for probe in self.probes]) if self.probes else size


class Beacon(msgspec.Struct, frozen=True, gc=False):
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
    tick, rule = frame.tick, frame.rule
    try:
        if not 0 <= tick < _TICKS or not 0 <= rule <= _RULES_MASK:
            raise error(f"tick {tick} or rule {rule}")
        if payload or frame.probes or frame.waited_s:
            parts, lengths = _parts(frame)
        else:  # mostly
            parts, lengths = (_CELLS, _CELLS_LENGTH(len(cells))) if cells else (0, b"")
        heard = _heard_bytes(frame.heard)
        period, rest = divmod(frame.t_us, _PERIOD_US * tick) if tick else (0, frame.t_us)
        odd = rest or not 0 <= period < _OTHER_TIME
        head = _FRAME.pack(
            _HEAD_OF_ALL,
            frame.kind,
            frame.mission,
            frame.sender,
            len(heard) << 24 | tick,
            _OTHER_TIME if odd else period,
            parts | rule,
            *frame.position,
            *frame.velocity,
            frame.root,
        )
        if odd:
            head += _TIME.pack(frame.t_us)
        if frame.probes:
            payload += b"".join([_probe_bytes(probe) for probe in frame.probes])
    except (error, OverflowError) as fault:
        raise ValueError(f"frame of agent {frame.sender}: {fault}") from None
    return head + heard + lengths + payload + cells


def _parts(frame: Frame) -> tuple[int, bytes]:
    """What a frame has, and the lengths of it."""
    parts, said = 0, []
    if frame.waited_s:  # which may be less than half a millisecond
        parts |= _WAITED
        said.append(round(frame.waited_s * 1000.0))
    if frame.payload:
        parts |= _PAYLOAD
        said.append(len(frame.payload))
    if frame.probes:
        parts |= _PROBES
        said.append(len(frame.probes))
    if frame.cells:
        parts |= _CELLS
        said.append(len(frame.cells))
    return parts, _LENGTHS[parts].pack(*said)


def head_bytes(tick_us: int) -> int:
    """The most bytes of a frame beside ``heard``, payload, probes and cells.

    Args:
        tick_us: from one frame to the next.
    """
    ticks, rest = divmod(tick_us, _PERIOD_US)
    timed = bool(rest) or not 0 < ticks < _OTHER_TIME
    return _FRAME.size + _LENGTHS[0xF0].size + (_TIME.size if timed else 0)


def heard_size(heard: int) -> int:
    """Bytes of a frame for whom its sender heard."""
    return (heard.bit_length() + 7) // 8


@lru_cache(1024)
def _heard_bytes(heard: int) -> bytes:
    return heard.to_bytes(heard_size(heard), "little")


def decode(data: bytes, rejects: Counter[str] | None = None) -> Frame | None:
    """The frame in ``data``; None, and its reason counted, when malformed."""
    try:  # as ``accepted`` does: this runs for every frame that arrives
        return _frame(data)
    except MalformedError as fault:
        _refuse(fault, rejects)
        return None


def sender_and_tick(data: bytes) -> tuple[int, int]:
    """Sender and tick of a frame that is known to be sound."""
    sender, word = _SENDER_AND_TICK.unpack_from(data, 6)
    return sender, word & _TICK_OF_WORD


def _probe_bytes(probe: Probe) -> bytes:
    count = len(probe.digests)
    if not 0 < count <= DIGESTS_LIMIT:
        raise error(f"a probe with {count} digests")
    head = _PROBE.pack(probe.to, probe.node, count | (_ECHO if probe.echo else 0))
    return head + pack(f"<{count}H", *probe.digests)


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
        _refuse(fault, rejects)
        return None


def _refuse(fault: MalformedError, rejects: Counter[str] | None) -> None:
    reason = str(fault)
    if rejects is not None:
        rejects[reason] += 1
    _log.debug("malformed message dropped: %s", reason)


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
    # ``check_head`` and the like are written out: this runs for every frame that arrives
    start = _FRAME.size
    if len(data) < start or data[:3] != _HEAD_OF_ALL or data[3] not in _FRAME_KINDS:
        check_head(data, start, _FRAME_KINDS)
    # fmt: off
    (_, kind, mission, sender, word, period, rule, x, y, z, vx, vy, vz,
     root) = _FRAME.unpack_from(data)
    # fmt: on
    tick = word & _TICK_OF_WORD
    if period == _OTHER_TIME:
        if len(data) < start + _TIME.size:
            raise MalformedError("length")
        (t_us,) = _TIME.unpack_from(data, start)
        start += _TIME.size
        if not 0 <= t_us <= TIME_LIMIT_US:
            raise MalformedError("time")
    else:
        t_us = tick * period * _PERIOD_US
    _check_state(x, y, z, vx, vy, vz)
    heard = waited_ms = payload_size = count = cells_size = 0
    if word > _TICK_OF_WORD:
        begin, start = start, start + (word >> 24)
        heard = int.from_bytes(data[begin:start], "little")
    parts = rule & 0xF0
    if parts == _CELLS and len(data) >= start + 4:  # mostly
        (cells_size,) = _cells_length(data, start)
        start += 4
    elif parts:
        waited_ms, payload_size, count, cells_size, start = _lengths(data, start, parts)
    if cells_size > CELLS_LIMIT:
        raise MalformedError("size")
    payload = data[start : start + payload_size]
    start += payload_size
    probes: tuple[Probe, ...] = ()
    if count:
        probes, start = probes_in(data, start, count)
    if len(data) != start + cells_size:
        raise MalformedError("length")
    return Frame(
        _FRAME_KINDS[kind],
        sender,
        tick,
        t_us,
        (x, y, z),
        (vx, vy, vz),
        payload,
        rule & _RULES_MASK,
        data[start:],
        mission,
        root,
        heard,
        probes,
        waited_ms / 1000.0 if waited_ms else 0.0,
    )


def _lengths(data: bytes, start: int, parts: int) -> tuple[int, int, int, int, int]:
    """Time waited, lengths of payload, probes and cells, and where the payload begins."""
    lengths = _LENGTHS[parts]
    end = start + lengths.size
    if len(data) < end:
        raise MalformedError("length")
    said = iter(lengths.unpack_from(data, start))
    waited_ms, payload_size, count, cells_size = [
        next(said) if parts & 0x80 >> i else 0 for i in range(4)
    ]
    return waited_ms, payload_size, count, cells_size, end


def probes_in(data: bytes, start: int, count: int) -> tuple[tuple[Probe, ...], int]:
    """So many probes that begin at a place, and where they end. Raises MalformedError."""
    probes = []
    for _ in range(count):
        if len(data) < start + _PROBE.size:
            raise MalformedError("length")
        to, node, digests = _PROBE.unpack_from(data, start)
        echo, digests = bool(digests & _ECHO), digests & ~_ECHO
        start += _PROBE.size
        if not 0 < digests <= DIGESTS_LIMIT:
            raise MalformedError("probe")
        if len(data) < start + 2 * digests:
            raise MalformedError("length")
        probes.append(Probe(to, node, unpack_from(f"<{digests}H", data, start), echo))
        start += 2 * digests
    return tuple(probes), start


def _beacon(data: bytes) -> Beacon:
    check_head(data, _BEACON.size, (Kind.BEACON,))
    check_length(data, _BEACON.size)
    _, _, _, sender, t_us, x, y, z, vx, vy, vz = _BEACON.unpack(data)
    check_time(t_us)
    _check_state(x, y, z, vx, vy, vz)
    return Beacon(sender, t_us, (x, y, z), (vx, vy, vz))
