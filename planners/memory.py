"""A planner's memory as bytes: canonical, typed, no pickle.

``loads(type(memory), dumps(memory))`` gives an equal value, and equal values
give equal bytes, so that a restarted agent, a recording and a replay agree.
Allowed: None, bool, int, float, str, bytes, tuples, numpy arrays of bools,
integers and floats, and frozen dataclasses of these, nested as deep as needed.

Format: one version byte, then the value. A value is a tag byte and its
content; lengths are unsigned 32 bit, all numbers little-endian:

| tag | value | content |
| --- | --- | --- |
| ``N`` ``T`` ``F`` | None, True, False | nothing |
| ``i`` | int | length, two's complement in the fewest bytes |
| ``f`` | float | 8 bytes IEEE |
| ``s`` ``b`` | str (UTF-8), bytes | length, bytes |
| ``t`` | tuple | length, values |
| ``a`` | array | dtype as ``s``, shape as ``t`` of ``i``, length, bytes in C order |
| ``d`` | dataclass | class name as ``s``, number of fields, values in the fields' order |
"""

from __future__ import annotations

import struct
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, get_args, get_type_hints

import numpy as np

T = TypeVar("T")

VERSION = 1
_LENGTH = struct.Struct("<I")
_FLOAT = struct.Struct("<d")


def dumps(memory: Any) -> bytes:
    """Canonical bytes of a memory value.

    Raises:
        TypeError: something in it is not of the kinds listed above; names the type.
    """
    out = bytearray((VERSION,))
    _write(out, memory)
    return bytes(out)


def loads(kind: type[T], data: bytes) -> T:
    """The value of type ``kind`` that ``dumps`` turned into ``data``.

    Arrays come back read-only. Nested dataclasses are found by the type hints
    of the fields that hold them.

    Raises:
        ValueError: the bytes are not those of a ``kind``.
    """
    if not data or data[0] != VERSION:
        raise ValueError("not the bytes of a planner's memory")
    reader = _Reader(bytes(data), 1)
    value = _read(reader, kind)
    if reader.at != len(data):
        raise ValueError(f"{len(data) - reader.at} bytes too many for a {kind.__name__}")
    if not isinstance(value, kind):
        raise ValueError(f"holds a {type(value).__name__}, not a {kind.__name__}")
    return value


def _sized(out: bytearray, tag: bytes, content: bytes) -> None:
    out += tag + _LENGTH.pack(len(content)) + content


def _write(out: bytearray, value: Any) -> None:
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool):
        out += {None: b"N", True: b"T", False: b"F"}[value]
    elif isinstance(value, int):
        length = (value.bit_length() + 8) // 8
        _sized(out, b"i", int(value).to_bytes(length, "little", signed=True))
    elif isinstance(value, float):
        out += b"f" + _FLOAT.pack(value)
    elif isinstance(value, str):
        _sized(out, b"s", value.encode())
    elif isinstance(value, bytes):
        _sized(out, b"b", value)
    elif isinstance(value, tuple):
        out += b"t" + _LENGTH.pack(len(value))
        for part in value:
            _write(out, part)
    elif isinstance(value, np.ndarray):
        _write_array(out, value)
    elif is_dataclass(value) and not isinstance(value, type):
        parts = [getattr(value, part.name) for part in fields(value)]
        _sized(out, b"d", type(value).__name__.encode())
        out += _LENGTH.pack(len(parts))
        for part in parts:
            _write(out, part)
    else:
        raise TypeError(f"a planner's memory cannot hold a {type(value).__name__}")


def _write_array(out: bytearray, array: np.ndarray[Any, Any]) -> None:
    if array.dtype.kind not in "biuf":
        raise TypeError(f"a planner's memory cannot hold an array of {array.dtype}")
    little = array.astype(array.dtype.newbyteorder("<"), order="C", copy=False)
    _sized(out, b"a", little.dtype.str.encode())
    _write(out, tuple(array.shape))
    out += _LENGTH.pack(little.nbytes) + little.tobytes()


class _Reader:
    """A cursor over the bytes that never runs past their end."""

    def __init__(self, data: bytes, at: int) -> None:
        self.data = data
        self.at = at

    def take(self, count: int) -> bytes:
        end = self.at + count
        if end > len(self.data):
            raise ValueError("the bytes of the memory end too early")
        part = self.data[self.at : end]
        self.at = end
        return part

    def length(self) -> int:
        return int(_LENGTH.unpack(self.take(4))[0])

    def sized(self) -> bytes:
        return self.take(self.length())


_PLAIN = {b"N": None, b"T": True, b"F": False}


def _read(reader: _Reader, hint: Any) -> Any:
    tag = reader.take(1)
    if tag in _PLAIN:
        return _PLAIN[tag]
    if tag == b"i":
        return int.from_bytes(reader.sized(), "little", signed=True)
    if tag == b"f":
        return float(_FLOAT.unpack(reader.take(8))[0])
    if tag == b"s":
        return reader.sized().decode()
    if tag == b"b":
        return reader.sized()
    if tag == b"t":
        return tuple(_read(reader, hint) for _ in range(reader.length()))
    if tag == b"a":
        return _read_array(reader)
    if tag == b"d":
        return _read_dataclass(reader, hint)
    raise ValueError(f"unknown tag {tag!r} in the bytes of a memory")


def _read_array(reader: _Reader) -> np.ndarray[Any, Any]:
    try:
        dtype = np.dtype(reader.sized().decode())
    except TypeError as error:
        raise ValueError("unknown array type in the bytes of a memory") from error
    shape = _read(reader, None)
    content = reader.sized()
    counts = isinstance(shape, tuple) and all(isinstance(part, int) for part in shape)
    if dtype.kind not in "biuf" or not counts:
        raise ValueError(f"an array of {dtype} and shape {shape} in the bytes of a memory")
    array = np.frombuffer(content, dtype).reshape(shape)
    array.setflags(write=False)
    return array


def _read_dataclass(reader: _Reader, hint: Any) -> Any:
    name = reader.sized().decode()
    kinds = {kind.__name__: kind for kind in _dataclasses(hint)}
    if name not in kinds:
        raise ValueError(f"a {name} stands where the type hints name {sorted(kinds) or 'none'}")
    kind = kinds[name]
    hints = get_type_hints(kind)
    names = [part.name for part in fields(kind)]
    count = reader.length()
    if count != len(names):
        raise ValueError(f"{name} has {len(names)} fields, the bytes hold {count}")
    return kind(**{part: _read(reader, hints[part]) for part in names})


def _dataclasses(hint: Any) -> tuple[Any, ...]:
    """Dataclasses named anywhere in a type hint such as ``tuple[Leg, ...] | None``."""
    if isinstance(hint, type) and is_dataclass(hint):
        return (hint,)
    return tuple(kind for part in get_args(hint) for kind in _dataclasses(part))
