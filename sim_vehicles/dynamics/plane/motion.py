"""Six degrees of freedom: forces, moments and the equations of motion, all vehicles at once.

Beard and McLain 2012, Eqs. (3.14)-(3.17), (4.6)-(4.20). Axes of the body are forward, right, down;
position and velocity are ENU, roll is right wing down, pitch nose up, yaw from east
counter-clockwise.
"""

from __future__ import annotations

import numpy as np

from sim_vehicles.dynamics.airframe import GRAVITY
from sim_vehicles.dynamics.model import F64
from sim_vehicles.dynamics.plane.airframe import PlaneParams

POSITION, VELOCITY = slice(0, 3), slice(3, 6)
ROLL, PITCH, YAW = 6, 7, 8
RATES = slice(9, 12)
SIZE = 12
ELEVATOR, AILERON, RUDDER, THRUST = range(4)
_STEEPEST = 1.5  # rad of pitch: Euler angles end at the vertical
_LEAST_M_S = 1.0  # airspeed below which its coefficients are kept


class Motion:
    """The equations of motion of one airframe.

    A state is (12, n): position and velocity (ENU), roll, pitch, yaw, body rates. Controls are
    (4, n): elevator, aileron, rudder (rad), thrust (N).
    """

    def __init__(self, params: PlaneParams) -> None:
        self._params = p = params
        gamma = p.jx * p.jz - p.jxz**2
        self._g = (
            p.jxz * (p.jx - p.jy + p.jz) / gamma,
            (p.jz * (p.jz - p.jy) + p.jxz**2) / gamma,
            p.jz / gamma,
            p.jxz / gamma,
            (p.jz - p.jx) / p.jy,
            p.jxz / p.jy,
            ((p.jx - p.jy) * p.jx + p.jxz**2) / gamma,
            p.jx / gamma,
        )

    def step(self, state: F64, controls: F64, wind: F64, dt_s: float) -> F64:
        """The state (12, n) after ``dt_s``, by Runge-Kutta of fourth order.

        Args:
            state: (12, n).
            controls: (4, n), held meanwhile.
            wind: (3, n) ENU m/s, held.
            dt_s: up to 0.02 s; the roll of the airframe is as fast as 0.02 s at full speed.
        """
        first = self.rates(state, controls, wind)
        second = self.rates(state + 0.5 * dt_s * first, controls, wind)
        third = self.rates(state + 0.5 * dt_s * second, controls, wind)
        fourth = self.rates(state + dt_s * third, controls, wind)
        out = state + (dt_s / 6.0) * (first + 2.0 * (second + third) + fourth)
        np.clip(out[PITCH], -_STEEPEST, _STEEPEST, out=out[PITCH])
        return out

    def rates(self, state: F64, controls: F64, wind: F64) -> F64:
        """Derivatives (12, n)."""
        roll, pitch, yaw = state[ROLL : YAW + 1]
        forward, right, down = body_axes(roll, pitch, yaw)
        air = state[VELOCITY] - wind
        u, v, w = (_dot(axis, air) for axis in (forward, right, down))
        force, moment = self._air(u, v, w, state[RATES], controls)
        out = np.empty_like(state)
        out[POSITION] = state[VELOCITY]
        push = (force[0] * forward + force[1] * right + force[2] * down) / self._params.mass
        push[2] -= GRAVITY
        out[VELOCITY] = push
        p, q, r = state[RATES]
        sin, cos = np.sin(roll), np.cos(roll)
        turn = (q * sin + r * cos) / np.cos(pitch)
        out[ROLL] = p + turn * np.sin(pitch)
        out[PITCH] = q * cos - r * sin
        out[YAW] = -turn
        g = self._g
        out[9] = g[0] * p * q - g[1] * q * r + g[2] * moment[0] + g[3] * moment[2]
        out[10] = g[4] * p * r - g[5] * (p * p - r * r) + moment[1] / self._params.jy
        out[11] = g[6] * p * q - g[0] * q * r + g[3] * moment[0] + g[7] * moment[2]
        return out

    def _air(
        self, u: F64, v: F64, w: F64, spin: F64, controls: F64
    ) -> tuple[tuple[F64, F64, F64], tuple[F64, F64, F64]]:
        """Forces (N) and moments (N m) of air and propeller about the body's axes."""
        k = self._params
        speed = np.maximum(np.sqrt(u * u + v * v + w * w), _LEAST_M_S)
        attack = np.arctan2(w, u)
        slip = np.arcsin(np.clip(v / speed, -1.0, 1.0))
        pressure = 0.5 * k.air * k.area * speed * speed
        p, q, r = spin[0], spin[1], spin[2]
        elevator, aileron, rudder, thrust = controls
        wide, deep = k.span / (2.0 * speed), k.chord / (2.0 * speed)
        wing = k.lift_0 + k.lift_a * attack
        stalled = self._stalled(attack)
        sin, cos = np.sin(attack), np.cos(attack)
        flat = 2.0 * np.sign(attack) * sin * sin * cos
        lift = pressure * ((1.0 - stalled) * wing + stalled * flat + k.lift_e * elevator)
        plate = 2.0 * np.abs(sin * sin * sin)  # a stalled wing is a flat plate: no parabola goes on
        drag = pressure * (k.drag_p + (1.0 - stalled) * k.induced * wing * wing + stalled * plate)
        side = pressure * (k.side_b * slip + k.side_r * rudder)
        force = (thrust - drag * cos + lift * sin, side, -drag * sin - lift * cos)
        roll = k.roll_b * slip + wide * (k.roll_p * p + k.roll_r * r)
        roll = roll + k.roll_aileron * aileron + k.roll_rudder * rudder
        pitch = k.pitch_0 + k.pitch_a * attack + k.pitch_q * deep * q + k.pitch_e * elevator
        yaw = k.yaw_b * slip + wide * (k.yaw_p * p + k.yaw_r * r)
        yaw = yaw + k.yaw_aileron * aileron + k.yaw_rudder * rudder
        return force, (
            pressure * k.span * roll,
            pressure * k.chord * pitch,
            pressure * k.span * yaw,
        )

    def _stalled(self, attack: F64) -> F64:
        """The book's blend (4.10): 0 in attached flow, 1 when stalled, as two logistic curves."""
        k = self._params
        over = np.clip(k.stall_m * (np.abs(attack) - k.stall_rad), -60.0, 60.0)
        return np.asarray(1.0 / (1.0 + np.exp(-over)))


def body_axes(roll: F64, pitch: F64, yaw: F64) -> tuple[F64, F64, F64]:
    """Forward, right and down of the body: (3, n) each, ENU."""
    sr, cr = np.sin(roll), np.cos(roll)
    sp, cp = np.sin(pitch), np.cos(pitch)
    sy, cy = np.sin(yaw), np.cos(yaw)
    forward = np.stack((cp * cy, cp * sy, sp))
    right = np.stack((cr * sy + sr * sp * cy, sr * sp * sy - cr * cy, -sr * cp))
    down = np.stack((cr * sp * cy - sr * sy, cr * sp * sy + sr * cy, -cr * cp))
    return forward, right, down


def _dot(a: F64, b: F64) -> F64:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
