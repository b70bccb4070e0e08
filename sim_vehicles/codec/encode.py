"""Values to frames, one at a time."""

from __future__ import annotations

import struct
from typing import Any, Final

from fastcrc import crc16

from sim_vehicles.codec.tables import BY_NAME

_crc = crc16.mcrf4xx
_header = struct.Struct("<BBBBBBHB").pack
_crc_bytes = struct.Struct("<H").pack
STX: Final = b"\xfd"


class Encoder:
    """Packs the MAVLink 2 frames of one sender and numbers them.

    Args:
        system: sender's system id, 1..255.
        component: sender's component id, 0..255.
        sequences: a byte array shared with other senders of numbers (``BatchPacker``);
            the next number is ``sequences[index]``. None: an own one.
        index: this sender's place in ``sequences``.
    """

    __slots__ = ("_index", "_sequences", "component", "system")

    def __init__(
        self,
        system: int,
        component: int = 1,
        *,
        sequences: bytearray | None = None,
        index: int = 0,
    ) -> None:
        if not 1 <= system <= 255:
            raise ValueError(f"a system id is 1..255, not {system}")
        if not 0 <= component <= 255:
            raise ValueError(f"a component id is 0..255, not {component}")
        self.system = system
        self.component = component
        self._sequences = bytearray(1) if sequences is None else sequences
        self._index = index

    @property
    def sequence(self) -> int:
        """The number of the next frame, 0..255."""
        return self._sequences[self._index]

    @sequence.setter
    def sequence(self, value: int) -> None:
        self._sequences[self._index] = value & 255

    def pack(self, name: str, /, **fields: Any) -> bytes:
        """One frame of message ``name``, e.g. "HEARTBEAT"; fields not given are zero.

        Raises:
            ValueError: no such message or field, or a value out of the field's range; the
                message names both.
        """
        layout = BY_NAME[name]
        payload = layout.pack(fields)
        sequence = self._sequences[self._index]
        self._sequences[self._index] = (sequence + 1) & 255
        msgid = layout.msgid
        body = (
            _header(
                len(payload),
                0,
                0,
                sequence,
                self.system,
                self.component,
                msgid & 0xFFFF,
                msgid >> 16,
            )
            + payload
        )
        return STX + body + _crc_bytes(_crc(body + layout.crc_extra))
