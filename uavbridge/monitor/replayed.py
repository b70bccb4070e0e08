"""A recording as an onlooker's picture of its mission, at any moment of it."""

from __future__ import annotations

import pickle
import zlib
from collections.abc import Callable
from pathlib import Path

from uavbridge.bus.api import Sample
from uavbridge.clock import SECOND_US, to_us, wall_s
from uavbridge.errors import ConfigError
from uavbridge.monitor.watch import MissionWatch
from uavbridge.recording.reader import Recording
from uavbridge.replay.play import key_of

BUDGET_S = 0.05  # wall time of one step
KEPT_US = 20 * SECOND_US  # between two pictures kept for going back


class Player:
    """Plays a recording, at any speed and from any moment.

    Args:
        path: of ``mission.mcap``, or the folder it lies in.
        progress: told the mission time as it is read.

    Attributes:
        name: of the mission.
        watch: the picture of now; another one after going back.
        end_us: mission time of the last message.

    Raises:
        ConfigError: it is no recording, or an empty one.
    """

    def __init__(self, path: Path, progress: Callable[[int], None] = lambda _t_us: None) -> None:
        recording = Recording(path)
        shown = []
        for message in recording.messages():
            progress(message.t_us)
            if (key := key_of(message)) is not None:
                shown.append((message.t_us, Sample(key, message.data)))
        if not shown:
            raise ConfigError(f"{recording.path}: holds nothing to show")
        self.name = recording.mission_name
        self.end_us = max(t_us for t_us, _ in shown)
        self.playing, self.speed = True, 1.0
        self.watch = MissionWatch()
        self._samples = shown
        self._next = 0
        self._target_us = 0
        self._wall_s = wall_s()
        self._kept: dict[int, tuple[int, bytes]] = {}

    @property
    def target_us(self) -> int:
        """Mission time at which it shall be."""
        return self._target_us

    @property
    def seeking(self) -> bool:
        """It is not yet where it shall be."""
        return self._next < len(self._samples) and self._due(self._next)

    def play(self, on: bool) -> None:
        """Go on, or stand still. At the end it begins anew."""
        if on and self._target_us >= self.end_us:
            self.seek(0)
        self.playing = on

    def seek(self, t_us: int) -> None:
        """Go to a moment."""
        self._target_us = min(max(t_us, 0), self.end_us)
        if self._target_us < self.watch.t_us:
            earlier = [at for at in self._kept if at <= self._target_us]
            if earlier:
                self._next, picture = self._kept[max(earlier)]
                self.watch = pickle.loads(zlib.decompress(picture))  # our own, of a moment ago
            else:
                self._next, self.watch = 0, MissionWatch()

    def step(self) -> None:
        """Let time pass, but work no longer than a moment."""
        now_s = wall_s()
        passed_s, self._wall_s = now_s - self._wall_s, now_s
        if self.playing and not self.seeking:
            self._target_us = min(self._target_us + to_us(passed_s * self.speed), self.end_us)
        if self._target_us >= self.end_us:
            self.playing = False
        while self.seeking:
            t_us, sample = self._samples[self._next]
            if t_us >= max(self._kept, default=0) + KEPT_US:
                # Everything before this sample is taken, and nothing from it on.
                picture = zlib.compress(pickle.dumps(self.watch), 1)
                self._kept[t_us] = self._next, picture
            self.watch.apply(sample, t_us)
            self._next += 1
            if wall_s() - now_s > BUDGET_S:
                return

    def _due(self, number: int) -> bool:
        return self._samples[number][0] <= self._target_us
