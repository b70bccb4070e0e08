"""Who was heard lately: on the radio for the planner, on the beacon for separation."""

from __future__ import annotations

import numpy as np

from planners.types import Neighbours
from uavbridge.bus.wire import Beacon, Frame
from uavbridge.clock import to_s, to_us
from uavbridge.place.trailer import own
from uavbridge.safety.filter import Traffic

FORGET_RADIO_S = 30.0
FORGET_BEACON_US = to_us(3.0)


class Hearing:
    """Newest frame and newest beacon of each other agent."""

    def __init__(self) -> None:
        self._frames: dict[int, Frame] = {}
        self._beacons: dict[int, Beacon] = {}  # ascending senders

    def frame(self, frame: Frame) -> None:
        """A frame arrived; an older one than known changes nothing."""
        known = self._frames.get(frame.sender)
        if known is None or frame.t_us > known.t_us:
            self._frames[frame.sender] = frame

    def beacon(self, beacon: Beacon) -> None:
        """A beacon arrived."""
        known = self._beacons.get(beacon.sender)
        if known is None:
            self._beacons = dict(sorted([*self._beacons.items(), (beacon.sender, beacon)]))
        elif beacon.t_us > known.t_us:
            self._beacons[beacon.sender] = beacon

    def neighbours(self, t_us: int) -> Neighbours:
        """Those heard in the last half minute, ascending id."""
        oldest = t_us - to_us(FORGET_RADIO_S)
        heard = [self._frames[i] for i in sorted(self._frames) if self._frames[i].t_us >= oldest]
        if not heard:
            return Neighbours.none()
        return Neighbours(
            ids=np.array([f.sender for f in heard], dtype=np.int64),
            position=np.array([f.position for f in heard]),
            velocity=np.array([f.velocity for f in heard]),
            age_s=np.array([to_s(t_us - f.t_us) for f in heard]),
            payloads=tuple(own(f.payload) for f in heard),
        )

    def heard_within(self, t_us: int, window_s: float) -> int:
        """How many others were heard over the radio in the last ``window_s``."""
        oldest = t_us - to_us(window_s)
        return sum(f.t_us >= oldest for f in self._frames.values())

    def traffic(self, t_us: int) -> list[Traffic]:
        """The others where they should be now: beacons carried forward, ascending id."""
        oldest = t_us - FORGET_BEACON_US
        carried, gone = [], False
        for beacon in self._beacons.values():
            sent_us = beacon.t_us
            if sent_us < oldest:
                gone = True
                continue
            age_s = to_s(t_us - sent_us)
            x, y, z = beacon.position
            velocity = vx, vy, vz = beacon.velocity
            now = (x + vx * age_s, y + vy * age_s, z + vz * age_s)
            carried.append(Traffic(beacon.sender, now, velocity))
        if gone:  # else every tick looks at all who were ever met
            self._beacons = {i: b for i, b in self._beacons.items() if b.t_us >= oldest}
        return carried
