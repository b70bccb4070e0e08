"""Commands with retry: COMMAND_LONG and COMMAND_INT out, COMMAND_ACK in.

An ack names only the command's number, so of one number one command is on its
way at a time; the others wait. PX4 answers a mode change twice, and every retry
can be answered: after such a command the number rests for a moment, so that a
late ack is not taken for that of the next.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import nan
from typing import Any, Final, TypeAlias

from sim_vehicles.codec import Encoder, mav
from uavbridge.clock import to_us
from uavbridge.mavlink.exchange import Event, Exchange, Patience, State

Params: TypeAlias = tuple[float, float, float, float, float, float, float]

DEFAULTS: Final[Params] = (nan, nan, nan, nan, nan, nan, nan)  # the autopilot chooses

_REST_US = to_us(0.3)
_DOUBLY_ANSWERED = frozenset({int(mav.MAV_CMD_DO_SET_MODE)})
_EVENTS: Final = {
    int(mav.MAV_RESULT_ACCEPTED): Event.ACCEPT,
    int(mav.MAV_RESULT_IN_PROGRESS): Event.PROGRESS,
}
_UNSUPPORTED: Final = int(mav.MAV_RESULT_UNSUPPORTED)
_RESULTS: Final = {
    int(mav.MAV_RESULT_TEMPORARILY_REJECTED): "temporarily rejected",
    int(mav.MAV_RESULT_DENIED): "denied",
    _UNSUPPORTED: "not supported",
    int(mav.MAV_RESULT_FAILED): "failed",
    6: "cancelled",  # MAV_RESULT_CANCELLED, newer than the dialect module
}


@dataclass(frozen=True, slots=True)
class Order:
    """One command to an autopilot, in MAVLink's own units.

    Attributes:
        command: MAV_CMD number.
        params: the seven parameters; NaN leaves one to the autopilot.
        frame: send as COMMAND_INT in this MAV_FRAME; parameters 5 and 6 are then
            whole numbers (1e-7 degrees). None: COMMAND_LONG.
        persistent: ask again when refused, until the tries are used up.
    """

    command: int
    params: Params = DEFAULTS
    frame: int | None = None
    persistent: bool = False


@dataclass(frozen=True, slots=True)
class Verdict:
    """How a command or a parameter request ended."""

    ticket: int
    accepted: bool
    reason: str = ""  # of a refusal, in few words


class _Sent:
    __slots__ = ("exchange", "order", "reason", "ticket")

    def __init__(self, ticket: int, order: Order, exchange: Exchange) -> None:
        self.ticket, self.order, self.exchange = ticket, order, exchange
        self.reason = ""


class Commands:
    """All commands to one autopilot.

    Args:
        encoder: packs for this end.
        system: the autopilot's system id.
        component: the autopilot's component id.
        patience: retries and time-outs.
    """

    def __init__(
        self, encoder: Encoder, system: int, component: int = 1, patience: Patience | None = None
    ) -> None:
        self._encoder = encoder
        self.system, self.component = system, component
        self._patience = patience or Patience()
        self._lines: dict[int, deque[_Sent]] = {}
        self._waiting = 0  # commands in all lines
        self._rests: dict[int, int] = {}
        self._tickets = 0
        self._verdicts: list[Verdict] = []

    def ask(self, order: Order, t_us: int) -> int:
        """Queue a command; ``take`` gives a verdict with the returned ticket."""
        self._tickets += 1
        sent = _Sent(self._tickets, order, Exchange(self._patience, t_us))
        self._lines.setdefault(order.command, deque()).append(sent)
        self._waiting += 1
        return self._tickets

    def drop(self, ticket: int, t_us: int) -> None:
        """Forget a command: nobody waits for its answer any more."""
        for command, line in self._lines.items():
            for sent in line:
                if sent.ticket == ticket:
                    if sent.exchange.tries:
                        self._rests[command] = t_us + _REST_US
                    line.remove(sent)
                    self._waiting -= 1
                    return

    def hear(self, ack: Any, t_us: int) -> None:
        """Take a COMMAND_ACK that is for us."""
        line = self._lines.get(ack.command)
        if not line:
            return
        sent = line[0]
        event = _EVENTS.get(ack.result)
        if event is None:
            sent.reason = _RESULTS.get(ack.result, f"result {ack.result}")
            again = sent.order.persistent and ack.result != _UNSUPPORTED
            event = Event.LATER if again else Event.REFUSE
        sent.exchange.hear(event, t_us)
        if sent.exchange.over:
            self._finish(sent, t_us)

    def _finish(self, sent: _Sent, t_us: int) -> None:
        command = sent.order.command
        self._lines[command].popleft()
        self._waiting -= 1
        if command in _DOUBLY_ANSWERED or sent.exchange.tries > 1:
            self._rests[command] = t_us + _REST_US
        state = sent.exchange.state
        reason = "no answer" if state is State.SILENT else sent.reason
        self._verdicts.append(Verdict(sent.ticket, state is State.ACCEPTED, reason))

    def due(self, t_us: int) -> list[bytes]:
        """Frames to send now."""
        frames = []
        for command, line in self._lines.items():
            while line and t_us >= self._rests.get(command, 0):
                sent = line[0]
                if sent.exchange.due(t_us):
                    frames.append(self.frame(sent.order, sent.exchange.tries - 1))
                if not sent.exchange.over:
                    break
                self._finish(sent, t_us)
        return frames

    def frame(self, order: Order, confirmation: int = 0) -> bytes:
        """The bytes of a command; ``confirmation`` counts its repetitions."""
        p1, p2, p3, p4, p5, p6, p7 = order.params
        target = {"target_system": self.system, "target_component": self.component}
        common = {"command": order.command, "param1": p1, "param2": p2, "param3": p3, "param4": p4}
        if order.frame is not None:
            return self._encoder.pack(
                "COMMAND_INT", frame=order.frame, x=int(p5), y=int(p6), z=p7, **common, **target
            )
        return self._encoder.pack(
            "COMMAND_LONG",
            confirmation=min(confirmation, 255),
            param5=p5,
            param6=p6,
            param7=p7,
            **common,
            **target,
        )

    def take(self) -> list[Verdict]:
        """Verdicts since the last call."""
        verdicts, self._verdicts = self._verdicts, []
        return verdicts

    @property
    def idle(self) -> bool:
        """Nothing is on its way."""
        return not self._waiting and not self._verdicts
