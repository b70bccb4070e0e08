"""MAVLink frames from and to values: the only package that knows the wire.

The message tables (field order, extra CRC bytes, enums) are pymavlink's; packing
and decoding are done here with struct and fastcrc, byte for byte as pymavlink does,
several times faster.
"""

from __future__ import annotations

from sim_vehicles.codec.batch import BatchPacker
from sim_vehicles.codec.decode import Counts, Packet, StreamDecoder, decode
from sim_vehicles.codec.encode import Encoder
from sim_vehicles.codec.tables import mav

__all__ = [
    "BatchPacker",
    "Counts",
    "Encoder",
    "Packet",
    "StreamDecoder",
    "decode",
    "mav",
]
