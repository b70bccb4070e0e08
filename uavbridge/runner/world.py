"""The simulated world as a service: true positions and sensor readings, on the bus.

It knows the targets; agents only ever get their own readings, on ``obs/<agent>``,
where a real detector could publish instead.
"""

from __future__ import annotations

from collections import defaultdict

from sim_vehicles.fleet import Fleet
from sim_vehicles.world.payload import Sensor
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.messages import Readings, Truth, encode_readings, encode_truth


class SimulatedWorld:
    """Looks at the fleet from above.

    Args:
        fleet: the vehicles.
        agents: the agent of each vehicle, ascending.
        sensor: what looks at the ground from them.
        bus: where readings and true positions go.
    """

    def __init__(self, fleet: Fleet, agents: tuple[int, ...], sensor: Sensor, bus: Bus) -> None:
        self._fleet = fleet
        self._agents = agents
        self._sensor = sensor
        self._bus = bus

    def step(self, t_us: int) -> None:
        """Publish what is true and what is seen at ``t_us``."""
        position = self._fleet.states.position
        self._bus.publish(keys.TRUTH, encode_truth(Truth(t_us, self._agents, position)))
        looks: defaultdict[int, list[tuple[int, int, bool]]] = defaultdict(list)
        for sighting in self._sensor.look(t_us, position):
            looks[sighting.vehicle].append((*sighting.cell, sighting.detected))
        for vehicle, seen in looks.items():
            data = encode_readings(Readings(t_us, tuple(seen)))
            self._bus.publish(keys.obs(self._agents[vehicle]), data)
