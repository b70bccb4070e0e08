"""JSON that came over the bus, from anybody."""

from __future__ import annotations

from typing import TypeVar

from msgspec import DecodeError
from msgspec.json import Decoder

T = TypeVar("T")


def read(decoder: Decoder[T], data: bytes) -> T:
    """What ``data`` says.

    Raises:
        DecodeError: it is not such a document, whatever is wrong with it: msgspec has other
            errors for texts that are no UTF-8 and for lists nested a million deep.
    """
    try:
        return decoder.decode(data)
    except (UnicodeDecodeError, RecursionError) as fault:
        raise DecodeError(str(fault)) from None
