"""What older versions recorded, as this one reads it.

Wire formats 1 and 2 had other heads of frames (1 had no mission mark and no probes), and their
other messages differ from today's in the version byte alone.
"""

from __future__ import annotations

from struct import Struct

from uavbridge.bus.wire import (
    MAGIC,
    VERSION,
    Frame,
    Kind,
    MalformedError,
    encode,
    probes_in,
)

_WIRED = frozenset({"air", "truth", "fullmap", "layer"})  # topics that hold messages of the bus
_FRAME_1 = Struct("<2sBBIIHHq3f3fI")
_FRAME_2 = Struct("<2sBBIIHBBHHq3f3fII")


def upgraded(space: str, data: bytes) -> bytes:
    """A message of a topic's space as today's; as it is where it is today's, or no such message."""
    if space not in _WIRED or data[:2] != MAGIC or len(data) < 4 or data[2] not in (1, 2):
        return data
    if data[3] not in (Kind.DELTA, Kind.KEYFRAME):
        return data[:2] + bytes([VERSION]) + data[3:]
    parse, head = (_frame_1, _FRAME_1) if data[2] == 1 else (_frame_2, _FRAME_2)
    if len(data) < head.size:
        return data
    try:
        return encode(parse(data))
    except (ValueError, MalformedError):  # a number that fits no more, or broken probes
        return data


def _frame_1(data: bytes) -> Frame:
    _, _, kind, sender, tick, rule, payload, t_us, x, y, z, u, v, w, _ = _FRAME_1.unpack_from(data)
    cells = _FRAME_1.size + payload
    return Frame(
        kind=Kind(kind),
        sender=sender,
        tick=tick,
        t_us=t_us,
        position=(x, y, z),
        velocity=(u, v, w),
        payload=data[_FRAME_1.size : cells],
        rule=rule,
        cells=data[cells:],
    )


def _frame_2(data: bytes) -> Frame:
    # fmt: off
    (_, _, kind, mission, tick, sender, rule, count, payload, waited_ms, t_us, x, y, z, u, v, w,
     root, _) = _FRAME_2.unpack_from(data)
    # fmt: on
    start = _FRAME_2.size + payload
    probes, cells = probes_in(data, start, count)
    return Frame(
        kind=Kind(kind),
        sender=sender,
        tick=tick,
        t_us=t_us,
        position=(x, y, z),
        velocity=(u, v, w),
        payload=data[_FRAME_2.size : start],
        rule=rule,
        cells=data[cells:],
        mission=mission & 0xFFFF,
        root=root,
        probes=probes,
        waited_s=waited_ms / 1000.0,
    )
