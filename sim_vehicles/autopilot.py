"""Autopilots of n vehicles over one batched vehicle model.

Requests (arm, mode, setpoint, ...) take effect at once; everything else happens in ``tick``,
which looks at all vehicles together and runs Python per vehicle only where something
happened. Frame: the fleet's ENU metres; the MAVLink side converts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nan
from typing import Final

import numpy as np

from sim_vehicles.arming import Refusal, why_not_arm, why_not_change
from sim_vehicles.craft import Craft
from sim_vehicles.dynamics.model import F64, Bools, Setpoints, States
from sim_vehicles.failsafe import Failsafes
from sim_vehicles.legs import DESCEND, Asked, Tilt
from sim_vehicles.modes import Mode, ModeSpec
from sim_vehicles.params import Parameters
from sim_vehicles.pilot import Routine
from sim_vehicles.plans import Plan, Step, Vector
from sim_vehicles.routines import stopping_place
from sim_vehicles.status import ALWAYS_LATER, NEVER, Said, Status, Told

_INFO: Final = 6


class Autopilot:
    """The autopilots, one a row.

    Args:
        craft: what they are.
        systems: (n,) system ids; with ``seed`` they decide when each is ready.
        states: the vehicles' states, live.
        parameters: theirs.
        starts: (n, 3) ENU m: where each stood when it was switched on.
        flying: (n,) starts armed and holding in the air.
        seed: of the little that differs from start to start.
        altitude_m: above sea level of the fleet frame's zero, for texts.

    Attributes:
        now_us: the time; whoever advances it keeps it here.
        status: what they know.
        setpoints: what they ask of the vehicle model.
    """

    def __init__(
        self,
        craft: Craft,
        systems: Sequence[int],
        states: States,
        parameters: Parameters,
        *,
        starts: F64,
        flying: Bools,
        seed: int = 0,
        altitude_m: float = 0.0,
    ) -> None:
        self.now_us = 0
        self.craft = craft
        self._altitude_m = altitude_m
        self.states = states
        self.parameters = parameters
        low, high = craft.ready_s
        ready_us = [
            0 if up else round(np.random.default_rng((seed, system)).uniform(low, high) * 1e6)
            for system, up in zip(systems, flying.tolist(), strict=True)
        ]
        self._start_up_us = ready_us
        self.status = Status.on_ground(starts, states.yaw, ready_us, craft.start_mode)
        self.legs = craft.legs(self.status, states, parameters)
        self.plans = [Plan() for _ in systems]
        self.failsafes = self._watch()
        self.rallies: dict[int, tuple[Vector, ...]] = {}
        self._routines: list[Routine | None] = [None for _ in systems]
        self._goals: dict[int, tuple[Vector, float]] = {}
        self._heights: dict[int, float] = {}
        self._early: dict[int, Asked] = {}  # before Offboard
        for i in flying.nonzero()[0].tolist():
            self.status.landed[i] = False
            self.status.flown[i] = True
            self.status.mode[i] = self.status.before[i] = Mode.HOLD
            self.legs.in_flight(i)
            self._set_armed(i)
        self.legs.fly(0)  # those in the air are held there from the first step on

    @property
    def modes(self) -> Mapping[Mode, ModeSpec]:
        return self.craft.modes

    @property
    def setpoints(self) -> Setpoints:
        return self.legs.setpoints

    # -- what happens by itself -----------------------------------------------------

    def tick(self, t_us: int) -> None:
        """Look after all vehicles; called every tenth of a second or so."""
        self.now_us = t_us
        risen, landed = self.legs.touching(t_us)
        for i in risen:
            self.status.landed[i] = False
            self.status.flown[i] = True
            self._rise(i)
        for i in landed:
            self.status.landed[i] = True
            self.status.landed_us[i] = t_us
            self._touch_down(i)
            if self.status.mode[i] == Mode.MISSION and self.legs.kind[i] == DESCEND:
                self._resume(i)
        self.failsafes.check(t_us)
        self._disarm_late(t_us)
        for i in self.legs.fly(t_us):
            self._resume(i)

    def _watch(self) -> Failsafes:
        return Failsafes(self)

    def _rise(self, i: int) -> None:
        self.say(i, _INFO, "Takeoff detected")

    def _touch_down(self, i: int) -> None:
        self.say(i, _INFO, "Landing detected")

    def _disarm_late(self, t_us: int) -> None:
        """Disarm those that have landed, or were armed and never took off."""
        status = self.status
        idle = status.armed & status.landed
        if not idle.any():
            return
        column = self.parameters.column
        wait_s = np.where(status.flown, column("COM_DISARM_LAND"), column("COM_DISARM_PRFLT"))
        since = np.where(status.flown, status.landed_us, status.armed_us)
        idle &= (wait_s > 0) & (t_us - since >= wait_s * 1e6)
        for i in idle.nonzero()[0].tolist():
            flown = bool(status.flown[i])
            self.stop_motors(i, "Disarmed by landing" if flown else "Disarmed by auto preflight")

    def _resume(self, i: int) -> None:
        routine = self._routines[i]
        if routine is not None and next(routine, self) is self and self._routines[i] is routine:
            self._routines[i] = None

    # -- requests --------------------------------------------------------------------

    def arm(self, i: int, *, force: bool = False) -> Refusal | None:
        """Start the motors; None: done. ``force`` skips the checks."""
        if self.status.armed[i]:
            return None
        reason = None if force else self.why_not_arm(i)
        if reason is not None:
            return Refusal(f"Arming denied: {reason}")
        self.status.home[i] = self.states.position[i]
        self.status.home_yaw[i] = self.states.yaw[i]
        self.status.flown[i] = False
        self.say(i, _INFO, "Armed by external command")
        self._set_armed(i)
        return None

    def _set_armed(self, i: int) -> None:
        self.status.armed[i] = True
        self.status.armed_us[i] = self.now_us
        self.status.started[i] = False
        self.failsafes.disarmed(i)
        self.status.battery_level[i] = 0
        self.switch(i, Mode(int(self.status.mode[i])))

    def disarm(self, i: int, *, force: bool = False) -> Refusal | None:
        """Stop the motors: on the ground, or anywhere with ``force``."""
        if not self.status.armed[i]:
            return None
        if not force and not self.status.landed[i]:
            return Refusal("Disarming denied: not landed")
        self.stop_motors(i, "Disarmed by external command")
        return None

    def stop_motors(self, i: int, text: str) -> None:
        """Disarm, wherever the vehicle is; the mode goes back to what it was."""
        status = self.status
        status.armed[i] = False
        self.failsafes.disarmed(i)
        self.legs.rest(i)
        self.legs.set_speed(i, nan)
        self._routines[i] = None
        if not status.landed[i]:
            status.landed[i] = True
            status.landed_us[i] = self.now_us
        if self.modes[Mode(int(status.mode[i]))].passing:
            status.mode[i] = status.before[i]
        if self.plans[i].finished:
            self.plans[i].current, self.plans[i].finished = 0, False
        self.say(i, _INFO, text)

    def restart(self, i: int) -> Refusal | None:
        """Switch off and on again; the position estimate takes its time."""
        if self.status.armed[i]:
            return Refusal("Reboot denied: armed")
        self.status.ready_us[i] = self.now_us + max(
            self._start_up_us[i], round(self.craft.ready_s[0] * 1e6)
        )
        self.status.setpoint_us[i] = self.status.gcs_us[i] = NEVER
        self.switch(i, self.craft.start_mode)
        return None

    def fail_gps(self, i: int, *, lost: bool) -> None:
        """The receiver fails, or works again; the position estimate goes with it."""
        self.status.gps_lost[i] = lost
        self.status.ready_us[i] = ALWAYS_LATER if lost else self.now_us

    def change_mode(self, i: int, mode: Mode) -> Refusal | None:
        """Someone asks for a mode; None: it is on."""
        reason = why_not_change(self, i, mode)
        if reason is not None:
            return Refusal(f"Switching to {self.modes[mode].name} denied: {reason}")
        self.failsafes.clear(i)
        if self.status.mode[i] != mode:
            self.switch(i, mode)
        return None

    def switch(self, i: int, mode: Mode) -> None:
        """Go to a mode without asking."""
        status = self.status
        status.mode[i] = mode
        if mode is not Mode.TAKEOFF:
            self._heights.pop(i, None)
        if not self.modes[mode].passing:
            status.before[i] = Mode.HOLD if mode is Mode.TAKEOFF else mode
        if not status.armed[i]:
            return
        self.legs.set_speed(i, nan)
        make = self.craft.routines.get(mode)
        self._routines[i] = None if make is None else make(self, i)
        if make is None:
            self._stay_until_told(i)
        else:
            self._resume(i)

    def _stay_until_told(self, i: int) -> None:
        """Offboard starts where the vehicle is, or with the setpoint it already has."""
        early = self._early.pop(i, None)
        if early is not None and self.has_setpoints(i):
            self.legs.start_following(i, early)
        else:
            place = stopping_place(self, i)
            self.legs.start_following(i, (*place, nan, nan, nan, self.yaw(i), nan))

    def take_off(self, i: int, height_m: float = nan) -> Refusal | None:
        """Climb to ``height_m`` (ENU m; NaN: the parameter's above home) once armed."""
        reason = why_not_change(self, i, Mode.TAKEOFF)
        if reason is not None:
            return Refusal(f"Takeoff denied: {reason}")
        self.failsafes.clear(i)
        self._heights[i] = height_m
        self.switch(i, Mode.TAKEOFF)
        return None

    def why_not_arm(self, i: int) -> str | None:
        """The first check that fails, in a few words; None: it may arm."""
        return why_not_arm(self, i)

    def may_start(self, i: int) -> bool:
        """Whether a mission may leave the ground."""
        return True

    def has_home(self, i: int) -> bool:
        """Whether it knows where its home is."""
        return True

    def start_mission(self, i: int) -> Refusal | None:
        """Fly the mission from its current step on."""
        return self.change_mode(i, Mode.MISSION)

    def pause(self, i: int, *, go_on: bool) -> Refusal | None:
        """Interrupt the mission, or go on with it."""
        return self.change_mode(i, Mode.MISSION if go_on else Mode.HOLD)

    def reposition(
        self, i: int, position: Vector, yaw_rad: float, *, may_change: bool = True
    ) -> Refusal | None:
        """Hold at another place; NaN parts stay as they are.

        Without ``may_change`` only in the mode that it ends in.
        """
        if not may_change and self.status.mode[i] != Mode.HOLD:
            return Refusal("", for_good=True)
        if not self.status.armed[i] or (self.status.landed[i] and not self.legs.grounded):
            return Refusal("Reposition denied: not in the air")
        reason = why_not_change(self, i, Mode.HOLD)
        if reason is not None:
            return Refusal(f"Reposition denied: {reason}")
        self.failsafes.clear(i)
        self.hold_at(i, position, yaw_rad)
        return None

    def follow(self, i: int, asked: Asked) -> None:
        """A setpoint, flown in Offboard mode."""
        self.status.setpoint_us[i] = self.now_us
        if i in self.legs.followers:
            self.legs.follow(i, asked)
        else:
            self._early[i] = asked

    def tilt(self, i: int, asked: Tilt) -> None:
        """An attitude setpoint: aircraft's, passed over by others."""

    def load(self, i: int, steps: tuple[Step, ...]) -> None:
        """A new mission; one that is being flown begins anew."""
        self.plans[i] = Plan(steps)
        if self.status.mode[i] == Mode.MISSION:
            self.switch(i, Mode.MISSION if steps else Mode.HOLD)

    def set_current(self, i: int, step: int) -> None:
        """Go on with the mission from a step (of it)."""
        plan = self.plans[i]
        plan.current, plan.finished = step, False
        if self.status.mode[i] == Mode.MISSION:
            self.switch(i, Mode.MISSION)

    def heard_gcs(self, i: int) -> None:
        """A ground station's heartbeat came."""
        self.status.gcs_us[i] = self.now_us
        if self.status.gcs_lost[i]:
            self.failsafes.heard_gcs(i)

    def say(self, i: int, severity: int, text: str) -> None:
        """Tell people something."""
        self.status.told.append(Said(i, severity, text))

    def told(self) -> list[Told]:
        """What was told since the last call."""
        told, self.status.told = self.status.told, []
        return told

    # -- what routines ask -----------------------------------------------------------

    def place(self, i: int) -> Vector:
        """Position, ENU m."""
        x, y, z = self.states.position[i].tolist()
        return x, y, z

    def yaw(self, i: int) -> float:
        """Yaw, rad."""
        return float(self.states.yaw[i])

    def altitude(self, z: float) -> float:
        """Height above sea level of ENU ``z``, about."""
        return self._altitude_m + z

    def charge(self, i: int) -> float:
        """Battery charge, 0..1."""
        return float(self.states.battery[i])

    def has_setpoints(self, i: int) -> bool:
        """Whether setpoints come."""
        limit_us = self.parameters.get(i, "COM_OF_LOSS_T") * 1e6
        return bool(self.now_us - self.status.setpoint_us[i] <= limit_us)

    def hold_at(self, i: int, position: Vector, yaw_rad: float) -> None:
        """Switch to Hold, at a place (NaN: where it is)."""
        self._goals[i] = (position, yaw_rad)
        self.switch(i, Mode.HOLD)

    def take_goal(self, i: int) -> tuple[Vector, float] | None:
        """Where a reposition command wants it, once."""
        return self._goals.pop(i, None)

    def take_asked_height(self, i: int) -> float:
        """The height (ENU m) that a take-off command named, once; else NaN."""
        return self._heights.pop(i, nan)
