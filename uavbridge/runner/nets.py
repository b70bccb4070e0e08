"""Autopilots' own settings, written down when the mission's safety net takes their place."""

from __future__ import annotations

from collections.abc import Mapping

from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import EventRecord
from uavbridge.runner.earlier import NET, Settings, text_of
from uavbridge.vehicle.api import Vehicle
from uavbridge.vehicle.mavlink import MavlinkVehicle


class NetNotes:
    """Watches the nets of some vehicles.

    Args:
        vehicles: by agent; those of other drivers keep such notes to themselves.
        recorder: gets what was set before.
    """

    def __init__(self, vehicles: Mapping[int, Vehicle], recorder: Recorder) -> None:
        self._vehicles = {a: v for a, v in vehicles.items() if isinstance(v, MavlinkVehicle)}
        self._recorder = recorder
        self._noted: dict[int, Settings] = {}

    def step(self, t_us: int) -> None:
        """Write down what is new."""
        for agent, vehicle in self._vehicles.items():
            before = vehicle.net.before
            if before and len(before) != len(self._noted.get(agent, ())):
                self._noted[agent] = dict(before)
                record = EventRecord(NET, text_of(before), agent)
                self._recorder.record("event", t_us, record)
