"""Wire format v2 of what agents send each other: frames and position beacons.

Little-endian, described byte by byte in docs/reference/wire_format.md. Whatever
is malformed decodes to None and its reason is counted; decoding never raises.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Collection
from enum import IntEnum
from struct import Struct, error, pack, unpack_from
from typing import NamedTuple, TypeAlias, TypeVar

import msgspec

Vector: TypeAlias = tuple[float, float, float]
M = TypeVar("M")

MAGIC = b"UB"
VERSION = 2
POSITION_LIMIT_M = 1e6
SPEED_LIMIT_M_S = 1e4
TIME_LIMIT_US = 1 << 53  # also exact in a JSON number
CELLS_LIMIT = 1 << 24  # bytes
DIGESTS_LIMIT = 16  # of one probe
WAITED_LIMIT_S = 65.0

_HEAD = Struct("<2sBB")
_HEAD_OF_ALL = MAGIC + bytes((VERSION,))
_FRAME = Struct("<2sBBIIHBBHHq3f3fII")
HEAD_BYTES = _FRAME.size  # of a frame without payload, probes and cells
_TICK_AND_SENDER = Struct("<IH")
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
        tick: decisions of the sender since the search began.
        t_us: sending time.
        position: ENU m, as the sender knows it; float32 on the wire.
        velocity: m/s; float32 on the wire.
        payload: the planner's, up to 65,535 bytes.
        rule: code of the merge rule that reads the cells.
        cells: packed records of that rule.
        mission: mark of the mission; frames of another one are dropped.
        root: mark of all that the sender knows of the map; 0: nothing.
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
    probes: tuple[Probe, ...] = ()
    waited_s: float = 0.0

    @property
    def map_bytes(self) -> int:
        """Of its bytes, those for the map: cells and probes."""
        return len(self.cells) + sum([probe.size for probe in self.probes])


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
    try:
        head = _FRAME.pack(
            MAGIC,
            VERSION,
            frame.kind,
            frame.mission,
            frame.tick,
            frame.sender,
            frame.rule,
            len(frame.probes),
            len(payload),
            round(frame.waited_s * 1000.0) if frame.waited_s else 0,
            frame.t_us,
            *frame.position,
            *frame.velocity,
            frame.root,
            len(cells),
        )
        if frame.probes:
            payload += b"".join([_probe_bytes(probe) for probe in frame.probes])
    except (error, OverflowError) as fault:
        raise ValueError(f"frame of agent {frame.sender}: {fault}") from None
    return head + payload + cells


def decode(data: bytes, rejects: Counter[str] | None = None) -> Frame | None:
    """The frame in ``data``; None, and its reason counted, when malformed."""
    return accepted(_frame, data, rejects)


def sender_and_tick(data: bytes) -> tuple[int, int]:
    """Sender and tick of a frame that is known to be sound."""
    tick, sender = _TICK_AND_SENDER.unpack_from(data, 8)
    return sender, tick


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
    # ``check_head`` and the like are written out: this runs for every frame that arrives
    if len(data) < _FRAME.size or data[:3] != _HEAD_OF_ALL or data[3] not in _FRAME_KINDS:
        check_head(data, _FRAME.size, _FRAME_KINDS)
    # fmt: off
    (_, _, kind, mission, tick, sender, rule, count, payload_size, waited_ms,
     t_us, x, y, z, vx, vy, vz, root, cells_size) = _FRAME.unpack_from(data)
    # fmt: on
    if cells_size > CELLS_LIMIT:
        raise MalformedError("size")
    start = _FRAME.size + payload_size
    payload = data[_FRAME.size : start]
    probes: tuple[Probe, ...] = ()
    if count:
        probes, start = _probes(data, start, count)
    if len(data) != start + cells_size:
        raise MalformedError("length")
    if not 0 <= t_us <= TIME_LIMIT_US:
        raise MalformedError("time")
    _check_state(x, y, z, vx, vy, vz)
    return Frame(
        _FRAME_KINDS[kind],
        sender,
        tick,
        t_us,
        (x, y, z),
        (vx, vy, vz),
        payload,
        rule,
        data[start:],
        mission,
        root,
        probes,
        waited_ms / 1000.0 if waited_ms else 0.0,
    )


def _probes(data: bytes, start: int, count: int) -> tuple[tuple[Probe, ...], int]:
    """So many probes that begin at a place, and where they end."""
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
