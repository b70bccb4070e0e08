"""Attitude of all vehicles: the tilt of the thrust, and yaw."""

from __future__ import annotations

import numpy as np

from sim_vehicles.dynamics.airframe import MultirotorParams
from sim_vehicles.dynamics.demand import Demand, unwind
from sim_vehicles.dynamics.model import F64, Bools, States


class Attitude:
    """Tilt and yaw under their loops, in reduced form.

    The thrust direction is kept as the tangent of its tilt, east and north, and
    yaw apart, which is all a multirotor that never flips can do. Tilt answers as
    attitude and rate loop together do: second order, critically damped, so it
    never passes what is asked. Yaw has little torque: its rate and acceleration
    are limited.

    Attributes:
        tilt: (2, n) tan of the tilt, east and north.
        stretch: (n,) 1 / cos of the tilt.
    """

    def __init__(self, states: States, rates: F64, angles: F64, params: MultirotorParams) -> None:
        """Write the ``angles`` (2, n) roll, pitch, ``rates`` (3, n) and ``states.yaw``."""
        n = len(states.yaw)
        self._params = params
        self._yaw, self._rates, self._angles = states.yaw, rates, angles
        self.tilt: F64 = np.zeros((2, n))
        self.stretch: F64 = np.ones(n)
        self._sweep = np.zeros((2, n))  # change of tilt, 1/s
        self._pair = np.zeros((2, n))
        self._other = np.zeros((2, n))
        self._sine = np.zeros(n)
        self._cosine = np.zeros(n)

    def rest(self, idle: Bools) -> None:
        """Stand level and still where ``idle`` (n,)."""
        np.copyto(self.tilt, 0.0, where=idle)
        np.copyto(self._sweep, 0.0, where=idle)
        np.copyto(self._rates[2], 0.0, where=idle)

    def step(self, wanted: F64, demand: Demand, dt_s: float) -> None:
        """Turn for ``dt_s`` to the tilt ``wanted`` (2, n) and the yaw demanded."""
        self._lean(wanted, dt_s)
        self._turn(demand, dt_s)
        self._write(dt_s)

    def _lean(self, wanted: F64, dt_s: float) -> None:
        tilt, sweep, pair, other = self.tilt, self._sweep, self._pair, self._other
        w = self._params.attitude_rad_s
        fade = float(np.exp(-w * dt_s))
        tilt -= wanted
        np.multiply(sweep, fade * dt_s, out=pair)  # exact for a constant target
        np.multiply(tilt, -fade * w * w * dt_s, out=other)
        tilt *= fade * (1.0 + w * dt_s)
        tilt += pair
        tilt += wanted
        sweep *= fade * (1.0 - w * dt_s)
        sweep += other
        np.multiply(tilt, tilt, out=pair)
        np.add(pair[0], pair[1], out=self.stretch)
        self.stretch += 1.0
        np.sqrt(self.stretch, out=self.stretch)

    def _turn(self, demand: Demand, dt_s: float) -> None:
        p, yaw, rate, change = self._params, self._yaw, self._rates[2], demand.turn
        change *= p.yaw_gain_1_s
        change += demand.turn_rate
        np.minimum(change, p.yaw_rate_rad_s, out=change)
        np.maximum(change, -p.yaw_rate_rad_s, out=change)
        change -= rate
        change *= -np.expm1(-dt_s / p.yaw_lag_s)
        most = p.yaw_acceleration_rad_s2 * dt_s
        np.minimum(change, most, out=change)
        np.maximum(change, -most, out=change)
        rate += change
        change *= -0.5
        change += rate
        change *= dt_s
        yaw += change
        unwind(yaw, change)

    def _write(self, dt_s: float) -> None:
        """Roll, pitch and their rates, yaw after tilt as in ZYX Euler angles."""
        angles, ahead, left = self._angles, self._pair, self._other
        np.sin(self._yaw, out=self._sine)
        np.cos(self._yaw, out=self._cosine)
        np.multiply(self.tilt, self._cosine, out=ahead)
        np.multiply(self.tilt, self._sine, out=left)
        ahead[0] += left[1]  # forward
        left[0] -= ahead[1]  # right
        rates = self._rates[:2]
        np.negative(angles, out=rates)
        np.divide(left[0], self.stretch, out=left[0])
        np.arcsin(left[0], out=angles[0])
        np.arctan(ahead[0], out=angles[1])
        np.negative(angles[1], out=angles[1])
        rates += angles
        rates *= 1.0 / dt_s
