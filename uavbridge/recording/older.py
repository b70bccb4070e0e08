"""What older versions recorded, as this one reads it.

Wire format 1 had another head of frames (no mission mark, no probes), and its other messages
differ from today's in the version byte alone.
"""

from __future__ import annotations

from struct import Struct

from uavbridge.bus.wire import MAGIC, VERSION, Frame, Kind, encode

OLDEST = 1
_WIRED = frozenset({"air", "truth", "fullmap", "layer"})  # topics that hold messages of the bus
_FRAME_1 = Struct("<2sBBIIHHq3f3fI")


def upgraded(space: str, data: bytes) -> bytes:
    """A message of a topic's space as today's; as it is where it is today's, or no such message."""
    if space not in _WIRED or data[:2] != MAGIC or len(data) < 4 or data[2] != OLDEST:
        return data
    if data[3] not in (Kind.DELTA, Kind.KEYFRAME):
        return data[:2] + bytes([VERSION]) + data[3:]
    if len(data) < _FRAME_1.size:
        return data
    _, _, kind, sender, tick, rule, payload, t_us, x, y, z, u, v, w, _ = _FRAME_1.unpack_from(data)
    cells = _FRAME_1.size + payload
    try:
        return encode(
            Frame(
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
        )
    except ValueError:  # a number that fits no more
        return data
