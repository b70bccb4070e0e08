"""Failsafes: what goes wrong, and what is done about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import Final

import numpy as np

from sim_vehicles.dynamics.model import Bools
from sim_vehicles.modes import Mode
from sim_vehicles.pilot import Pilot
from sim_vehicles.status import ALWAYS_LATER, I64


class Action(IntEnum):
    """What a failsafe does; the higher wins."""

    NONE = 0
    WARN = 1
    HOLD = 2
    RETURN = 3
    LAND = 4
    DISARM = 5
    TERMINATE = 6


_R, _L, _H = Action.RETURN, Action.LAND, Action.HOLD
# Without a pilot's sticks PX4 returns where a parameter names a mode flown by hand.
OFFBOARD_LOSS: Final = (_R, _R, _R, _R, _L, _H, Action.TERMINATE, Action.DISARM)
LINK_LOSS: Final = (Action.NONE, _H, _R, _L, Action.NONE, Action.TERMINATE, Action.DISARM)
FENCE: Final = (Action.NONE, Action.WARN, _H, _R, Action.TERMINATE, _L)
_CRITICAL_BATTERY: Final = (Action.WARN, _R, _L, _R)
_EMERGENCY_BATTERY: Final = (Action.WARN, _R, _L, _L)
"""Actions by the values of COM_OBL_RC_ACT, NAV_DLL_ACT, GF_ACTION and COM_LOW_BAT_ACT."""

_MODES: Final[Mapping[Action, Mode]] = {
    Action.HOLD: Mode.HOLD,
    Action.RETURN: Mode.RETURN,
    Action.LAND: Mode.LAND,
}
_BATTERY_TEXTS: Final = (
    "",
    "Low battery level, return advised",
    "Critical battery level, land now",
    "Emergency battery level, land immediately",
)
_EMERGENCY, _CRITICAL, _WARNING = 0, 2, 4
_OFFBOARD: Final = int(Mode.OFFBOARD)


class Failsafes:
    """Watches n vehicles; acts through their autopilot."""

    modes: Mapping[Action, Mode] = _MODES
    link_texts: tuple[str, str] = ("Connection to ground station lost", "GCS connection regained")
    fence_text = "Geofence exceeded"
    position_text = "Position estimate lost"
    link_only_if_asked = False  # a lost link is nothing worth telling, unless something is done

    def __init__(self, pilot: Pilot) -> None:
        self._pilot = pilot
        self._status = pilot.status
        n = len(pilot.status.mode)
        self._pending_us: I64 = np.full(n, ALWAYS_LATER, dtype=np.int64)
        self._pending: dict[int, Action] = {}
        self._outside: Bools = np.zeros(n, dtype=np.bool_)
        self._link_done: Bools = np.zeros(n, dtype=np.bool_)
        needing = [mode in pilot.modes and pilot.modes[mode].needs_position for mode in Mode]
        self._placed: Bools = np.array(needing, dtype=np.bool_)
        self._version = -1
        self._fenced = False
        self.fences: dict[int, Callable[[float, float, float], bool]] = {}
        """Vehicles with an uploaded fence: is a place (ENU m) inside it?"""

    def check(self, t_us: int) -> None:
        """Look at all vehicles, act on what is new."""
        if self._pilot.parameters.version != self._version:
            self._version = self._pilot.parameters.version
            column = self._pilot.parameters.column
            self._fenced = bool((column("GF_MAX_HOR_DIST") > 0).any()) or bool(
                (column("GF_MAX_VER_DIST") > 0).any()
            )
        self._check_offboard(t_us)
        self._check_position(t_us)
        self._check_link(t_us)
        self._check_battery()
        if self._fenced or self.fences:
            self._check_fence()
        if self._pending:
            for i in (self._pending_us <= t_us).nonzero()[0].tolist():
                self._act(i, self._forget(i))

    def clear(self, i: int) -> None:
        """Someone chose a mode, or it is disarmed: nothing is in force any more."""
        self._forget(i)
        self._status.failsafe[i] = Action.NONE

    def disarmed(self, i: int) -> None:
        """Next flight, next chance."""
        self.clear(i)
        self._link_done[i] = False
        self._outside[i] = False

    def _forget(self, i: int) -> Action:
        self._pending_us[i] = ALWAYS_LATER
        return self._pending.pop(i, Action.NONE)

    # -- causes ------------------------------------------------------------------

    def _check_offboard(self, t_us: int) -> None:
        status = self._status
        flown = status.armed & (status.mode == _OFFBOARD)
        if not flown.any():
            return
        column = self._pilot.parameters.column
        late = flown & (t_us - status.setpoint_us > column("COM_OF_LOSS_T") * 1e6)
        for i in late.nonzero()[0].tolist():
            self.trigger(i, OFFBOARD_LOSS[int(column("COM_OBL_RC_ACT")[i])], delayed=False)
            if status.mode[i] == Mode.OFFBOARD:  # nothing worse was in force: at least stop
                self._pilot.switch(i, Mode.HOLD)

    def _check_position(self, t_us: int) -> None:
        """Without a position estimate, modes that need one end in a landing."""
        status = self._status
        lost = (status.ready_us > t_us) & status.armed & ~status.landed & self._placed[status.mode]
        if lost.any():
            for i in lost.nonzero()[0].tolist():
                self._pilot.say(i, _CRITICAL, self.position_text)
                self.trigger(i, Action.LAND, delayed=False)

    def _check_link(self, t_us: int) -> None:
        status, column = self._status, self._pilot.parameters.column
        lost = t_us - status.gcs_us > column("COM_DL_LOSS_T") * 1e6
        if self.link_only_if_asked:
            lost &= column("NAV_DLL_ACT") > 0
        fresh = lost & ~status.gcs_lost & (status.gcs_us >= 0)
        if fresh.any():
            status.gcs_lost |= fresh
            for i in fresh.nonzero()[0].tolist():
                self._pilot.say(i, _WARNING, self.link_texts[0])
        act = status.gcs_lost & status.armed & ~status.landed & ~self._link_done
        if act.any():
            for i in act.nonzero()[0].tolist():
                self._link_done[i] = True
                self.trigger(i, LINK_LOSS[int(column("NAV_DLL_ACT")[i])])

    def heard_gcs(self, i: int) -> None:
        """A ground station's heartbeat came."""
        if self._status.gcs_lost[i]:
            self._status.gcs_lost[i] = False
            self._link_done[i] = False
            self._pilot.say(i, 6, self.link_texts[1])

    def _check_battery(self) -> None:
        status, column = self._status, self._pilot.parameters.column
        charge = self._pilot.states.battery
        low = charge < column("BAT_LOW_THR")
        if not low.any():
            return
        empty = status.armed & (charge <= 0.0)
        for i in empty.nonzero()[0].tolist():
            self._pilot.stop_motors(i, "Disarmed: battery empty")
        level = low.astype(np.int8) + (charge < column("BAT_CRIT_THR"))
        level += charge < column("BAT_EMERGEN_THR")
        worse = level > status.battery_level
        for i in worse.nonzero()[0].tolist():
            grade = int(level[i])
            status.battery_level[i] = grade
            self._run_low(i, grade)

    def _run_low(self, i: int, grade: int) -> None:
        """The battery is low (1), critical (2) or nearly empty (3)."""
        self._pilot.say(i, (6, _WARNING, _CRITICAL, _EMERGENCY)[grade], _BATTERY_TEXTS[grade])
        if grade >= 2:
            table = _CRITICAL_BATTERY if grade == 2 else _EMERGENCY_BATTERY
            self.trigger(i, table[int(self._pilot.parameters.get(i, "COM_LOW_BAT_ACT"))])

    def _check_fence(self) -> None:
        status, column = self._status, self._pilot.parameters.column
        away = self._pilot.states.position - status.home
        wide, high = column("GF_MAX_HOR_DIST"), column("GF_MAX_VER_DIST")
        polygons = column("POLYGON_FENCES")
        outside = (wide > 0) & (np.hypot(away[:, 0], away[:, 1]) > wide)
        outside |= (high > 0) & (away[:, 2] > high)
        for i, inside in self.fences.items():
            if polygons[i]:
                outside[i] |= not inside(*self._pilot.place(i))
        outside &= status.armed
        for i in (outside & ~self._outside).nonzero()[0].tolist():
            action = FENCE[int(column("GF_ACTION")[i])]
            if action is not Action.NONE:
                self._pilot.say(i, _WARNING, self.fence_text)
                self.trigger(i, action, delayed=False)
        self._outside = outside

    # -- actions -----------------------------------------------------------------

    def trigger(self, i: int, action: Action, *, delayed: bool = True) -> None:
        """Do something about a failure, unless more is already being done.

        With ``delayed`` the vehicle first holds for COM_FAIL_ACT_T, so that people can step in.
        """
        status = self._status
        if not status.armed[i] or action <= max(Action.WARN, int(status.failsafe[i])):
            return
        status.failsafe[i] = action
        delay_s = self._pilot.parameters.get(i, "COM_FAIL_ACT_T") if delayed else 0.0
        if delay_s > 0.1 and action in (Action.RETURN, Action.LAND) and self._may(i, Action.HOLD):
            text = f"Failsafe activated, entering Hold for {delay_s:.0f} seconds"
            self._pilot.say(i, _CRITICAL, text)
            self._pilot.switch(i, Mode.HOLD)
            self._pending[i] = action
            self._pending_us[i] = self._pilot.now_us + round(delay_s * 1e6)
            return
        self._forget(i)
        self._act(i, action)

    def _may(self, i: int, action: Action) -> bool:
        """Do not stop a return or a landing for something less."""
        mode = self._status.mode[i]
        return not (mode == Mode.LAND or (mode == Mode.RETURN and action <= Action.RETURN))

    def _activated(self, i: int) -> None:
        self._pilot.say(i, _CRITICAL, "Failsafe activated")

    def _act(self, i: int, action: Action) -> None:
        if not self._status.armed[i]:
            return
        self._activated(i)
        mode = self.modes.get(action)
        if mode is None:
            self._pilot.stop_motors(i, "Disarmed by failsafe")
        elif self._may(i, action):
            self._pilot.switch(i, mode)
