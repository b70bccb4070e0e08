"""One kind of radio for the agents of a process: few subscriptions, fan-out inside.

What arrives is decoded once, judged for all agents of the process in one numpy
step, and handed to those in range. Nothing else in the project reads these keys
for an agent.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from planners.types import F64
from uavbridge.bus import keys
from uavbridge.bus.api import Bus, Sample
from uavbridge.bus.listening import Listening
from uavbridge.bus.tiles import Tiling
from uavbridge.bus.traffic import Traffic
from uavbridge.bus.truth import TruthTrack, rows_of
from uavbridge.bus.wire import Vector
from uavbridge.clock import to_us
from uavbridge.radio import Radio, Transmissions, Verdict

HOLD_S = 0.5  # longest wait for the truth of a message's sending time
FUTURE_S = 1.0  # clocks may differ by this much
REMEMBERED = 64  # messages of a sender, to know a duplicate

HeardLog = Callable[[int, bytes, bool, str], None]  # receiver, bytes, delivered, reason


Verdicts: TypeAlias = npt.NDArray[np.uint8]  # (messages, agents)


class Sent(Protocol):
    """What frames and beacons have in common."""

    @property
    def sender(self) -> int: ...
    @property
    def t_us(self) -> int: ...
    @property
    def position(self) -> Vector: ...


M = TypeVar("M", bound=Sent)


@dataclass(frozen=True, slots=True)
class _Arrival(Generic[M]):
    message: M
    data: bytes
    number: int  # the key of the radio's draws: tick, or sending time
    since_us: int  # when it arrived


class Channel(ABC, Generic[M]):
    """Sending and receiving over one emulated radio.

    Args:
        bus: the mission's.
        radio: decides who hears whom.
        agents: ids of the agents in this process; those to be heard live anywhere.
        tiling: of the keys; the default is one tile.
        truth: true positions, where the world is simulated; without it a message's
            own position and the receiver's own position decide.
        log: called with (receiver, bytes, delivered, reason) for every message that
            arrived and every local agent but the sender.

    Attributes:
        traffic: accounts of each local agent.
        rejects: arrivals that no agent could have heard, by reason: malformed, a
            sender that is not the key's, a duplicate, from the future.
        arrivals: samples the bus delivered to this process.
        unsure: messages judged without the truth of their sending time.
    """

    def __init__(
        self,
        bus: Bus,
        radio: Radio,
        agents: Sequence[int],
        tiling: Tiling | None = None,
        truth: TruthTrack | None = None,
        *,
        log: HeardLog | None = None,
    ) -> None:
        self.radio = radio
        self.agents = tuple(sorted(agents))
        self.traffic = {agent: Traffic() for agent in self.agents}
        self.rejects: Counter[str] = Counter()
        self.arrivals = 0
        self.unsure = 0
        self._bus = bus
        self._tiling = tiling or Tiling()
        self._listening = Listening(bus, self._key, self._tiling)
        self._truth = truth
        self._log = log
        self._ids = np.array(self.agents, np.int64)
        self._waiting: list[_Arrival[M]] = []
        self._known: dict[int, dict[tuple[int, int], None]] = {}

    @staticmethod
    @abstractmethod
    def _key(tile: keys.TilePattern, agent: int | str) -> str:
        """Where messages of an agent in a tile are published."""

    @staticmethod
    @abstractmethod
    def _encode(message: M) -> bytes: ...

    @staticmethod
    @abstractmethod
    def _decode(data: bytes, rejects: Counter[str]) -> M | None: ...

    @staticmethod
    @abstractmethod
    def _number(message: M) -> int:
        """With sender and receiver, the key of the radio's draws."""

    def send(self, message: M) -> int:
        """Send a message of a local agent; returns its bytes.

        Raises:
            ValueError: it does not fit the wire format.
        """
        data = self._encode(message)
        traffic = self.traffic[message.sender]
        traffic.frames_offered += 1
        traffic.bytes_offered += len(data)
        self._bus.publish(self._key(self._tiling.tile_of(message.position), message.sender), data)
        traffic.frames_sent += 1
        traffic.bytes_sent += len(data)
        return len(data)

    def close(self) -> None:
        """Hear nothing more."""
        self._listening.close()

    def receive(self, positions: Mapping[int, Sequence[float]], t_us: int) -> dict[int, list[M]]:
        """What each local agent heard since the last call.

        Args:
            positions: of every local agent, ENU m, as it knows it.
            t_us: now.

        Returns:
            by agent, in ascending order of sender, then of sending.
        """
        if self._truth is not None:
            self._truth.poll()
        for sample in self._listening.drain():
            self._accept(sample, t_us)
        self._listening.follow([tuple(positions[agent]) for agent in self.agents])
        batch = self._due(t_us)
        heard: dict[int, list[M]] = {agent: [] for agent in self.agents}
        if not batch or not self.agents:
            return heard
        batch.sort(key=lambda arrival: (arrival.message.sender, arrival.number))
        known = np.array([positions[agent] for agent in self.agents], np.float64)
        verdicts = self._judge(batch, known)
        self._count(batch, verdicts)
        for j, agent in enumerate(self.agents):
            inbox = heard[agent]
            for i in np.flatnonzero(verdicts[:, j] == Verdict.DELIVERED).tolist():
                inbox.append(batch[i].message)
        if self._log is not None:
            self._tell(batch, verdicts, self._log)
        return heard

    def _accept(self, sample: Sample, t_us: int) -> None:
        self.arrivals += 1
        message = self._decode(sample.data, self.rejects)
        if message is None:
            return
        if message.sender != keys.agent_of(sample.key):
            self.rejects["sender"] += 1
        elif message.t_us > t_us + to_us(FUTURE_S):
            self.rejects["future"] += 1
        elif self._is_duplicate(message, sample.data[3]):
            self.rejects["duplicate"] += 1
        else:
            arrival = _Arrival(message, sample.data, self._number(message), t_us)
            self._waiting.append(arrival)

    def _is_duplicate(self, message: M, kind: int) -> bool:
        known = self._known.setdefault(message.sender, {})
        identity = (message.t_us, kind)
        if identity in known:
            return True
        known[identity] = None
        if len(known) > REMEMBERED:
            del known[next(iter(known))]
        return False

    def _due(self, t_us: int) -> list[_Arrival[M]]:
        """Arrivals that can be judged now; the rest waits for the truth, but not for long."""
        waiting, self._waiting = self._waiting, []
        if self._truth is None or not self.radio.needs_positions:
            return waiting
        newest_us = self._truth.newest_us
        due = []
        for arrival in waiting:
            known = newest_us is not None and arrival.message.t_us <= newest_us
            if known or t_us - arrival.since_us >= to_us(HOLD_S):
                due.append(arrival)
            else:
                self._waiting.append(arrival)
        return due

    def _judge(self, batch: list[_Arrival[M]], known: F64) -> Verdicts:
        sender = np.array([arrival.message.sender for arrival in batch], np.int64)
        source = np.array([arrival.message.position for arrival in batch], np.float64)
        place = np.broadcast_to(known, (len(batch), *known.shape))
        if self._truth is not None and self.radio.needs_positions:
            place = place.copy()
            self._correct(self._truth, batch, source, place)
        sent = Transmissions(
            sender,
            np.array([arrival.number for arrival in batch], np.int64),
            source,
            np.array([len(arrival.data) for arrival in batch], np.int64),
        )
        return self.radio.judge(sent, self._ids, place)

    def _correct(
        self, truth: TruthTrack, batch: list[_Arrival[M]], source: F64, place: F64
    ) -> None:
        """Put the true positions at sending time in place of the believed ones."""
        moments: dict[int, list[int]] = {}
        for i, arrival in enumerate(batch):
            moments.setdefault(arrival.message.t_us, []).append(i)
        for t_us, rows in moments.items():
            moment = truth.when(t_us)
            if moment is None:
                self.unsure += len(rows)
                moment = truth.nearest(t_us)
            if moment is None:
                continue
            place[rows] = rows_of(moment, self.agents, place[rows[0]])
            senders = [batch[i].message.sender for i in rows]
            source[rows] = rows_of(moment, senders, source[rows])

    def _count(self, batch: list[_Arrival[M]], verdicts: Verdicts) -> None:
        size = np.array([len(arrival.data) for arrival in batch], np.int64)
        delivered = verdicts == Verdict.DELIVERED
        frames, octets = delivered.sum(axis=0).tolist(), (size @ delivered).tolist()
        for j, agent in enumerate(self.agents):
            traffic = self.traffic[agent]
            traffic.frames_heard += frames[j]
            traffic.bytes_heard += octets[j]
        for verdict in Verdict:
            if verdict in (Verdict.DELIVERED, Verdict.OWN):
                continue
            for agent, lost in zip(self.agents, (verdicts == verdict).sum(axis=0), strict=True):
                if lost:
                    self.traffic[agent].dropped[verdict.reason] += int(lost)

    def _tell(self, batch: list[_Arrival[M]], verdicts: Verdicts, log: HeardLog) -> None:
        for arrival, row in zip(batch, verdicts.tolist(), strict=True):
            for agent, value in zip(self.agents, row, strict=True):
                if value != Verdict.OWN:
                    verdict = Verdict(value)
                    log(agent, arrival.data, verdict is Verdict.DELIVERED, verdict.reason)
