"""An autopilot's parameters: read and set by name, with retry.

PX4 carries whole numbers as raw bits in the float field, ArduPilot as plain
floats; ``bytewise`` says which. A setting is done when the autopilot's
PARAM_VALUE shows the new value.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import Any

from sim_vehicles.codec import Encoder
from uavbridge.mavlink.commands import Verdict
from uavbridge.mavlink.exchange import Event, Exchange, Patience, State


class Kind(IntEnum):
    """How a parameter is kept; numbers as in MAV_PARAM_TYPE."""

    UINT8 = 1
    INT8 = 2
    UINT16 = 3
    INT16 = 4
    UINT32 = 5
    INT32 = 6
    REAL32 = 9


_BITS = {
    Kind.UINT8: "<B3x",
    Kind.INT8: "<b3x",
    Kind.UINT16: "<H2x",
    Kind.INT16: "<h2x",
    Kind.UINT32: "<I",
    Kind.INT32: "<i",
}


_KNOWN = frozenset(Kind)


def to_wire(value: float, kind: Kind, *, bytewise: bool) -> float:
    """The float that carries a value. Raises ValueError if ``kind`` can not hold it."""
    if kind is Kind.REAL32 or not bytewise:
        return value
    try:
        return float(struct.unpack("<f", struct.pack(_BITS[kind], int(value)))[0])
    except struct.error as error:
        raise ValueError(f"{value} does not fit {kind.name}") from error


def from_wire(wire: float, kind: int, *, bytewise: bool) -> float:
    """The value that a float carries; unknown kinds are taken as they are."""
    if kind == Kind.REAL32 or not bytewise or kind not in _BITS:
        return wire
    return float(struct.unpack(_BITS[Kind(kind)], struct.pack("<f", wire))[0])


class _Asked:
    __slots__ = ("exchange", "kind", "name", "ticket", "value")

    def __init__(
        self, ticket: int, name: str, value: float | None, kind: Kind, exchange: Exchange
    ) -> None:
        self.ticket, self.name, self.value, self.kind = ticket, name, value, kind
        self.exchange = exchange


class Parameters:
    """Reads and settings of one autopilot's parameters.

    Args:
        encoder: packs for this end.
        system: the autopilot's system id.
        component: the autopilot's component id.
        bytewise: whole numbers travel as raw bits (PX4).
        patience: retries and time-outs.
    """

    def __init__(
        self,
        encoder: Encoder,
        system: int,
        component: int = 1,
        *,
        bytewise: bool = True,
        patience: Patience | None = None,
    ) -> None:
        self._encoder = encoder
        self.system, self.component = system, component
        self.bytewise = bytewise
        self._patience = patience or Patience()
        self._asked: list[_Asked] = []
        self._tickets = 0
        self._verdicts: list[Verdict] = []
        self.values: dict[str, float] = {}
        """Every value heard so far, by name."""
        self.kinds: dict[str, Kind] = {}
        """How each of them is kept."""

    def _ask(self, name: str, value: float | None, kind: Kind, t_us: int) -> int:
        self._tickets += 1
        exchange = Exchange(self._patience, t_us)
        self._asked.append(_Asked(self._tickets, name, value, kind, exchange))
        return self._tickets

    def get(self, name: str, t_us: int) -> int:
        """Ask for a value; it is in ``values`` once the ticket's verdict says accepted."""
        return self._ask(name, None, Kind.REAL32, t_us)

    def set(self, name: str, value: float, kind: Kind, t_us: int) -> int:
        """Change a value; the ticket's verdict says whether it was taken over."""
        return self._ask(name, value, kind, t_us)

    def drop(self, ticket: int) -> None:
        """Forget a request."""
        self._asked = [asked for asked in self._asked if asked.ticket != ticket]

    def hear(self, message: Any, t_us: int) -> None:
        """Take a PARAM_VALUE."""
        name = message.param_id
        value = from_wire(message.param_value, message.param_type, bytewise=self.bytewise)
        self.values[name] = value
        if message.param_type in _KNOWN:
            self.kinds[name] = Kind(message.param_type)
        for asked in self._asked:
            if asked.name == name and (asked.value is None or same(asked.value, value)):
                asked.exchange.hear(Event.ACCEPT, t_us)
        self._collect()

    def _collect(self) -> None:
        for asked in [asked for asked in self._asked if asked.exchange.over]:
            self._asked.remove(asked)
            accepted = asked.exchange.state is State.ACCEPTED
            self._verdicts.append(Verdict(asked.ticket, accepted, self._reason(asked)))

    def _reason(self, asked: _Asked) -> str:
        if asked.exchange.state is State.ACCEPTED:
            return ""
        if asked.value is not None and asked.name in self.values:
            return f"{asked.name} stays {self.values[asked.name]:g}, not {asked.value:g}"
        return f"no answer for parameter {asked.name}"

    def due(self, t_us: int) -> list[bytes]:
        """Frames to send now."""
        frames = [self._frame(asked) for asked in self._asked if asked.exchange.due(t_us)]
        self._collect()
        return frames

    def _frame(self, asked: _Asked) -> bytes:
        target = {"target_system": self.system, "target_component": self.component}
        if asked.value is None:
            return self._encoder.pack(
                "PARAM_REQUEST_READ", param_id=asked.name, param_index=-1, **target
            )
        return self._encoder.pack(
            "PARAM_SET",
            param_id=asked.name,
            param_value=to_wire(asked.value, asked.kind, bytewise=self.bytewise),
            param_type=int(asked.kind),
            **target,
        )

    def take(self) -> list[Verdict]:
        """Verdicts since the last call."""
        verdicts, self._verdicts = self._verdicts, []
        return verdicts

    @property
    def idle(self) -> bool:
        """Nothing is on its way."""
        return not self._asked and not self._verdicts


def same(wanted: float, heard: float) -> bool:
    """Equal as the float32 that travels."""
    return bool(struct.pack("<f", wanted) == struct.pack("<f", heard))
