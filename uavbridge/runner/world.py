"""The simulated world as a service: true positions and sensor readings, on the bus.

It knows the targets; agents only ever get their own readings, on ``obs/<agent>``,
where a real detector could publish instead.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from planners.terrain import Terrain
from planners.types import F64, Bools
from sim_vehicles.fleet import Fleet
from sim_vehicles.world.obstacles import ObstacleDetector
from sim_vehicles.world.payload import Sensor
from sim_vehicles.world.signals import SignalReceiver
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.messages import (
    Obstacle,
    Obstacles,
    Readings,
    Signals,
    Truth,
    encode_obstacles,
    encode_readings,
    encode_signals,
    encode_truth,
)
from uavbridge.config import Mission
from uavbridge.runner import assemble


class Senses:
    """The simulated payloads of some vehicles.

    Args:
        agents: the agent of each vehicle, ascending.
        sensor: what looks at the ground from them; None: nothing.
        bus: where readings go.
        receiver: what hears the targets from them; None: nothing.
        terrain: sensors look from the height above it; None: level ground at 0.
        driving: (n,) which vehicles stand on the ground.
        detector: what sees obstacles from them; None: nothing.
        obstacles: those it sees, in its order.
    """

    def __init__(
        self,
        agents: tuple[int, ...],
        sensor: Sensor | None,
        bus: Bus,
        receiver: SignalReceiver | None = None,
        terrain: Terrain | None = None,
        driving: Bools | None = None,
        detector: ObstacleDetector | None = None,
        obstacles: Sequence[Obstacle] = (),
    ) -> None:
        self._agents = agents
        self._sensor = sensor
        self._bus = bus
        self._receiver = receiver
        self._terrain = terrain
        self._detector, self._obstacles = detector, obstacles
        self._driving = np.zeros(len(agents), np.bool_) if driving is None else driving

    def step(self, t_us: int, position: F64) -> None:
        """Publish what is sensed at ``t_us`` from positions (n, 3) ENU m."""
        if self._sensor is not None:
            self._look(self._sensor, t_us, position)
        if self._receiver is not None:
            self._listen(self._receiver, t_us, position)
        if self._detector is not None:
            self._detect(self._detector, t_us, position)

    def _look(self, sensor: Sensor, t_us: int, position: F64) -> None:
        looks: defaultdict[int, list[tuple[int, int, bool]]] = defaultdict(list)
        for sighting in sensor.look(t_us, self._lifted(position)):
            looks[sighting.vehicle].append((*sighting.cell, sighting.detected))
        for vehicle, seen in looks.items():
            data = encode_readings(Readings(t_us, tuple(seen)))
            self._bus.publish(keys.obs(self._agents[vehicle]), data)

    def _lifted(self, position: F64) -> F64:
        """Positions (n, 3) with their heights above the ground."""
        if self._terrain is None and not self._driving.any():
            return position
        ground = 0.0 if self._terrain is None else self._terrain.height_at(position)
        # Who stands on the ground looks at its own cell, however low.
        height = np.where(self._driving, np.inf, position[:, 2] - ground)
        return np.column_stack((position[:, :2], height))

    def _listen(self, receiver: SignalReceiver, t_us: int, position: F64) -> None:
        heard: defaultdict[int, list[tuple[int, float, bool]]] = defaultdict(list)
        for one in receiver.listen(t_us, position):
            heard[one.vehicle].append((one.target, one.strength, one.arrived))
        for vehicle, signals in heard.items():
            data = encode_signals(Signals(t_us, tuple(signals)))
            self._bus.publish(keys.obs(self._agents[vehicle]), data)

    def _detect(self, detector: ObstacleDetector, t_us: int, position: F64) -> None:
        seen: defaultdict[int, list[Obstacle]] = defaultdict(list)
        for one in detector.look(t_us, position):
            seen[one.vehicle].append(self._obstacles[one.column])
        for vehicle, columns in seen.items():
            data = encode_obstacles(Obstacles(t_us, tuple(columns)))
            self._bus.publish(keys.obs(self._agents[vehicle]), data)


class SimulatedWorld:
    """Looks at the fleet from above.

    Args:
        fleet: the vehicles.
        agents: the agent of each vehicle, ascending.
        senses: theirs.
        bus: where true positions go.
    """

    def __init__(self, fleet: Fleet, agents: tuple[int, ...], senses: Senses, bus: Bus) -> None:
        self._fleet = fleet
        self._agents = agents
        self._senses = senses
        self._bus = bus

    def step(self, t_us: int) -> None:
        """Publish what is true and what is seen at ``t_us``."""
        position = self._fleet.states.position
        self._senses.step(t_us, position)
        # Last: who waits for the true positions of a time has what was sensed then, too.
        self._bus.publish(keys.TRUTH, encode_truth(Truth(t_us, self._agents, position)))


def senses_of(
    mission: Mission, agents: tuple[int, ...], bus: Bus, sensor: Sensor | None = None
) -> Senses:
    """The payloads of a mission: its targets are looked at, or heard where there is ``[signals]``.

    Args:
        mission: with targets.
        agents: of the vehicles, ascending.
        bus: where readings go.
        sensor: looks at the ground; None: the mission's.
    """
    receiver = assemble.receiver_of(mission, agents)
    if sensor is None and receiver is None:
        sensor = assemble.sensor_of(mission, agents)
    kinds = {member.id: member.kind for member in mission.team()}
    driving = np.array([kinds[agent] == "rover" for agent in agents])
    return Senses(
        agents,
        sensor,
        bus,
        receiver,
        mission.terrain(),
        driving,
        assemble.detector_of(mission, agents),
        assemble.hidden_of(mission),
    )


def world_of(
    mission: Mission,
    fleet: Fleet,
    agents: tuple[int, ...],
    bus: Bus,
    sensor: Sensor | None = None,
) -> SimulatedWorld:
    """The world of a mission.

    Args:
        mission: with targets.
        fleet: the vehicles.
        agents: the agent of each, ascending.
        bus: where all of it goes.
        sensor: looks at the ground; None: the mission's.
    """
    return SimulatedWorld(fleet, agents, senses_of(mission, agents, bus, sensor), bus)
