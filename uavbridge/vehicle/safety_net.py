"""Sets the autopilot's own safety net, reads it back, and puts it back as it was.

Read all, set what differs one after the other, read all again. Autopilots differ in what
they have: of the names of a setting the first that is answered counts, and a setting
without any is told of but holds nothing up.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Any

from uavbridge.mavlink.parameters import Kind, Parameters, same
from uavbridge.mavlink.plan import Setting
from uavbridge.vehicle.api import (
    Command,
    Done,
    Refused,
    RestoreNet,
    Said,
    SetNet,
    VehicleEvent,
)

_NOTICE = 5


class _Stage(Enum):
    IDLE = "idle"
    READ = "read"  # what is there
    SET = "set"  # one after the other
    CHECK = "check"  # read back


class SafetyNet:
    """The safety net of one autopilot.

    Args:
        parameters: of that autopilot, for this alone.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.before: dict[str, tuple[float, Kind]] = {}
        """What was there before, of all that was changed."""
        self._stage = _Stage.IDLE
        self._command: Command | None = None
        self._settings: Sequence[Setting] = ()
        self._waiting: dict[int, str] = {}  # ticket -> parameter
        self._queue: list[tuple[str, float, Kind]] = []
        self._wanted: list[tuple[str, float, Kind]] = []
        self._events: list[VehicleEvent] = []

    @property
    def idle(self) -> bool:
        """Nothing is on its way, and nothing to tell."""
        return self._stage is _Stage.IDLE and not self._events

    @property
    def cast(self) -> bool:
        """It is set, and was not put back yet."""
        return bool(self.before)

    def start(self, command: SetNet, settings: Sequence[Setting], t_us: int) -> None:
        """Begin to set it; asked again meanwhile, nothing changes."""
        if self._stage is not _Stage.IDLE:
            return
        self._command, self._settings = command, settings
        self._stage = _Stage.READ
        names = [name for setting in settings for name, _ in setting.names]
        self._waiting = {self._parameters.get(name, t_us): name for name in names}
        self._parameters.values.clear()

    def restore(self, t_us: int) -> None:
        """Begin to put it back."""
        if self._stage is not _Stage.IDLE:
            return
        self._command = RestoreNet()
        back = [(name, value, kind) for name, (value, kind) in self.before.items()]
        self._begin_setting(back[::-1], t_us)

    def hear(self, message: Any, t_us: int) -> None:
        """Take a PARAM_VALUE."""
        if self._stage is not _Stage.IDLE:
            self._parameters.hear(message, t_us)

    def advance(self, t_us: int) -> tuple[list[VehicleEvent], list[bytes]]:
        """Events since the last call, and frames to send now."""
        frames = self._parameters.due(t_us)
        for verdict in self._parameters.take():
            name = self._waiting.pop(verdict.ticket, None)
            if name is not None and self._stage is _Stage.SET and not verdict.accepted:
                self._refuse(verdict.reason)
        if self._stage is _Stage.READ and self._known():
            for ticket in self._waiting:  # other names for what was answered
                self._parameters.drop(ticket)
            self._waiting = {}
        if not self._waiting:
            self._next(t_us)
        events, self._events = self._events, []
        return events, frames

    def _known(self) -> bool:
        """Every setting was answered under one of its names."""
        values = self._parameters.values
        return all(any(name in values for name, _ in s.names) for s in self._settings)

    def _next(self, t_us: int) -> None:
        if self._stage is _Stage.READ:
            self._plan(t_us)
        elif self._stage is _Stage.SET:
            self._set_next(t_us)
        elif self._stage is _Stage.CHECK:
            self._check()

    def _plan(self, t_us: int) -> None:
        """All that is there is known now: what differs is to be set."""
        values, changes = self._parameters.values, []
        for setting in self._settings:
            found = next((pair for pair in setting.names if pair[0] in values), None)
            if found is None:
                name = setting.names[0][0]
                self._events.append(Said(_NOTICE, f"safety net: it has no parameter {name}"))
                continue
            name, value = found
            if not same(values[name], value):
                kind = self._parameters.kinds.get(name, setting.kind)
                self.before.setdefault(name, (values[name], kind))
                changes.append((name, value, kind))
        self._begin_setting(changes, t_us)

    def _begin_setting(self, changes: list[tuple[str, float, Kind]], t_us: int) -> None:
        self._stage = _Stage.SET
        self._wanted, self._queue = changes, list(changes)
        self._set_next(t_us)

    def _set_next(self, t_us: int) -> None:
        if self._queue:
            name, value, kind = self._queue.pop(0)
            self._waiting = {self._parameters.set(name, value, kind, t_us): name}
            return
        self._stage = _Stage.CHECK
        self._waiting = {self._parameters.get(name, t_us): name for name, _, _ in self._wanted}
        for name, _, _ in self._wanted:
            self._parameters.values.pop(name, None)
        if not self._waiting:
            self._check()

    def _check(self) -> None:
        values = self._parameters.values
        for name, value, _ in self._wanted:
            heard = values.get(name)
            if heard is None or not same(heard, value):
                shown = "is not answered" if heard is None else f"reads {heard:g}"
                self._refuse(f"{name} was set to {value:g} but {shown}")
                return
        self._finish(None)

    def _refuse(self, reason: str) -> None:
        self._finish(f"safety net: {reason}")

    def _finish(self, refusal: str | None) -> None:
        command, self._command = self._command, None
        self._stage, self._waiting, self._queue = _Stage.IDLE, {}, []
        if command is None:
            return
        if refusal is not None:
            self._events.append(Refused(command, refusal))
            return
        if isinstance(command, RestoreNet):
            self.before = {}
        self._events.append(Done(command))
