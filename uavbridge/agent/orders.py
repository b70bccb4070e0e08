"""What people and the mission's judge may tell an agent, and what it answers.

Orders travel on ``cmd/<agent | all>``, answers on ``state/<agent>/ack``, both as JSON.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import msgspec
from msgspec import Struct

from uavbridge.bus.text import read
from uavbridge.bus.wire import POSITION_LIMIT_M, Vector


class Verb(Enum):
    """What to do. The words are those of the command line."""

    PAUSE = "pause"  # stand still in the air, our setpoints go on
    RESUME = "resume"  # search on
    GOTO = "goto"  # fly to a point and stand still there
    HOLD = "hold"  # leave the vehicle to its autopilot's own hold
    TAKEOVER = "takeover"  # take back a vehicle that was held, or that somebody took
    RETURN = "rtl"  # fly home and land
    LAND = "land"  # land here
    ABORT = "abort"  # end the mission: everybody lands where it is


@dataclass(frozen=True, slots=True)
class Order:
    """One order."""

    verb: Verb
    id: str = ""  # of the one who asks, for the answer; empty: no answer wanted
    position: Vector | None = None  # ENU m, of a goto; its height may be NaN: keep the present one


class Ack(Struct, frozen=True):
    """An agent's answer to one order, as JSON on ``state/<agent>/ack``."""

    id: str
    agent: int
    verb: str
    ok: bool
    reason: str = ""
    t_us: int = 0


class _Wire(Struct, frozen=True, omit_defaults=True):
    order: str
    id: str = ""
    position: tuple[float, float, float | None] | None = None


_DECODER = msgspec.json.Decoder(_Wire)
_ACK = msgspec.json.Decoder(Ack)


def encode(order: Order) -> bytes:
    """An order as it travels."""
    where = order.position
    if where is not None:
        x, y, z = where
        return msgspec.json.encode(_Wire(order.verb.value, order.id, (x, y, z if z == z else None)))
    return msgspec.json.encode(_Wire(order.verb.value, order.id))


def decode(data: bytes) -> Order:
    """An order from the wire.

    Raises:
        ValueError: not an order; the message says why (msgspec's errors are ValueErrors).
    """
    wire = read(_DECODER, data)
    verb = Verb(wire.order)
    if wire.position is None:
        if verb is Verb.GOTO:
            raise ValueError("goto needs a position")
        return Order(verb, wire.id)
    x, y, z = wire.position
    if not all(abs(part) <= POSITION_LIMIT_M for part in (x, y, z or 0.0)):
        raise ValueError(f"no such position: {wire.position}")
    return Order(verb, wire.id, (x, y, float("nan") if z is None else z))


def encode_ack(ack: Ack) -> bytes:
    """An answer as it travels."""
    return msgspec.json.encode(ack)


def decode_ack(data: bytes) -> Ack:
    """An answer from the wire. Raises msgspec.DecodeError for anything else."""
    return read(_ACK, data)
