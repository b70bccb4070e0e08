"""The battery of an electric aircraft: what the propeller's stream takes."""

from __future__ import annotations

import numpy as np

from sim_vehicles.dynamics.model import F64, States
from sim_vehicles.dynamics.plane.airframe import PlaneParams


class Drain:
    """Drains the batteries of ``states`` in place."""

    def __init__(self, states: States, params: PlaneParams) -> None:
        self._states, self._params = states, params
        self.draw(np.zeros(len(states.battery)), np.zeros(len(states.battery)), 0.0)

    def draw(self, thrust: F64, airspeed: F64, dt_s: float) -> None:
        """Run for ``dt_s`` at ``thrust`` (n,) N and ``airspeed`` (n,) m/s.

        A propeller that makes no thrust takes no power, and gives none back. Momentum theory: the
        power is thrust times the mean of the speeds before and behind the propeller.
        """
        k, states = self._params, self._states
        pack = k.pack
        push = np.maximum(thrust, 0.0)
        stream = np.sqrt(2.0 * push / (k.air * k.prop_area * k.prop_c) + airspeed**2)
        power = push * 0.5 * (airspeed + stream) / pack.efficiency + pack.avionics_w
        states.battery -= power * (dt_s / pack.energy_j) / states.endurance
        np.maximum(states.battery, 0.0, out=states.battery)
        rest = pack.empty_v + (pack.full_v - pack.empty_v) * states.battery
        states.current[:] = power / rest
        states.voltage[:] = rest - pack.resistance_ohm * states.current
