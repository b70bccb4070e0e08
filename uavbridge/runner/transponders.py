"""Position beacons of the vehicles themselves, where nobody speaks for them any more.

``safety/`` stands for a short-range beacon such as Remote ID: a device on the vehicle, fed by the
autopilot. An agent that lives speaks for its vehicle; where its process is dead or frozen the
vehicle holds and returns by itself, and its device tells the others where it is.
"""

from __future__ import annotations

import numpy as np

from planners.types import F64, Bools
from uavbridge.agent.agent import BEACON_US
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.tiles import Tiling
from uavbridge.bus.wire import Beacon, decode_beacon, encode_beacon
from uavbridge.clock import SECOND_US

SILENCE_US = SECOND_US  # without a beacon of the agent's
_OWN_US = (
    BEACON_US // 2
)  # their times lie between those of agents, so that none is taken for a copy


class Transponders:
    """One on each of some simulated vehicles.

    Args:
        agents: of the vehicles.
        bus: where the agents' beacons are heard, and theirs go.
        tiling: of the beacons' keys.
    """

    def __init__(self, agents: tuple[int, ...], bus: Bus, tiling: Tiling) -> None:
        self._agents, self._bus, self._tiling = agents, bus, tiling
        self._beacons = bus.subscribe(keys.safety(("*", "*"), "*"))
        self._spoke_us = dict.fromkeys(agents, 0)  # the agent, or the vehicle stood on the ground

    def step(self, t_us: int, position: F64, velocity: F64, in_air: Bools) -> None:
        """Send the beacons that are due.

        Args:
            t_us: mission time.
            position: (n, 3) ENU m, where the devices say that they are.
            velocity: (n, 3) m/s.
            in_air: (n,).
        """
        for sample in self._beacons.drain():
            beacon = decode_beacon(sample.data)
            if beacon is not None and beacon.t_us % BEACON_US != _OWN_US:
                self._spoke_us[beacon.sender] = t_us
        if t_us % BEACON_US != _OWN_US:
            return
        for row in np.flatnonzero(~in_air).tolist():
            self._spoke_us[self._agents[row]] = t_us
        for row in np.flatnonzero(in_air).tolist():
            agent = self._agents[row]
            if t_us - self._spoke_us[agent] > SILENCE_US:
                x, y, z = position[row].tolist()
                vx, vy, vz = velocity[row].tolist()
                beacon = Beacon(agent, t_us, (x, y, z), (vx, vy, vz))
                key = keys.safety(self._tiling.tile_of(beacon.position), agent)
                self._bus.publish(key, encode_beacon(beacon))
