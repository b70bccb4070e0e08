"""ArduPilot's failsafes: the same causes, other words, and no word about setpoints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from sim_vehicles.failsafe import Action, Failsafes
from sim_vehicles.modes import Mode

_CRITICAL: Final = 2
_LOW: Final = (Action.WARN, Action.LAND, Action.RETURN, Action.RETURN, Action.RETURN)
_TERMINATE: Final = 5


class ArduPilotFailsafes(Failsafes):
    """Watches n vehicles; their autopilot deals with setpoints that stop."""

    modes: Mapping[Action, Mode] = {
        Action.HOLD: Mode.BRAKE,
        Action.RETURN: Mode.RETURN,
        Action.LAND: Mode.LAND,
    }
    link_texts = ("GCS Failsafe", "GCS Failsafe Cleared")
    fence_text = "Fence Breached"
    position_text = "EKF variance"
    link_only_if_asked = True

    def _check_offboard(self, t_us: int) -> None:
        pass

    def _run_low(self, i: int, grade: int) -> None:
        low = grade == 1
        text = "low" if low else "critical"
        self._pilot.say(i, _CRITICAL, f"Battery 1 is {text}")
        name = "BATT_FS_LOW_ACT" if low else "BATT_FS_CRT_ACT"
        asked = int(self._pilot.parameters.get(i, name))
        if asked == _TERMINATE:
            self.trigger(i, Action.TERMINATE)
        elif 0 < asked < len(_LOW):
            self.trigger(i, _LOW[asked])

    def _activated(self, i: int) -> None:
        pass  # the cause was told


class PlaneFailsafes(ArduPilotFailsafes):
    """Of aircraft: what stops others makes them loiter, or return."""

    modes: Mapping[Action, Mode] = {
        Action.HOLD: Mode.HOLD,
        Action.RETURN: Mode.RETURN,
        Action.LAND: Mode.RETURN,
    }


class RoverFailsafes(ArduPilotFailsafes):
    """Of ground vehicles: where others land, or brake, they hold."""

    modes: Mapping[Action, Mode] = {
        Action.HOLD: Mode.BRAKE,
        Action.RETURN: Mode.RETURN,
        Action.LAND: Mode.BRAKE,
    }
