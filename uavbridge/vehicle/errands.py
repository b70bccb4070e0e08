"""Commands of the vehicle seam on their way through an autopilot's protocols.

Each ends in exactly one Done or Refused. An accepted command is Done when the
vehicle's heartbeat shows it, so that state and events agree; a refused one waits
a moment for the texts in which autopilots say why.
"""

from __future__ import annotations

from collections import deque
from enum import Enum
from typing import Final

from sim_vehicles.codec import mav
from uavbridge.clock import to_us
from uavbridge.mavlink.commands import Commands, Order, Verdict
from uavbridge.mavlink.landings import Landings
from uavbridge.mavlink.parameters import Parameters
from uavbridge.mavlink.plan import Lead, Plan, ProvideLanding, SetParameter
from uavbridge.mavlink.telemetry import Telemetry
from uavbridge.vehicle.api import Arm, Command, Disarm, Done, Follow, Mode, Refused, VehicleEvent

_CONFIRM_US = to_us(4.0)
_ASK_AGAIN_US = to_us(0.5)
_EXPLAIN_US = to_us(0.3)
_BEFORE_US = to_us(0.2)  # a reason may come just before the answer to a repeated command
_WARNING = 4  # severities up to this explain a refusal
_ENDED_ON_GROUND = (Mode.LAND, Mode.RETURN)
HEARTBEAT_PLEASE: Final = Order(mav.MAV_CMD_REQUEST_MESSAGE, (0.0, 0, 0, 0, 0, 0, 0))


class _Phase(Enum):
    STEP = "step"  # about to begin a step
    ASKED = "asked"  # a command or parameter is on its way
    LEAD = "lead"  # streaming setpoints before the next step
    CONFIRM = "confirm"  # accepted; waiting for the heartbeat that shows it
    EXPLAIN = "explain"  # refused; waiting for texts that say why


class _Errand:
    __slots__ = ("asked", "command", "deadline_us", "index", "phase", "plan", "poll_us", "reason")

    def __init__(self, command: Command, plan: Plan) -> None:
        self.command, self.plan = command, plan
        self.phase = _Phase.STEP
        self.index = 0
        self.asked: tuple[str, int] = ("", 0)  # which machine, its ticket
        self.deadline_us = 0
        self.poll_us = 0
        self.reason = ""


def _rivals(a: Command, b: Command) -> bool:
    """They can not both be carried out: both are about motors, or both about flying."""
    return isinstance(a, Arm | Disarm) == isinstance(b, Arm | Disarm)


class Errands:
    """All commands of one vehicle that have no result yet."""

    def __init__(
        self,
        commands: Commands,
        parameters: Parameters,
        landings: Landings,
        telemetry: Telemetry,
    ) -> None:
        self._commands, self._parameters, self._landings = commands, parameters, landings
        self._telemetry = telemetry
        self._errands: list[_Errand] = []
        self._events: list[VehicleEvent] = []
        self._texts: deque[tuple[int, str]] = deque(maxlen=16)

    @property
    def idle(self) -> bool:
        """Nothing is on its way and nothing to tell."""
        waits = self._errands or self._events
        return not waits and self._landings.idle and self._commands.idle

    @property
    def leading(self) -> bool:
        """Setpoints must be streamed, whether or not somebody gives new ones."""
        return any(isinstance(errand.command, Follow) for errand in self._errands)

    def start(self, command: Command, plan: Plan, t_us: int) -> None:
        """Begin a command; it overtakes a rival that has no result yet."""
        for errand in [each for each in self._errands if _rivals(each.command, command)]:
            self._drop(errand, t_us)
            reason = f"overtaken by {type(command).__name__}"
            self._events.append(Refused(errand.command, reason))
        self._errands.append(_Errand(command, plan))

    def refuse(self, command: Command, reason: str) -> None:
        """Tell of a command that can not even begin."""
        self._events.append(Refused(command, reason))

    def _drop(self, errand: _Errand, t_us: int) -> None:
        self._errands.remove(errand)
        machine, ticket = errand.asked
        if errand.phase is _Phase.ASKED and machine == "command":
            self._commands.drop(ticket, t_us)
        elif errand.phase is _Phase.ASKED and machine == "landing":
            self._landings.drop(ticket)
        elif errand.phase is _Phase.ASKED:
            self._parameters.drop(ticket)

    def said(self, severity: int, text: str, t_us: int) -> None:
        """Remember a text of the autopilot: it may be the reason of a refusal."""
        if severity <= _WARNING and text:
            self._texts.append((t_us, text))

    def advance(self, t_us: int) -> tuple[list[VehicleEvent], list[bytes]]:
        """Events since the last call, and frames to send now."""
        self._take_verdicts(t_us)
        frames: list[bytes] = []
        for errand in list(self._errands):
            self._run(errand, t_us, frames)
        frames += self._commands.due(t_us)
        frames += self._parameters.due(t_us)
        frames += self._landings.due(t_us)
        self._take_verdicts(t_us)  # of those given up just now
        events, self._events = self._events, []
        return events, frames

    def _take_verdicts(self, t_us: int) -> None:
        for verdict in self._commands.take():
            self._judge("command", verdict, t_us)
        for verdict in self._parameters.take():
            self._judge("parameter", verdict, t_us)
        for verdict in self._landings.take():
            self._judge("landing", verdict, t_us)

    def _judge(self, machine: str, verdict: Verdict, t_us: int) -> None:
        for errand in self._errands:
            if errand.phase is _Phase.ASKED and errand.asked == (machine, verdict.ticket):
                if verdict.accepted:
                    errand.index += 1
                    errand.phase = _Phase.STEP
                else:
                    self._explain(errand, verdict.reason, t_us)
                return

    def _explain(self, errand: _Errand, reason: str, t_us: int) -> None:
        errand.phase = _Phase.EXPLAIN
        errand.reason = reason
        errand.deadline_us = t_us + _EXPLAIN_US

    def _run(self, errand: _Errand, t_us: int, frames: list[bytes]) -> None:
        if errand.phase is _Phase.LEAD and t_us >= errand.deadline_us:
            errand.index += 1
            errand.phase = _Phase.STEP
        if errand.phase is _Phase.STEP:
            self._step(errand, t_us)
        if errand.phase is _Phase.CONFIRM:
            self._confirm(errand, t_us, frames)
        elif errand.phase is _Phase.EXPLAIN and t_us >= errand.deadline_us:
            self._finish_refused(errand)

    def _step(self, errand: _Errand, t_us: int) -> None:
        if errand.index == len(errand.plan.steps):
            errand.phase = _Phase.CONFIRM
            errand.deadline_us = t_us + _CONFIRM_US
            errand.poll_us = t_us
            return
        match errand.plan.steps[errand.index]:
            case Lead(duration_s):
                errand.phase = _Phase.LEAD
                errand.deadline_us = t_us + to_us(duration_s)
            case SetParameter(name, value, kind):
                errand.phase = _Phase.ASKED
                errand.asked = ("parameter", self._parameters.set(name, value, kind, t_us))
            case ProvideLanding():
                errand.phase = _Phase.ASKED
                errand.asked = ("landing", self._landings.provide(t_us))
            case order:
                errand.phase = _Phase.ASKED
                errand.asked = ("command", self._commands.ask(order, t_us))

    def _shown(self, plan: Plan) -> bool:
        """The heartbeat shows what was asked for."""
        telemetry = self._telemetry
        if plan.armed is not None and telemetry.armed != plan.armed:
            return False
        if plan.mode is None or telemetry.mode is plan.mode:
            return True
        return plan.mode in _ENDED_ON_GROUND and not telemetry.armed

    def _confirm(self, errand: _Errand, t_us: int, frames: list[bytes]) -> None:
        if self._shown(errand.plan):
            self._errands.remove(errand)
            self._events.append(Done(errand.command))
        elif t_us >= errand.deadline_us:
            shown = f"mode is {self._telemetry.mode_text}, armed {self._telemetry.armed}"
            self._explain(errand, f"accepted, but not done: {shown}", t_us)
        elif t_us >= errand.poll_us:
            errand.poll_us = t_us + _ASK_AGAIN_US
            frames.append(self._commands.frame(HEARTBEAT_PLEASE))

    def _finish_refused(self, errand: _Errand) -> None:
        self._errands.remove(errand)
        since = errand.deadline_us - _EXPLAIN_US - _BEFORE_US
        texts = dict.fromkeys(text for t_us, text in self._texts if t_us >= since)
        said = "; ".join(texts)
        reason = f"{errand.reason}: {said}" if said else errand.reason
        self._events.append(Refused(errand.command, reason))
