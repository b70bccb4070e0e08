"""Inner loops: from bank, climb angle and airspeed to the control surfaces and the throttle.

Beard and McLain 2012, chapter 6: roll by the ailerons, pitch by the elevator, airspeed by the
throttle, yaw damping by the rudder, closed one about the other. Poles are placed at every airspeed
anew, so the pitch loop keeps the sign that the book's fixed gains lose above 50 m/s; what holds
trim is fed forward, integrals take the rest.
"""

from __future__ import annotations

import numpy as np

from sim_vehicles.dynamics.airframe import GRAVITY
from sim_vehicles.dynamics.model import F64, Bools
from sim_vehicles.dynamics.plane.airframe import PlaneParams
from sim_vehicles.dynamics.plane.guide import Wanted

ROLL_RAD_S = 9.0
PITCH_RAD_S = 8.0
_DAMPING = 0.9
_PITCH_INTEGRAL = 1.5  # 1/s
_CLIMB_GAIN = 0.6
_CLIMB_INTEGRAL = 0.3  # 1/s
_SPEED_GAIN = 0.9  # 1/s
_SPEED_INTEGRAL = 0.1  # 1/s2
_YAW_DAMPING = 0.1  # s
_BEND_M_S2 = 8.0  # vertical acceleration asked for
_SPIN_RAD_S = 1.5  # fastest roll asked for
_LEAST_M_S = 12.0  # below it the surfaces hardly work: gains stay


class Loops:
    """The inner loops of n aircraft; integrals and a slowed wish are their state."""

    def __init__(self, params: PlaneParams, n: int) -> None:
        self._params = p = params
        self._pitch = np.zeros(n)
        self._climb = np.zeros(n)
        self._speed = np.zeros(n)
        self._path = np.zeros(n)  # flight path angle asked for, without jumps
        gamma = p.jx * p.jz - p.jxz**2
        self._roll_p = (p.jz * p.roll_p + p.jxz * p.yaw_p) / gamma
        self._roll_a = (p.jz * p.roll_aileron + p.jxz * p.yaw_aileron) / gamma

    def rest(self, idle: Bools) -> None:
        """Start anew where ``idle`` (n,)."""
        for part in (self._pitch, self._climb, self._speed, self._path):
            part[idle] = 0.0

    def controls(self, wanted: Wanted, state: F64, air: F64, climb: F64, dt_s: float) -> F64:
        """Elevator, aileron, rudder (rad) and thrust (N), (4, n).

        Args:
            wanted: of the guide.
            state: (12, n) of ``Motion``.
            air: (n,) airspeed, m/s.
            climb: (n,) flight path angle against the air, rad.
            dt_s: until the next call.
        """
        k = self._params
        speed = np.maximum(air, _LEAST_M_S)
        roll, pitch = state[6], state[7]
        p, q, r = state[9:12]
        pressure = 0.5 * k.air * k.area * speed**2
        sin, cos = np.sin(roll), np.maximum(np.cos(roll), 0.3)

        bend = GRAVITY / speed  # rad/s of a level turn, per tan of the bank
        turning = bend * sin * np.tan(np.clip(roll, -1.2, 1.2))
        bends = _BEND_M_S2 * dt_s / speed
        tilted = np.isfinite(wanted.pitch)
        self._path += np.clip(np.where(tilted, climb, wanted.climb) - self._path, -bends, bends)
        path = self._path
        load = GRAVITY * np.cos(path) / cos
        attack, trimmed, drag = k.trim(speed, load, turning)
        attack = np.minimum(attack, k.limits.attack_rad)
        off = np.where(tilted, 0.0, path - climb)
        self._climb = np.clip(self._climb + _CLIMB_INTEGRAL * dt_s * off, -0.1, 0.1)
        lead = np.clip(_CLIMB_GAIN * off, -0.3, 0.3) + self._climb
        aim = path + attack * cos + lead
        aim = np.where(tilted, np.minimum(wanted.pitch, wanted.climb + attack * cos), aim)
        aim = np.minimum(aim, climb + k.limits.attack_rad * cos)

        per_elevator = pressure * k.chord * k.pitch_e / k.jy
        stiff = -pressure * k.chord * k.pitch_a / k.jy
        damp = -pressure * k.chord**2 * k.pitch_q / (2.0 * speed * k.jy)
        error = aim - pitch
        self._pitch = np.clip(self._pitch + _PITCH_INTEGRAL * dt_s * error, -0.3, 0.3)
        quick = PITCH_RAD_S**2
        whole = 2.0 * _DAMPING * np.sqrt(quick + stiff)
        push = quick * (error + self._pitch) - (whole - damp) * (q - turning)
        elevator = trimmed + push / per_elevator

        per_aileron = pressure * k.span * self._roll_a
        roll_damp = -pressure * k.span**2 * self._roll_p / (2.0 * speed)
        spin = 0.5 * ROLL_RAD_S / _DAMPING * (wanted.roll - roll)
        spin = np.clip(spin, -_SPIN_RAD_S, _SPIN_RAD_S)
        aileron = (2.0 * _DAMPING * ROLL_RAD_S * (spin - p) + roll_damp * p) / per_aileron
        rudder = _YAW_DAMPING * (r - bend * sin * np.cos(pitch))
        most = k.deflection_rad
        surfaces = np.clip(np.stack((elevator, aileron, rudder)), -most, most)
        return np.concatenate((surfaces, self._push(wanted, air, climb, drag, dt_s)[np.newaxis]))

    def _push(self, wanted: Wanted, air: F64, climb: F64, drag: F64, dt_s: float) -> F64:
        """Thrust (n,) N."""
        k = self._params
        error = wanted.airspeed - air
        calm = np.abs(error) < 3.0
        self._speed += np.where(calm, _SPEED_INTEGRAL * dt_s * error, 0.0)
        np.clip(self._speed, -2.0, 2.0, out=self._speed)
        faster = _SPEED_GAIN * error + self._speed
        faster = np.clip(faster, -k.limits.slower_m_s2, k.limits.faster_m_s2)
        force = k.mass * (faster + GRAVITY * np.sin(climb)) + drag
        driven = np.isfinite(wanted.throttle)
        asked = np.maximum(k.thrust(wanted.throttle, air), 0.0)  # folded where it would brake
        return np.where(driven, asked, k.thrust(k.throttle(force, air), air))
