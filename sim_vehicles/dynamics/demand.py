"""Setpoints as errors and feed-forwards, with nothing missing."""

from __future__ import annotations

import numpy as np

from sim_vehicles.dynamics.model import F64, Setpoints

TURN = 2.0 * np.pi


class Demand:
    """What setpoints ask of vehicles where they are, in columns.

    A part that is not controlled (NaN, or infinite) asks for nothing: no error,
    no speed. So an axis with neither position nor velocity is brought to rest.

    Attributes:
        error: (3, n) m, from here to the position asked for.
        velocity: (3, n) m/s asked for or fed forward.
        turn: (n,) rad, from this yaw to the one asked for, -pi..pi.
        turn_rate: (n,) rad/s asked for or fed forward.
    """

    def __init__(self, n: int) -> None:
        self._all = np.zeros((8, n))
        self._missing = np.zeros((8, n), dtype=np.bool_)
        self._turns = np.zeros(n)
        self.error: F64 = self._all[0:3]
        self.velocity: F64 = self._all[3:6]
        self.turn: F64 = self._all[6]
        self.turn_rate: F64 = self._all[7]

    def gather(self, setpoints: Setpoints, position: F64, yaw: F64) -> None:
        """Take ``setpoints`` of vehicles at position (3, n) and yaw (n,)."""
        np.subtract(setpoints.position.T, position, out=self.error)
        self.velocity[...] = setpoints.velocity.T
        np.subtract(setpoints.yaw, yaw, out=self.turn)
        self.turn_rate[...] = setpoints.yaw_rate
        np.isfinite(self._all, out=self._missing)
        np.logical_not(self._missing, out=self._missing)
        np.copyto(self._all, 0.0, where=self._missing)
        unwind(self.turn, self._turns)


def unwind(angle: F64, scratch: F64) -> None:
    """Bring ``angle`` to -pi..pi in place, exactly unchanged where it is there."""
    np.multiply(angle, 1.0 / TURN, out=scratch)
    np.rint(scratch, out=scratch)
    np.multiply(scratch, TURN, out=scratch)
    angle -= scratch
