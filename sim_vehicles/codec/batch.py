"""One message type for many senders in a few numpy operations.

Worth it from about ten senders on; for one, ``Encoder`` is quicker.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt
from fastcrc import crc16

from sim_vehicles.codec.tables import BY_NAME, Field

U8: TypeAlias = npt.NDArray[np.uint8]
I64: TypeAlias = npt.NDArray[np.int64]

_crc = crc16.mcrf4xx
_HEAD: Final = 10  # bytes before the payload
_TAIL: Final = 2  # checksum
_NUMPY: Final = {
    "b": "i1",
    "B": "u1",
    "h": "<i2",
    "H": "<u2",
    "i": "<i4",
    "I": "<u4",
    "q": "<i8",
    "Q": "<u8",
    "f": "<f4",
    "d": "<f8",
    "c": "S1",
}


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """Frames of one message, one a row; a row's bytes after its length mean nothing."""

    data: U8  # (n, longest)
    lengths: I64  # (n,) bytes of each frame

    def split(self) -> list[bytes]:
        """Each row as bytes."""
        return join((self,))


class BatchPacker:
    """Packs message ``name`` for n senders, byte for byte as ``Encoder`` does.

    Attributes:
        dtype: numpy record of the payload, fields under pymavlink's names.
    """

    def __init__(self, name: str, component: int = 1) -> None:
        layout = BY_NAME[name]
        self.name = name
        self.msgid = layout.msgid
        self.dtype = np.dtype([_numpy_field(field) for field in layout.fields])
        self._payload = self.dtype.itemsize
        self._header = np.zeros(_HEAD, dtype=np.uint8)
        self._header[0] = 0xFD
        self._header[6] = component
        self._header[7:10] = np.frombuffer(layout.msgid.to_bytes(3, "little"), dtype=np.uint8)
        self._extra = layout.crc_extra[0]
        self._columns = np.arange(1, self._payload + 1, dtype=np.uint8)

    def records(self, n: int) -> npt.NDArray[Any]:
        """Payloads of zeros, (n,) of ``dtype``, to be filled by field name."""
        return np.zeros(n, dtype=self.dtype)

    def frames(self, records: npt.NDArray[Any], systems: U8, sequences: U8) -> Frames:
        """Frames of ``records`` (n,) from ``systems`` (n,), numbered ``sequences`` (n,)."""
        n = len(records)
        size = self._payload
        data = np.empty((n, _HEAD + size + _TAIL), dtype=np.uint8)
        data[:, :_HEAD] = self._header
        payload = records.view(np.uint8).reshape(n, size)
        data[:, _HEAD : _HEAD + size] = payload
        data[:, 4] = sequences
        data[:, 5] = systems
        lengths = np.maximum((self._columns * (payload != 0)).max(axis=1), 1)
        data[:, 1] = lengths
        ends = lengths.astype(np.int64) + _HEAD
        rows = np.arange(n)
        data[rows, ends] = self._extra  # the checksum covers it, then takes its place
        wide = data.tobytes()
        starts = rows * data.shape[1]
        checks = np.array(
            [
                _crc(wide[start:end])
                for start, end in zip(
                    (starts + 1).tolist(), (starts + ends + 1).tolist(), strict=True
                )
            ],
            dtype=np.uint16,
        )
        data[rows, ends] = checks & 0xFF
        data[rows, ends + 1] = checks >> 8
        return Frames(data, ends + _TAIL)

    def pack(self, records: npt.NDArray[Any], systems: U8, sequences: U8) -> list[bytes]:
        """As ``frames``, each frame as bytes."""
        return self.frames(records, systems, sequences).split()


def join(batches: Sequence[Frames]) -> list[bytes]:
    """Each sender's frames one after the other: row i of all batches, for every i."""
    if not batches:
        return []
    data = np.hstack([batch.data for batch in batches])
    inside = np.hstack(
        [np.arange(batch.data.shape[1]) < batch.lengths[:, np.newaxis] for batch in batches]
    )
    packed = data[inside].tobytes()
    ends = np.cumsum(sum(batch.lengths for batch in batches)).tolist()
    return [packed[start:end] for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def _numpy_field(field: Field) -> tuple[str, str] | tuple[str, str, tuple[int]]:
    if field.code == "s":
        return field.name, f"S{field.count}"
    kind = _NUMPY[field.code]
    return (field.name, kind, (field.count,)) if field.count else (field.name, kind)
