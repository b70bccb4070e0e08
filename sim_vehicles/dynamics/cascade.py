"""Position and velocity loops: from a demand to the force wanted."""

from __future__ import annotations

import numpy as np

from sim_vehicles.dynamics.airframe import GRAVITY, MultirotorParams
from sim_vehicles.dynamics.demand import Demand
from sim_vehicles.dynamics.model import F64, Bools, Setpoints

_TINY = 1e-12  # m: keeps 0 / 0 away


class Cascade:
    r"""Position P and velocity PI loops of all vehicles.

    A position error e asks for the speed

    .. math:: v(e) = \frac{2 k e}{1 + \sqrt{1 + 2 k^2 e / a}}

    which is k e near the target and brakes with less than a from any distance.
    A velocity reference follows with limited acceleration; the loop is closed on
    the reference, with its acceleration fed forward, so the integral holds little
    else than drag.
    """

    def __init__(self, n: int, params: MultirotorParams) -> None:
        self._params = params
        self._reference = np.zeros((3, n))
        self._integral = np.zeros((3, n))
        self._change = np.zeros((3, n))
        self._force = np.zeros((3, n))
        self._size = np.zeros((2, n))  # horizontal, vertical
        self._row = np.zeros(n)

        p = params
        self._curve = 2.0 * p.position_gain_1_s**2 / _pair(p.braking_m_s2, p.levelling_m_s2)
        self._slew = _pair(p.acceleration_m_s2, p.lift_m_s2)
        self._gain = _triple(p.velocity_gain_1_s, p.lift_gain_1_s)
        self._integral_gain = _triple(p.velocity_integral_1_s2, p.lift_integral_1_s2)
        most = (p.thrust_to_weight - 1.0) * GRAVITY
        self._most_integral = _triple(GRAVITY * np.tan(p.tilt_rad), 0.5 * most)
        self._tan_tilt = float(np.tan(p.tilt_rad))
        self._lightest = 0.2 * GRAVITY
        self._heaviest = GRAVITY + most

    def rest(self, idle: Bools, velocity: F64) -> None:
        """Start anew from ``velocity`` (3, n) where ``idle`` (n,)."""
        np.copyto(self._reference, velocity, where=idle)
        np.copyto(self._integral, 0.0, where=idle)

    def force(self, demand: Demand, setpoints: Setpoints, velocity: F64, dt_s: float) -> F64:
        """The force wanted: tan of the tilt east and north, lift per mass (3, n).

        The array is used again by the next call.
        """
        wanted = self._speed(demand, setpoints)
        return self._accelerate(wanted, velocity, dt_s)

    def _speed(self, demand: Demand, setpoints: Setpoints) -> F64:
        p, size, row, error = self._params, self._size, self._row, demand.error
        np.hypot(error[0], error[1], out=size[0])
        np.abs(error[2], out=size[1])
        size[0] += _TINY
        np.divide(setpoints.max_speed, size[0], out=row)
        size *= self._curve
        size += 1.0
        np.sqrt(size, out=size)
        size += 1.0
        np.divide(2.0 * p.position_gain_1_s, size, out=size)
        np.minimum(size[0], row, out=size[0])
        error[:2] *= size[0]
        error[2] *= size[1]
        np.minimum(error[2], setpoints.max_up, out=error[2])
        np.negative(setpoints.max_down, out=row)
        np.maximum(error[2], row, out=error[2])

        error += demand.velocity
        np.hypot(error[0], error[1], out=row)
        np.maximum(row, p.speed_m_s, out=row)
        np.divide(p.speed_m_s, row, out=row)
        error[:2] *= row
        np.minimum(error[2], p.climb_m_s, out=error[2])
        np.maximum(error[2], -p.sink_m_s, out=error[2])
        return error

    def _accelerate(self, wanted: F64, velocity: F64, dt_s: float) -> F64:
        size, change, force = self._size, self._change, self._force
        p = self._params
        most = self._slew * dt_s
        easy = most / -np.expm1(-dt_s / p.shaping_s)  # changes up to here are exponential
        np.subtract(wanted, self._reference, out=change)
        np.hypot(change[0], change[1], out=size[0])
        np.abs(change[2], out=size[1])
        np.maximum(size, easy, out=size)
        np.divide(most, size, out=size)
        change[:2] *= size[0]
        change[2] *= size[1]
        self._reference += change

        np.subtract(self._reference, velocity, out=force)
        change *= 1.0 / dt_s
        change += self._integral
        np.multiply(force, self._integral_gain * dt_s, out=wanted)
        self._integral += wanted
        np.minimum(self._integral, self._most_integral, out=self._integral)
        np.maximum(self._integral, -self._most_integral, out=self._integral)
        force *= self._gain
        force += change
        self._bound(force)
        return force

    def _bound(self, force: F64) -> None:
        """Lift first, then as much tilt as allowed."""
        lift, row = force[2], self._row
        lift += GRAVITY
        np.maximum(lift, self._lightest, out=lift)
        np.minimum(lift, self._heaviest, out=lift)
        force[:2] /= lift
        np.hypot(force[0], force[1], out=row)
        np.maximum(row, self._tan_tilt, out=row)
        np.divide(self._tan_tilt, row, out=row)
        force[:2] *= row


def _pair(horizontal: float, vertical: float) -> F64:
    return np.array([[horizontal], [vertical]])


def _triple(horizontal: float, vertical: float) -> F64:
    return np.array([[horizontal], [horizontal], [vertical]])
