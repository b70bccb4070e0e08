"""The radio among agents that are all in one place: for experiments, without a bus.

What ``Air`` does over a bus, message by message; the same radio decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np
from msgspec.structs import replace

from planners.types import F64
from uavbridge.bus.late import Late
from uavbridge.bus.traffic import Traffic
from uavbridge.bus.wire import WAITED_BYTES, WAITED_LIMIT_S, Frame, decode, encode
from uavbridge.clock import SECOND_US
from uavbridge.radio import Queue, Radio, Transmissions, Verdict


class Ether:
    """Carries the frames of a team.

    Args:
        radio: decides who hears whom, and when.
        team: ids, ascending.

    Attributes:
        traffic: accounts of each agent.
    """

    def __init__(self, radio: Radio, team: Sequence[int]) -> None:
        self.traffic = {agent: Traffic() for agent in team}
        self._radio, self._team = radio, tuple(team)
        self._ids = np.array(self._team, np.int64)
        self._late: Late[tuple[Frame, int]] = Late(radio, self._ids)
        self._queues: dict[int, Queue] = {}
        if isfinite(radio.quality.bytes_per_s):
            rate, longest_s = radio.quality.bytes_per_s, radio.quality.queue_s
            self._queues = {agent: Queue(rate, longest_s) for agent in self._team}
        self._air: list[tuple[Frame, int]] = []  # with its bytes
        self._where = np.zeros((len(self._team), 3))

    def send(self, frames: Sequence[Frame], position: F64) -> None:
        """Frames, at most one of each agent, by ascending sender.

        Args:
            frames: on the air from now on.
            position: (n, 3) ENU m, of the whole team now.
        """
        self._where = position.copy()
        for frame in frames:
            account, size = self.traffic[frame.sender], len(encode(frame))
            size += WAITED_BYTES * bool(self._queues)
            account.offer(size)
            if self._queues:
                left_us = self._queues[frame.sender].leaves(size, frame.t_us)
                if left_us is None:
                    account.drop(Verdict.QUEUE.reason, 1, size)
                    continue
                waited_s = min((left_us - frame.t_us) / SECOND_US, WAITED_LIMIT_S)
                frame = replace(frame, waited_s=waited_s)
            account.send(size)
            account.map_bytes_sent += frame.map_bytes
            told = decode(encode(frame))  # rounded as on the wire
            if told is not None:
                self._air.append((told, size))

    def receive(self, t_us: int) -> list[list[Frame]]:
        """What each of the team has heard since the last call, in the order of ``Air``."""
        heard: list[list[Frame]] = [[] for _ in self._team]
        if self._air:
            self._deliver(heard, t_us)
            self._air = []
        for j, (frame, size) in self._late.due(t_us):
            heard[j].append(frame)
            self.traffic[self._team[j]].hear(1, size)
        return heard

    def _deliver(self, heard: list[list[Frame]], t_us: int) -> None:
        frames = [frame for frame, _ in self._air]
        rows = np.searchsorted(self._ids, [frame.sender for frame in frames])
        sent = Transmissions(
            self._ids[rows],
            np.array([frame.tick for frame in frames], np.int64),
            self._where[rows],
            np.array([size for _, size in self._air], np.int64),
        )
        place = np.broadcast_to(self._where, (len(frames), *self._where.shape))
        verdicts = self._radio.judge(sent, self._ids, place)
        if not self._radio.delivers_at_once:
            left_us = [frame.t_us + frame.waited_s * SECOND_US for frame in frames]
            verdicts[self._late.hold(self._air, sent, left_us, verdicts, t_us)] = Verdict.HELD
        for (frame, size), row in zip(self._air, verdicts.tolist(), strict=True):
            for j, verdict in enumerate(row):
                if verdict == Verdict.DELIVERED:
                    heard[j].append(frame)
                    self.traffic[self._team[j]].hear(1, size)
                elif verdict not in (Verdict.OWN, Verdict.HELD):
                    self.traffic[self._team[j]].drop(Verdict(verdict).reason, 1, size)
