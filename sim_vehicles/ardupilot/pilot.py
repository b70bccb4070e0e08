"""ArduPilot: what it does otherwise than PX4, from arming to Guided."""

from __future__ import annotations

from math import atan2, hypot, isfinite, isnan, nan
from typing import Final

import numpy as np

from sim_vehicles.ardupilot.failsafe import ArduPilotFailsafes, RoverFailsafes
from sim_vehicles.arming import Refusal
from sim_vehicles.autopilot import Autopilot
from sim_vehicles.failsafe import Failsafes
from sim_vehicles.legs import Asked
from sim_vehicles.modes import Mode
from sim_vehicles.plans import Do, Vector
from sim_vehicles.routines import stay
from sim_vehicles.status import Reached, Shown

_INFO: Final = 6
_CRITICAL: Final = 2
_PREARM_US: Final = 30_000_000  # between two complaints
_GUIDED: Final = Mode.OFFBOARD
_AUTO: Final = Mode.MISSION
_ENDS: Final = (int(Mode.LAND), int(Mode.RETURN), int(_AUTO))  # modes that disarm on the ground
_MAY_ARM: Final = 1  # bits of AUTO_OPTIONS
_NO_THROTTLE: Final = 2
_SETTLED_S: Final = 1.0
_STOP: Final = (nan, nan, nan, 0.0, 0.0, 0.0, nan, nan)
_LIFTING: Final = (Mode.HOLD, Mode.POSITION, Mode.ALTITUDE, _GUIDED)  # take off by command


class ArduPilot(Autopilot):
    """ArduPilot's copters and rovers; sticks are where nobody touches them, centred."""

    def _watch(self) -> Failsafes:
        self._until_us: dict[int, int] = {}  # followers of a velocity, until
        self._targets: dict[int, Vector] = {}  # where rovers were sent
        self._homes: set[int] = set()  # who has told of its home
        self._without_gps: set[int] = set()
        self._version = -1
        return RoverFailsafes(self) if self._drives else ArduPilotFailsafes(self)

    @property
    def _drives(self) -> bool:
        return self.legs.grounded

    # -- what happens by itself --------------------------------------------------------

    def tick(self, t_us: int) -> None:
        if self.parameters.version != self._version:
            self._version = self.parameters.version
            self._switch_gps()
        super().tick(t_us)
        self._wake(t_us)
        for i in [i for i, until in self._until_us.items() if t_us > until]:
            del self._until_us[i]
            if i in self.legs.followers:
                self.legs.start_following(i, _STOP)
        for i, (x, y, _) in list(self._targets.items()):
            hx, hy, _ = self.place(i)
            if hypot(x - hx, y - hy) <= self._near_m(i):
                del self._targets[i]
                self.status.told.append(Reached(i, 0))

    def _switch_gps(self) -> None:
        """SIM_GPS_DISABLE was set, or set back."""
        off = set(self.parameters.column("SIM_GPS_DISABLE").nonzero()[0].tolist())
        for i in off ^ self._without_gps:
            self.fail_gps(i, lost=i in off)
        self._without_gps = off

    def _near_m(self, i: int) -> float:
        """How near to its target it has arrived."""
        return self.parameters.get(i, "NAV_ACC_RAD")

    def _wake(self, t_us: int) -> None:
        """Tell of the estimate, once it is there, or that it is not."""
        if len(self._homes) == len(self.plans):
            return
        for i, ready_us in enumerate(self.status.ready_us.tolist()):
            if i not in self._homes and t_us >= ready_us:
                self._homes.add(i)
                self.say(i, _INFO, "EKF3 IMU0 is using GPS")
                self._show_home(i)
            elif t_us < ready_us and t_us % _PREARM_US < 100_000 <= t_us:
                self.say(i, _CRITICAL, f"PreArm: {_NO_PLACE}")

    def _show_home(self, i: int) -> None:
        self.status.told.append(Shown(i, "GPS_GLOBAL_ORIGIN"))
        self.status.told.append(Shown(i, "HOME_POSITION"))

    def _rise(self, i: int) -> None:
        pass

    def _touch_down(self, i: int) -> None:
        pass

    def _disarm_late(self, t_us: int) -> None:
        status = self.status
        idle = status.armed & status.landed
        if self._drives or not idle.any():
            return
        ends = status.flown & np.isin(status.mode, _ENDS)
        wait_s = np.where(ends, _SETTLED_S, self.parameters.column("DISARM_DELAY"))
        since = np.where(status.flown, status.landed_us, status.armed_us)
        idle &= (wait_s > 0) & (t_us - since >= wait_s * 1e6)
        for i in idle.nonzero()[0].tolist():
            self.stop_motors(i, self._disarming)

    # -- arming ------------------------------------------------------------------------

    @property
    def _arming(self) -> str:
        return "Throttle armed" if self._drives else "Arming motors"

    @property
    def _disarming(self) -> str:
        return "Throttle disarmed" if self._drives else "Disarming motors"

    def why_not_arm(self, i: int) -> str | None:
        mode = Mode(int(self.status.mode[i]))
        spec = self.modes[mode]
        if not spec.armable or (mode is _AUTO and not self._may_arm_in_auto(i)):
            return "Mode not armable"
        checks = self.parameters.get(i, "ARMING_CHECK") != 0
        if (checks or spec.needs_position) and self.now_us < self.status.ready_us[i]:
            return _NO_PLACE
        if checks and self.charge(i) <= 0.0:
            return "Battery 1 unhealthy"
        return None

    def _may_arm_in_auto(self, i: int) -> bool:
        return self._drives or bool(int(self.parameters.get(i, "AUTO_OPTIONS")) & _MAY_ARM)

    def arm(self, i: int, *, force: bool = False) -> Refusal | None:
        if self.status.armed[i]:
            return None
        reason = None if force else self.why_not_arm(i)
        if reason is not None:
            return Refusal(f"Arm: {reason}")
        self.status.home[i] = self.states.position[i]
        self.status.home_yaw[i] = self.states.yaw[i]
        self.status.flown[i] = False
        self.say(i, _INFO, self._arming)
        if self.has_home(i):
            self._show_home(i)
        self._set_armed(i)
        return None

    def disarm(self, i: int, *, force: bool = False) -> Refusal | None:
        if not self.status.armed[i]:
            return None
        if not (force or self._drives or self.status.landed[i]):
            return Refusal("")
        self.stop_motors(i, self._disarming)
        return None

    def stop_motors(self, i: int, text: str) -> None:
        super().stop_motors(i, text)
        self._until_us.pop(i, None)
        self._targets.pop(i, None)

    def has_home(self, i: int) -> bool:
        return bool(self.now_us >= self.status.ready_us[i])

    # -- modes -------------------------------------------------------------------------

    def change_mode(self, i: int, mode: Mode) -> Refusal | None:
        reason = self._why_not_change(i, mode)
        if reason is not None:
            return Refusal(f"Mode change to {self.modes[mode].name} failed: {reason}")
        self.failsafes.clear(i)
        if self.status.mode[i] != mode:
            self.switch(i, mode)
        return None

    def _why_not_change(self, i: int, mode: Mode) -> str | None:
        steps = self.plans[i].steps
        if not self.status.armed[i]:
            return None
        if self.modes[mode].needs_position and self.now_us < self.status.ready_us[i]:
            return "requires position"
        if mode is _AUTO and len(steps) < 2:
            return "init failed"
        first = next((step.do for step in steps[1:] if step.do in _NAVIGATING), None)
        on_ground = self.status.landed[i] and not self._drives
        if mode is _AUTO and on_ground and first is not Do.TAKE_OFF:
            self.say(i, _CRITICAL, "Auto: Missing Takeoff Cmd")
            return "init failed"
        return None

    def switch(self, i: int, mode: Mode) -> None:
        self._until_us.pop(i, None)
        self._targets.pop(i, None)
        super().switch(i, mode)

    def take_off(self, i: int, height_m: float = nan) -> Refusal | None:
        """Climb to ``height_m`` (ENU m), in Guided and in modes that hold height."""
        if self._drives:
            return Refusal("", unsupported=True)
        status, (x, y, z) = self.status, self.place(i)
        lifting = self.status.mode[i] in _LIFTING
        if not (status.armed[i] and status.landed[i] and lifting and height_m > z):
            return Refusal("")
        self.legs.go(i, (x, y, height_m), self.yaw(i), climb=True)
        status.started[i] = True
        return None

    def start_mission(self, i: int) -> Refusal | None:
        refusal = self.change_mode(i, _AUTO)
        if refusal is None:
            self.status.started[i] = True
        return refusal

    def may_start(self, i: int) -> bool:
        """Whether a mission may leave the ground: it was told to, or needs no throttle."""
        options = int(self.parameters.get(i, "AUTO_OPTIONS"))
        return bool(self.status.started[i] or options & _NO_THROTTLE)

    def pause(self, i: int, *, go_on: bool) -> Refusal | None:
        mode = self.status.mode[i]
        if mode not in (_AUTO, _GUIDED) or not self.status.armed[i]:
            return Refusal("")
        if go_on and mode == _AUTO:
            self.switch(i, _AUTO)
        elif not go_on:
            self._routines[i] = None
            stay(self, i)
        return None

    # -- Guided ------------------------------------------------------------------------

    def reposition(
        self, i: int, position: Vector, yaw_rad: float, *, may_change: bool = True
    ) -> Refusal | None:
        if self.status.mode[i] != _GUIDED:
            if not may_change:
                return Refusal("", for_good=True)
            refusal = self.change_mode(i, _GUIDED)
            if refusal is not None:
                return refusal
        x, y, z = (
            there if isfinite(there) else here
            for there, here in zip(position, self.place(i), strict=True)
        )
        self.follow(i, (x, y, z, nan, nan, nan, yaw_rad, nan))
        return None

    def follow(self, i: int, asked: Asked) -> None:
        """A setpoint, followed in Guided only: a place for good, a velocity for GUID_TIMEOUT."""
        status = self.status
        if status.mode[i] != _GUIDED or not status.armed[i]:
            return
        if status.landed[i] and not self._drives:
            return
        status.setpoint_us[i] = self.now_us
        self._until_us.pop(i, None)
        self._targets.pop(i, None)
        if any(map(isfinite, asked[3:6])):
            timeout_s = 3.0 if self._drives else self.parameters.get(i, "GUID_TIMEOUT")
            self._until_us[i] = self.now_us + round(timeout_s * 1e6)
        elif self._drives:
            self._targets[i] = asked[:3]
        if isnan(asked[6]) and isnan(asked[7]):
            asked = (*asked[:6], self._towards(i, asked), nan)
        if i in self.legs.followers:
            self.legs.follow(i, asked)
        else:
            self.legs.start_following(i, asked)

    def _towards(self, i: int, asked: Asked) -> float:
        """Yaw where the setpoint says nothing of it: the way it goes (WP_YAW_BEHAVIOR)."""
        if self._drives or self.parameters.get(i, "WP_YAW_BEHAVIOR") == 0:
            return nan
        x, y, _ = self.place(i)
        east, north = asked[0] - x, asked[1] - y
        if not isfinite(east + north):
            east, north = asked[3], asked[4]
        return atan2(north, east) if hypot(east, north) > 0.5 else nan


_NO_PLACE: Final = "Need Position Estimate"
_NAVIGATING: Final = (Do.TAKE_OFF, Do.GO, Do.STAY, Do.CIRCLE, Do.LAND, Do.RETURN, Do.PAUSE)
