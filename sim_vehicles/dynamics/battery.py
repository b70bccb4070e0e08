"""Batteries of all vehicles: current from thrust, charge, voltage with sag."""

from __future__ import annotations

import numpy as np

from sim_vehicles.dynamics.airframe import BatteryParams
from sim_vehicles.dynamics.model import F64, Bools, States


class Battery:
    """Drains the batteries of ``states`` in place.

    Momentum theory gives a hovering rotor's power as thrust ** 1.5; voltage
    falls in a straight line with charge, and by the resistance with current.
    """

    def __init__(self, states: States, params: BatteryParams) -> None:
        self._states = states
        self._params = params
        self._drain = np.zeros(len(states.battery))
        self.draw(np.zeros(len(states.battery)), 0.0)

    def draw(self, load: F64, dt_s: float) -> None:
        """Run for ``dt_s`` at ``load`` (n,), thrust over weight."""
        params, states, drain = self._params, self._states, self._drain
        np.sqrt(load, out=drain)
        drain *= load
        drain *= params.hover_a
        np.add(drain, params.avionics_a, out=states.current)
        np.multiply(states.current, dt_s / (3600.0 * params.capacity_ah), out=drain)
        drain /= states.endurance
        states.battery -= drain
        np.maximum(states.battery, 0.0, out=states.battery)
        np.multiply(states.battery, params.full_v - params.empty_v, out=states.voltage)
        states.voltage += params.empty_v
        np.multiply(states.current, params.resistance_ohm, out=drain)
        states.voltage -= drain

    def alive(self, out: Bools) -> Bools:
        """Which still give power, written to ``out`` (n,)."""
        return np.greater(self._states.battery, 0.0, out=out)
