"""What came on ``obs/<agent>``: readings, signals and obstacles, decoded and written down."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from planners.types import Reading, Signal
from uavbridge.bus.api import Sample
from uavbridge.bus.messages import (
    Obstacle,
    decode_obstacles,
    decode_readings,
    decode_signals,
)
from uavbridge.bus.wire import Kind, kind_of
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import ObstacleRecord, ReadingRecord, SignalRecord


@dataclass(frozen=True, slots=True)
class Observed:
    """What one agent's sensors said since the last control tick."""

    readings: tuple[Reading, ...] = ()
    signals: tuple[Signal, ...] = ()
    obstacles: tuple[tuple[int, Obstacle], ...] = ()  # with the time of the look

    def write(self, recorder: Recorder, agent: int, t_us: int) -> None:
        """Record all of it; ``t_us`` is when the agent had it."""
        for reading in self.readings:
            look = ReadingRecord(*reading.cell, reading.detected, reading.t_us)
            recorder.record(f"obs/{agent}", t_us, look)
        for one in self.signals:
            signal = SignalRecord(one.target, one.strength, one.arrived, one.t_us)
            recorder.record(f"signal/{agent}", t_us, signal)
        for taken_us, obstacle in self.obstacles:
            recorder.record(f"obstacle/{agent}", t_us, ObstacleRecord(*obstacle, taken_us))


NOTHING = Observed()


def observed(samples: Iterable[Sample], rejects: Counter[str]) -> Observed:
    """What samples say; those that make no sense are counted."""
    readings: list[Reading] = []
    signals: list[Signal] = []
    obstacles: list[tuple[int, Obstacle]] = []
    for _, data in samples:
        kind = kind_of(data)
        if kind == Kind.SIGNALS:
            heard = decode_signals(data, rejects)
            if heard is not None:
                signals += [Signal(heard.t_us, *one) for one in heard.heard]
        elif kind == Kind.OBSTACLES:
            around = decode_obstacles(data, rejects)
            if around is not None:
                obstacles += [(around.t_us, one) for one in around.seen]
        else:
            seen = decode_readings(data, rejects)
            if seen is not None:
                readings += [Reading(seen.t_us, (c, r), yes) for c, r, yes in seen.looks]
    return Observed(tuple(readings), tuple(signals), tuple(obstacles))
