"""Legs of flight: what every vehicle is asked for now, all vehicles at once.

An autopilot starts a leg when something happens; between events nothing here runs per
vehicle. Vehicles on the ground are held there until their leg leads up and the motors have
spun up; then the permitted climb grows along a ramp, as PX4's does.
"""

from __future__ import annotations

from math import nan
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from sim_vehicles.dynamics.model import F64, Bools, Setpoints, States
from sim_vehicles.params import Parameters
from sim_vehicles.plans import Vector
from sim_vehicles.status import ALWAYS_LATER, I8, I64, NEVER, Status

RAMP_FROM: Final = -2.45  # m/s: the climb rate at which a PX4 quadrotor's thrust is zero
PRESS_DOWN: Final = -0.5  # m/s asked for on the ground
UP: Final = 0.1  # m or m/s above which a setpoint leads up


# How a leg is flown. Plain numbers: members of an Enum are slow to look up.
REST: Final = 0  # on the ground, motors off
GO: Final = 1  # to a place, and stay
DESCEND: Final = 2  # over a place, to the ground
FOLLOW: Final = 3  # setpoints from outside

# Stages from the ground to the air.
_GROUND: Final = 0
_RAMP: Final = 1
FLIGHT: Final = 2

Asked: TypeAlias = tuple[float, float, float, float, float, float, float, float]
"""Position, velocity (ENU), yaw, yaw rate of a setpoint; NaN: not controlled."""


class Tilt(NamedTuple):
    """An attitude asked for, in place of a way to go; NaN: not controlled."""

    roll: float = nan  # rad, right wing down
    pitch: float = nan  # rad, nose up
    throttle: float = nan  # 0..1
    roll_rate: float = nan  # rad/s, where there is no roll
    pitch_rate: float = nan


class Legs:
    """The legs of n vehicles, and the setpoints they lead to.

    Attributes:
        setpoints: what the vehicle model is asked for.
        followers: vehicles that follow setpoints.
        due_us: (n,) when a vehicle's pause ends; ``ALWAYS_LATER``: it has none.
        grounded: these vehicles never fly.
    """

    grounded = False

    def __init__(self, status: Status, states: States, parameters: Parameters) -> None:
        n = len(status.mode)
        self._status, self._states, self._parameters = status, states, parameters
        self.kind: I8 = np.zeros(n, dtype=np.int8)
        self.gate: I8 = np.zeros(n, dtype=np.int8)
        self.due_us: I64 = np.full(n, ALWAYS_LATER, dtype=np.int64)
        self.setpoints = Setpoints.idle(n)
        self.followers: set[int] = set()
        self._newest: dict[int, Asked] = {}
        self._wanted = Setpoints.idle(n)
        self._watched: Bools = np.zeros(n, dtype=np.bool_)
        self._radius: F64 = np.ones(n)
        self._speed: F64 = np.full(n, nan)  # asked for in place of the parameter's
        self._ramp_us: I64 = np.zeros(n, dtype=np.int64)
        self._touch_us: I64 = np.full(n, NEVER, dtype=np.int64)  # on the ground since
        column = parameters.column
        self._cruise, self._max_speed = column("MPC_XY_CRUISE"), column("MPC_XY_VEL_MAX")
        self._auto_up, self._auto_down = column("MPC_Z_V_AUTO_UP"), column("MPC_Z_V_AUTO_DN")
        self._max_up, self._max_down = column("MPC_Z_VEL_MAX_UP"), column("MPC_Z_VEL_MAX_DN")
        self._climb = column("MPC_TKO_SPEED")
        self._height = column("NAV_MC_ALT_RAD")  # m: accepted difference on arrival
        self._climbing: Bools = np.zeros(n, dtype=np.bool_)  # takes off: slower
        self._changed = True
        self._version = -1

    # -- starting legs ------------------------------------------------------------

    def rest(self, i: int) -> None:
        """Motors off (on the ground, or it falls)."""
        self._begin(i, REST)
        wanted = self._wanted
        wanted.motors[i] = False
        wanted.position[i] = nan
        wanted.velocity[i] = nan
        self.gate[i] = _GROUND

    def go(
        self,
        i: int,
        position: Vector,
        yaw_rad: float,
        *,
        radius_m: float | None = None,
        climb: bool = False,
    ) -> None:
        """Fly to a place and stay there.

        Args:
            i: the vehicle.
            position: ENU m.
            yaw_rad: to be held.
            radius_m: horizontal distance at which it has arrived; None: nobody waits for it.
            climb: it is the climb of a take-off, flown slower.
        """
        self._begin(i, GO)
        wanted = self._wanted
        wanted.motors[i] = True
        wanted.position[i] = position
        wanted.velocity[i] = nan
        wanted.yaw[i] = yaw_rad
        wanted.yaw_rate[i] = nan
        self._climbing[i] = climb
        if radius_m is not None:
            self._watched[i] = True
            self._radius[i] = radius_m

    def descend(self, i: int, x: float, y: float, yaw_rad: float) -> None:
        """Go down over a place until something stops it."""
        self.go(i, (x, y, nan), yaw_rad)
        self.kind[i] = DESCEND

    def start_following(self, i: int, asked: Asked) -> None:
        """Do as setpoints say, from this one on."""
        self._begin(i, FOLLOW)
        self._wanted.motors[i] = True
        self._wanted.yaw[i] = self._states.yaw[i]
        self.followers.add(i)
        self._newest[i] = asked

    def follow(self, i: int, asked: Asked) -> None:
        """The newest setpoint of a follower; it counts from the next ``heed`` on."""
        self._newest[i] = asked

    def heed(self) -> None:
        """Take in the setpoints that came, no faster than the parameters permit."""
        if not self._newest:
            return
        rows = np.fromiter(self._newest, np.int64, len(self._newest))
        asked = np.array(list(self._newest.values()))
        self._newest.clear()
        position, velocity, yaw, rate = asked[:, :3], asked[:, 3:6], asked[:, 6], asked[:, 7]
        fastest = self._max_speed[rows]
        speed = np.sqrt(np.nansum(velocity[:, :2] ** 2, axis=1))
        velocity[:, :2] *= (fastest / np.maximum(np.maximum(speed, fastest), 1e-9))[:, np.newaxis]
        np.maximum(velocity[:, 2], -self._max_down[rows], out=velocity[:, 2])
        np.minimum(velocity[:, 2], self._max_up[rows], out=velocity[:, 2])
        free = np.isnan(yaw) & np.isnan(rate)  # no word of yaw: keep it
        if free.any():
            before = self._wanted.yaw[rows]
            kept = np.where(np.isnan(before), self._states.yaw[rows], before)
            yaw[free] = kept[free]
        flying = self.gate[rows] == FLIGHT
        for setpoints, which in ((self._wanted, slice(None)), (self.setpoints, flying)):
            here = rows[which]
            setpoints.position[here] = position[which]
            setpoints.velocity[here] = velocity[which]
            setpoints.yaw[here] = yaw[which]
            setpoints.yaw_rate[here] = rate[which]

    def tilt(self, i: int, asked: Tilt, position: Vector | None = None) -> None:
        """Do as an attitude says, of those that take one; to a position where it says nothing."""

    def has_place(self, i: int) -> bool:
        """Whether the leg leads to a place to stay at."""
        return bool(self.kind[i] == GO)

    def pause(self, i: int, until_us: int) -> None:
        """Wake the vehicle's routine at a time, wherever it is."""
        self.due_us[i] = until_us
        self._watched[i] = False

    def set_speed(self, i: int, speed_m_s: float) -> None:
        """Cruise at another speed than the parameter's; NaN: the parameter's again."""
        self._speed[i] = speed_m_s
        self._changed = True

    def turn(self, i: int, yaw_rad: float) -> None:
        """Look another way, wherever the leg leads to."""
        self._wanted.yaw[i] = yaw_rad
        self._wanted.yaw_rate[i] = nan
        if i in self._newest:
            self._newest[i] = (*self._newest[i][:6], yaw_rad, nan)

    def set_circle(self, i: int, radius_m: float) -> None:
        """Radius of loiters, positive counter-clockwise; NaN: the usual. Of those that loiter."""

    def in_flight(self, i: int) -> None:
        """The vehicle starts in the air."""
        self.gate[i] = FLIGHT

    def _begin(self, i: int, kind: int) -> None:
        self.kind[i] = kind
        self.followers.discard(i)
        self._newest.pop(i, None)
        self._watched[i] = False
        self._climbing[i] = False
        self.due_us[i] = ALWAYS_LATER
        self._changed = True

    # -- flying them --------------------------------------------------------------

    def fly(self, t_us: int) -> list[int]:
        """Bring the setpoints up to date; tells whose leg, or pause, is done."""
        self.heed()
        if self._changed or self._parameters.version != self._version:
            self._limit()
        if (self.kind == DESCEND).any():
            self._slow_down()
        self._apply(t_us)
        done = self.due_us <= t_us
        if self._watched.any():
            away = self._states.position - self._wanted.position
            away *= away
            near = away[:, 0] + away[:, 1] <= self._radius * self._radius
            near &= away[:, 2] <= self._height * self._height
            done |= self._watched & near
        woken: list[int] = done.nonzero()[0].tolist()
        self._watched[woken] = False
        self.due_us[woken] = ALWAYS_LATER
        return woken

    def touching(self, t_us: int) -> tuple[list[int], list[int]]:
        """Land detector: who has landed, who has left the ground, since the last call."""
        ground = self._states.on_ground
        landed = self._status.landed
        off = landed & ~ground & (self.gate != _GROUND)
        down = ~landed & ground
        if not down.any():
            self._touch_us.fill(NEVER)
            return (off.nonzero()[0].tolist() if off.any() else []), []
        down &= ~self._leads_up()
        fresh = down & (self._touch_us == NEVER)
        self._touch_us[fresh] = t_us
        self._touch_us[~down] = NEVER
        trigger_us = self._parameters.column("LNDMC_TRIG_TIME") * 1e6
        down &= t_us - self._touch_us >= trigger_us
        self.gate[down] = _GROUND
        self._touch_us[down] = NEVER
        return off.nonzero()[0].tolist(), down.nonzero()[0].tolist()

    def _leads_up(self) -> Bools:
        wanted = self._wanted
        above = wanted.position[:, 2] - self._states.position[:, 2]
        up: Bools = np.where(np.isnan(above), wanted.velocity[:, 2], above) > UP
        return up

    def _limit(self) -> None:
        """Speed limits of all legs, from parameters and orders."""
        wanted = self._wanted
        follow = self.kind == FOLLOW
        cruise = np.where(np.isnan(self._speed), self._cruise, self._speed)
        up = np.where(self._climbing, self._climb, self._auto_up)
        np.minimum(np.where(follow, np.inf, cruise), self._max_speed, out=wanted.max_speed)
        np.minimum(np.where(follow, np.inf, up), self._max_up, out=wanted.max_up)
        np.minimum(np.where(follow, np.inf, self._auto_down), self._max_down, out=wanted.max_down)
        self._changed = False
        self._version = self._parameters.version

    def _slow_down(self) -> None:
        """Descent slows between two heights (MPC_LAND_ALT1, 2) to the landing speed."""
        rows = (self.kind == DESCEND).nonzero()[0]
        column = self._parameters.column
        height = self._states.position[rows, 2] - self._states.ground[rows]
        high, low = column("MPC_LAND_ALT1")[rows], column("MPC_LAND_ALT2")[rows]
        slow, fast = column("MPC_LAND_SPEED")[rows], self._wanted.max_down[rows]
        share = np.clip((height - low) / np.maximum(high - low, 0.1), 0.0, 1.0)
        self._wanted.velocity[rows, 2] = -(slow + share * np.maximum(fast - slow, 0.0))

    def _apply(self, t_us: int) -> None:
        wanted, out = self._wanted, self.setpoints
        out.position[:] = wanted.position
        out.velocity[:] = wanted.velocity
        out.yaw[:] = wanted.yaw
        out.yaw_rate[:] = wanted.yaw_rate
        out.max_speed[:] = wanted.max_speed
        out.max_up[:] = wanted.max_up
        out.max_down[:] = wanted.max_down
        out.motors[:] = wanted.motors
        if (self.gate != FLIGHT).any():
            self._hold_down(t_us)

    def _hold_down(self, t_us: int) -> None:
        """Vehicles not yet in flight: on the ground, or on the ramp."""
        column = self._parameters.column
        spun = t_us - self._status.armed_us >= column("COM_SPOOLUP_TIME") * 1e6
        begin = (self.gate == _GROUND) & self._status.armed & spun & self._leads_up()
        if begin.any():
            self.gate[begin] = _RAMP
            self._ramp_us[begin] = t_us
        out = self.setpoints
        ramp_s = np.maximum(column("MPC_TKO_RAMP_T"), 1e-3)
        share = (t_us - self._ramp_us) * 1e-6 / ramp_s
        ramping = self.gate == _RAMP
        self.gate[ramping & (share >= 1.0)] = FLIGHT
        permitted = RAMP_FROM + (self._climb - RAMP_FROM) * np.minimum(share, 1.0)
        lifting = ramping & (permitted > UP)
        np.minimum(out.max_up, permitted, out=out.max_up, where=lifting)
        np.minimum(out.velocity[:, 2], permitted, out=out.velocity[:, 2], where=lifting)
        held = (self.gate != FLIGHT) & ~lifting & out.motors
        out.position[held] = nan
        out.velocity[held] = (0.0, 0.0, PRESS_DOWN)
        out.yaw[held] = self._states.yaw[held]
        out.yaw_rate[held] = nan
