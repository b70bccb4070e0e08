"""Simulated payloads for vehicles that are not simulated.

A mission with hidden targets flown by other vehicles needs sensors that see them. They look
from where the vehicles say that they are, by their separation beacons. A real detector
publishes on ``obs/<agent>`` instead, and ``sensor.simulated = false`` leaves these out.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.wire import Beacon, decode_beacon
from uavbridge.clock import to_us
from uavbridge.config import Mission
from uavbridge.runner.world import senses_of

_STALE_US = to_us(2.0)
_NOWHERE_M = (0.0, 0.0, -1e6)  # nothing is seen from there


class Payloads:
    """The sensors of some agents' vehicles.

    Args:
        mission: with targets.
        agents: whose vehicles are not simulated, ascending.
        bus: their positions come and their readings go there.
    """

    def __init__(self, mission: Mission, agents: tuple[int, ...], bus: Bus) -> None:
        self._agents = agents
        self._senses = senses_of(mission, agents, bus)
        self._mailbox = bus.subscribe(keys.safety(("*", "*"), "*"))
        self._newest: dict[int, Beacon] = {}
        self._rejects: Counter[str] = Counter()

    def step(self, t_us: int) -> None:
        """Sense from where the vehicles are by now."""
        for sample in self._mailbox.drain():
            beacon = decode_beacon(sample.data, self._rejects)
            if beacon is not None and beacon.sender == keys.agent_of(sample.key):
                self._newest[beacon.sender] = beacon
        self._senses.step(t_us, np.array([self._place(a, t_us) for a in self._agents]))

    def _place(self, agent: int, t_us: int) -> tuple[float, float, float]:
        beacon = self._newest.get(agent)
        if beacon is None or not 0 <= t_us - beacon.t_us <= _STALE_US:
            return _NOWHERE_M
        ahead_s = (t_us - beacon.t_us) * 1e-6
        x, y, z = (p + v * ahead_s for p, v in zip(beacon.position, beacon.velocity, strict=True))
        return x, y, z
