"""Message layouts, made on first use from pymavlink's generated dialect."""

from __future__ import annotations

import re
import struct
from collections import namedtuple
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from pymavlink.dialects.v20 import ardupilotmega

mav: Final[Any] = ardupilotmega
"""The dialect module (ardupilotmega: common and ArduPilot's own): enums and constants."""

_FORMAT = re.compile(r"(\d*)([a-zA-Z])")


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message, on the wire."""

    name: str
    code: str  # struct format character; "s": text
    count: int  # elements of an array, bytes of a text, 0: a single value


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """How one message lies on the wire, and how its values are made."""

    name: str
    msgid: int
    fields: tuple[Field, ...]  # in wire order
    defaults: dict[str, Any]  # field -> zero, in wire order
    struct: struct.Struct  # the whole payload, untruncated
    crc_extra: bytes  # one byte
    make: Callable[[tuple[Any, ...]], Any]  # unpacked struct -> message
    flat: bool  # only single values: no arrays, no texts

    def values(self, fields: dict[str, Any]) -> Iterable[Any]:
        """Arguments of ``struct.pack`` from named fields; missing ones are zero.

        Raises:
            ValueError: a field that the message does not have, or a text or an array
                of the wrong length.
        """
        merged = self.defaults | fields
        if len(merged) != len(self.defaults):
            unknown = ", ".join(sorted(set(fields) - set(self.defaults)))
            raise ValueError(f"{self.name} has no field {unknown}")
        if self.flat:
            return merged.values()
        values: list[Any] = []
        for field in self.fields:
            value = merged[field.name]
            if not field.count:
                values.append(value)
            elif field.code == "s":
                values.append(self._encoded(field, value))
            elif len(value) == field.count:
                values.extend(value)
            else:
                raise ValueError(
                    f"{self.name}.{field.name} takes {field.count} values, not {len(value)}"
                )
        return values

    def _encoded(self, field: Field, value: str | bytes) -> bytes:
        data = value.encode() if isinstance(value, str) else bytes(value)
        if len(data) > field.count:
            raise ValueError(
                f"{self.name}.{field.name} takes at most {field.count} bytes, not {len(data)}"
            )
        return data

    def pack(self, fields: dict[str, Any]) -> bytes:
        """The payload with trailing zeros cut off (one byte is always left).

        Raises:
            ValueError: a value out of its field's range, or of a wrong kind.
        """
        values = self.values(fields)
        try:
            return self.struct.pack(*values).rstrip(b"\0") or b"\0"
        except (struct.error, OverflowError, TypeError) as error:
            raise ValueError(self._blame(fields, str(error))) from None

    def _blame(self, fields: dict[str, Any], reason: str) -> str:
        """Which field a failed ``pack`` stumbled over."""
        for field in self.fields:
            value = fields.get(field.name, self.defaults[field.name])
            elements = value if field.count and field.code != "s" else (value,)
            for element in elements:
                try:
                    if field.code != "s":
                        struct.pack("<" + field.code, element)
                except (struct.error, OverflowError, TypeError) as error:
                    return f"{self.name}.{field.name} can not be {element!r}: {error}"
        return f"{self.name}: {reason}"


class _ById(dict[int, Layout | None]):
    """Layouts by message id; ids outside the dialect give None and are not kept."""

    def __missing__(self, msgid: int) -> Layout | None:
        generated = mav.mavlink_map.get(msgid)
        if generated is None:
            return None
        layout = self[msgid] = _layout(generated)
        return layout


class _ByName(dict[str, Layout]):
    """Layouts by message name."""

    def __missing__(self, name: str) -> Layout:
        msgid = getattr(mav, f"MAVLINK_MSG_ID_{name}", None)
        layout = _later(name) if msgid is None else BY_ID[msgid]
        if layout is None:
            raise ValueError(f"there is no MAVLink message {name}")
        self[name] = layout
        return layout


def _later(name: str) -> Layout | None:
    """A message that the dialect does not have yet, and that simulated vehicles send."""
    from pymavlink.dialects.v20 import development

    msgid = getattr(development, f"MAVLINK_MSG_ID_{name}", None)
    return None if msgid is None else _layout(development.mavlink_map[msgid])


BY_ID: Final = _ById()
BY_NAME: Final = _ByName()


def _layout(generated: Any) -> Layout:
    """Read one of pymavlink's generated classes."""
    packed = generated.unpacker
    formats = _FORMAT.findall(packed.format)
    fields = tuple(
        Field(name, code, int(count) if count else 0)
        for name, (count, code) in zip(generated.ordered_fieldnames, formats, strict=True)
    )
    flat = not any(field.count for field in fields)
    # msgname and msgid sit on the class, so every message of it has them
    named: Any = namedtuple  # its arguments are known only here, not to the type checker
    message = named(generated.msgname, [field.name for field in fields])
    message.msgname = generated.msgname
    message.msgid = generated.id
    new = partial(tuple.__new__, message)
    return Layout(
        name=generated.msgname,
        msgid=generated.id,
        fields=fields,
        defaults={field.name: _zero(field) for field in fields},
        struct=packed,
        crc_extra=bytes([generated.crc_extra]),
        make=new if flat else partial(_make_nested, new, _spans(fields)),
        flat=flat,
    )


def _zero(field: Field) -> Any:
    if field.code == "s":
        return b""
    if field.code == "c":
        return b"\0"
    return (0,) * field.count if field.count else 0


def _spans(fields: tuple[Field, ...]) -> tuple[tuple[int, int, bool], ...]:
    """For each field: its first place in the unpacked tuple, its end (0: single), is it text."""
    spans: list[tuple[int, int, bool]] = []
    start = 0
    for field in fields:
        text = field.code == "s"
        length = field.count if field.count and not text else 1
        spans.append((start, start + length if field.count and not text else 0, text))
        start += length
    return tuple(spans)


def _make_nested(
    new: Callable[[Iterable[Any]], Any],
    spans: tuple[tuple[int, int, bool], ...],
    flat: tuple[Any, ...],
) -> Any:
    return new(
        [
            _decoded(flat[start]) if text else flat[start:end] if end else flat[start]
            for start, end, text in spans
        ]
    )


def _decoded(data: bytes) -> str:
    return data.partition(b"\0")[0].decode("utf-8", "replace")
