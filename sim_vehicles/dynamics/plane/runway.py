"""Aircraft on the ground: they roll along their heading, and lift off when the wing carries."""

from __future__ import annotations

import numpy as np

from planners.terrain import Terrain
from sim_vehicles.dynamics.model import F64, Bools, Setpoints, States

ROLLING_M_S2 = 0.4  # friction of the wheels
BRAKING_M_S2 = 3.0  # motors off
_DOWN = 0.01  # m, m/s
_PUSH_M_S2 = 0.05  # of lift above weight that takes it off the ground


class Runway:
    """The ground under n aircraft.

    Args:
        states: theirs; ``ground`` and ``on_ground`` are written here.
        terrain: heights; None: level at 0, lower for those that start under it.
    """

    def __init__(self, states: States, terrain: Terrain | None) -> None:
        self._states, self._terrain = states, terrain
        states.ground[:] = np.minimum(states.position[:, 2], 0.0)
        self.look()
        states.on_ground[:] = states.position[:, 2] <= states.ground

    def look(self) -> None:
        """Find the ground under them."""
        if self._terrain is not None:
            self._states.ground[:] = self._terrain.height_at(self._states.position)

    def stopping(self, setpoints: Setpoints) -> Bools:
        """Who (n,) is on the ground and asked to go down there, and so to stop."""
        below = setpoints.position[:, 2] < self._states.position[:, 2] - _DOWN
        asked: Bools = (setpoints.velocity[:, 2] < -_DOWN) | below
        return asked & self._states.on_ground

    def hold(self, position: F64, velocity: F64, motors: Bools, dt_s: float) -> Bools:
        """Keep them above ground; who touches it rolls along its heading.

        Args:
            position: (3, n) ENU m, changed in place.
            velocity: (3, n) m/s, changed in place.
            motors: (n,) running; else the brakes are on.
            dt_s: since the last call.

        Returns:
            (n,) who is on the ground.
        """
        states = self._states
        self.look()
        low = position[2] <= states.ground
        sinks = velocity[2] < _PUSH_M_S2 * dt_s
        down: Bools = low & (sinks | states.on_ground) & (velocity[2] < 0.2)
        if low.any():
            position[2] = np.where(low, np.maximum(position[2], states.ground), position[2])
            cos, sin = np.cos(states.yaw), np.sin(states.yaw)
            ahead = velocity[0] * cos + velocity[1] * sin
            slower = np.where(motors, ROLLING_M_S2, BRAKING_M_S2) * dt_s
            ahead = np.maximum(ahead - slower, 0.0)
            velocity[0] = np.where(down, ahead * cos, velocity[0])
            velocity[1] = np.where(down, ahead * sin, velocity[1])
            velocity[2] = np.where(low, np.maximum(velocity[2], 0.0), velocity[2])
        states.on_ground[:] = down
        return down
