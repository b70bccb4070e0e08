"""What UAVs and place agents send each other over the emulated radio.

A message bears its sender, the one it is for, and where and when it was sent; within is a word
or an answer of ``planners.pheromone.words``. Described in docs/reference/wire_format.md.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from struct import Struct, error

from uavbridge.bus.wire import (
    MAGIC,
    POSITION_LIMIT_M,
    VERSION,
    Kind,
    MalformedError,
    Vector,
    accepted,
    check_head,
    check_time,
)

MOST_BYTES = 16_384
_SAID = Struct("<2sBBIIq3fH")


@dataclass(frozen=True, slots=True)
class Said:
    """One message.

    Attributes:
        sender: agent or place agent.
        to: whom it is for.
        t_us: when it was sent; several of one sender at one time are a microsecond apart.
        position: of the sender then, ENU m.
        body: a word, or an answer.
        waited_s: in the queue of the sender's radio, in whole ms.
    """

    sender: int
    to: int
    t_us: int
    position: Vector
    body: bytes
    waited_s: float = 0.0


def encode_said(said: Said) -> bytes:
    """The bytes of a message. Raises ValueError when a number does not fit its field."""
    try:
        head = _SAID.pack(
            MAGIC,
            VERSION,
            Kind.PLACE,
            said.sender,
            said.to,
            said.t_us,
            *said.position,
            round(said.waited_s * 1e3),
        )
    except (error, OverflowError) as fault:
        raise ValueError(f"place: {fault}") from None
    return head + said.body


def decode_said(data: bytes, rejects: Counter[str] | None = None) -> Said | None:
    """The message in ``data``; None, and its reason counted, when malformed."""
    return accepted(_said, data, rejects)


def _said(data: bytes) -> Said:
    check_head(data, _SAID.size, (Kind.PLACE,))
    _, _, _, sender, to, t_us, x, y, z, waited_ms = _SAID.unpack_from(data)
    if len(data) > _SAID.size + MOST_BYTES:
        raise MalformedError("size")
    check_time(t_us)
    if not all(-POSITION_LIMIT_M <= part <= POSITION_LIMIT_M for part in (x, y, z)):
        raise MalformedError("position")
    return Said(sender, to, t_us, (x, y, z), data[_SAID.size :], waited_ms / 1e3)
