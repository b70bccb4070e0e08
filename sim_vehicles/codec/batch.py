"""The same messages from many senders, packed in a few numpy operations.

Worth it from a handful of senders on; for one frame, ``Encoder`` is quicker.
"""

from __future__ import annotations

from itertools import groupby
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt
from fastcrc import crc16

from sim_vehicles.codec.tables import BY_NAME, Field, Layout

U8: TypeAlias = npt.NDArray[np.uint8]
Records: TypeAlias = npt.NDArray[Any]

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


class BatchPacker:
    """Packs one or more messages for n senders, byte for byte as ``Encoder`` does.

    Args:
        names: messages, in the order in which each sender sends them.
        component: component id of all senders.
    """

    def __init__(self, *names: str, component: int = 1) -> None:
        layouts = [BY_NAME[name] for name in names]
        widths = [_HEAD + layout.struct.size + _TAIL for layout in layouts]
        self._starts = np.cumsum([0, *widths[:-1]])
        self._width = sum(widths)
        self._extras = np.array([layout.crc_extra[0] for layout in layouts], dtype=np.uint8)
        self._template = np.zeros(self._width, dtype=np.uint8)
        self._places = np.zeros(self._width, dtype=np.uint8)  # 1, 2, 3.. along each payload
        for start, layout in zip(self._starts.tolist(), layouts, strict=True):
            head = [0xFD, 0, 0, 0, 0, 0, component, *layout.msgid.to_bytes(3, "little")]
            body = start + _HEAD
            self._template[start:body] = head
            self._places[body : body + layout.struct.size] = range(1, layout.struct.size + 1)
        self._dtype = np.dtype(
            {
                "names": names,
                "formats": [_payload(layout) for layout in layouts],
                "offsets": (self._starts + _HEAD).tolist(),
                "itemsize": self._width,
            }
        )

    def records(self, n: int) -> Records:
        """Payloads of zeros (n,), to be filled: ``records["ATTITUDE"]["roll"] = ...``.

        Neighbouring fields of one kind can be filled together, as columns:
        ``records["ATTITUDE"]["roll:yawspeed"]`` is (n, 6). The array must be handed to
        ``pack`` itself, not a copy: it holds more than its fields.
        """
        data = np.empty((n, self._width), dtype=np.uint8)
        data[:] = self._template
        records: Records = data.view(self._dtype).reshape(n)
        return records

    def pack(self, records: Records, systems: U8, sequences: U8) -> list[bytes]:
        """Each sender's frames one after the other.

        Args:
            records: from ``records``, filled.
            systems: (n,) system ids.
            sequences: (n,) number of each sender's first frame; the next frames count on.
        """
        n, k = len(records), len(self._starts)
        data = records.view(np.uint8).reshape(n, self._width).copy()
        used = (data != 0) * self._places
        lengths = np.maximum(np.maximum.reduceat(used, self._starts, axis=1), 1)  # (n, k)
        data[:, self._starts + 1] = lengths
        data[:, self._starts + 4] = sequences[:, np.newaxis] + np.arange(k, dtype=np.uint8)
        data[:, self._starts + 5] = systems[:, np.newaxis]
        begins = np.arange(0, n * self._width, self._width)[:, np.newaxis] + self._starts
        ends = begins + lengths + _HEAD
        flat = data.reshape(-1)
        flat[ends] = self._extras  # the checksum covers it, then takes its place
        wide = flat.tobytes()
        frames = [
            wide[begin:end] + _crc(wide[begin + 1 : end + 1]).to_bytes(2, "little")
            for begin, end in zip(begins.ravel().tolist(), ends.ravel().tolist(), strict=True)
        ]
        if k == 1:
            return frames
        return [b"".join(frames[i : i + k]) for i in range(0, n * k, k)]


def _payload(layout: Layout) -> np.dtype[Any]:
    """The payload as a numpy record: its fields, and runs of fields of one kind."""
    names: list[str] = []
    formats: list[Any] = []
    offsets: list[int] = []

    def add(name: str, kind: Any, offset: int) -> None:
        names.append(name)
        formats.append(kind)
        offsets.append(offset)

    offset = 0
    for (code, single), group in groupby(layout.fields, key=lambda f: (f.code, not f.count)):
        run = list(group)
        if single and len(run) > 1:
            add(f"{run[0].name}:{run[-1].name}", (_NUMPY[code], (len(run),)), offset)
        for field in run:
            kind = _kind(field)
            add(field.name, kind, offset)
            offset += kind.itemsize
    return np.dtype(
        {"names": names, "formats": formats, "offsets": offsets, "itemsize": layout.struct.size}
    )


def _kind(field: Field) -> np.dtype[Any]:
    if field.code == "s":
        return np.dtype(f"S{field.count}")
    kind = _NUMPY[field.code]
    return np.dtype((kind, (field.count,))) if field.count else np.dtype(kind)
