"""One kind of radio for the agents of a process: few subscriptions, fan-out inside.

What arrives is decoded once, judged for all agents of the process in one numpy
step, and handed to those in range. Nothing else in the project reads these keys
for an agent.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from planners.types import F64, I64
from uavbridge.bus import keys
from uavbridge.bus.api import Bus, Sample
from uavbridge.bus.late import Late
from uavbridge.bus.listening import Listening
from uavbridge.bus.screening import ANY, FUTURE_S, Bounds, Screening, Sent
from uavbridge.bus.tiles import Tiling
from uavbridge.bus.traffic import Traffic
from uavbridge.bus.truth import TruthTrack
from uavbridge.clock import SECOND_US, to_us
from uavbridge.radio import Queue, Radio, Transmissions, Verdict

HOLD_S = 0.5  # longest wait for the truth of a message's sending time, unless said otherwise
FOLLOW_S = 0.5  # subscriptions follow the agents this often; their margin covers more

_UNTOLD = (Verdict.OWN, Verdict.HELD)
_LOSSES = tuple(v for v in Verdict if v not in (Verdict.DELIVERED, *_UNTOLD))
_DELIVERED = int(Verdict.DELIVERED)
_REASONS = tuple(verdict.reason for verdict in sorted(Verdict))
_HEARD, _FAR = Verdict.DELIVERED.reason, Verdict.OUT_OF_RANGE.reason

HeardLog = Callable[[int, bytes, bool, str], None]  # receiver, bytes, delivered, reason


Verdicts: TypeAlias = npt.NDArray[np.uint8]  # (messages, agents)

M = TypeVar("M", bound=Sent)


class _Arrival(NamedTuple, Generic[M]):
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
        bounds: what is possible in the mission; the rest is dropped.
        log: called with (receiver, bytes, delivered, reason) for every message and
            every local agent but the sender, as soon as that is decided; what is delivered
            later, when it is.
        hold_s: longest wait for the truth of a message's sending time, once there was truth.

    Attributes:
        traffic: accounts of each local agent.
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
        bounds: Bounds = ANY,
        log: HeardLog | None = None,
        hold_s: float = HOLD_S,
    ) -> None:
        self.radio = radio
        self.agents = tuple(sorted(agents))
        self.traffic = {agent: Traffic() for agent in self.agents}
        self.arrivals = 0
        self.unsure = 0
        self._bus = bus
        self._tiling = tiling or Tiling()
        self._listening = Listening(bus, self._key, self._tiling)
        self._truth = truth
        self._log = log
        self._hold_us = to_us(hold_s)
        self._ids = np.array(self.agents, np.int64)
        self._truth_ids: tuple[int, ...] = ()
        self._local = np.zeros((0, 2), np.int64)  # (agents the truth knows, own and its row)
        self._follow_us = -1
        self._waiting: list[_Arrival[M]] = []
        self._screening = Screening(bounds, f"a {self._what}")
        self._malformed: Counter[str] = Counter()
        self._late: Late[_Arrival[M]] = Late(radio, self._ids)
        self._queues = {
            agent: Queue(radio.quality.bytes_per_s, radio.quality.queue_s)
            for agent in self.agents
            if isfinite(radio.quality.bytes_per_s)
        }

    @property
    def rejects(self) -> Counter[str]:
        """Arrivals that no agent could have heard, by reason: malformed, impossible, twice."""
        return self._screening.rejects

    _what = "message"
    _waited_bytes = 0  # more, for a message that waited

    @staticmethod
    @abstractmethod
    def _key(tile: keys.TilePattern, agent: int | str) -> str:
        """Where messages of an agent in a tile are published."""

    @staticmethod
    @abstractmethod
    def _encode(message: M, /) -> bytes: ...

    @staticmethod
    @abstractmethod
    def _decode(data: bytes, rejects: Counter[str], /) -> M | None: ...

    @abstractmethod
    def _number(self, message: M) -> int:
        """With sender and receiver, the key of the radio's draws."""

    @staticmethod
    def _waited(message: M, waited_s: float) -> M:
        """The message, saying how long it waited in its sender's radio."""
        return message

    @staticmethod
    def _note(message: M, traffic: Traffic) -> None:
        """Keep account of what only this kind has."""

    @staticmethod
    def _left_us(message: M) -> float:
        """When it left its sender's radio."""
        return message.t_us

    def send(self, message: M) -> bytes:
        """Send a message of a local agent; what went out, nothing if there was no bandwidth.

        Raises:
            ValueError: it does not fit the wire format.
        """
        data = self._encode(message)
        traffic = self.traffic[message.sender]
        if self._queues:
            size = len(data) + self._waited_bytes
            traffic.offer(size)
            left_us = self._queues[message.sender].leaves(size, message.t_us)
            if left_us is None:
                traffic.drop(Verdict.QUEUE.reason, 1, size)
                return b""
            data = self._encode(self._waited(message, (left_us - message.t_us) / SECOND_US))
        else:
            traffic.offer(len(data))
        self._bus.publish(self._key(self._tiling.tile_of(message.position), message.sender), data)
        traffic.send(len(data))
        self._note(message, traffic)
        return data

    def share(self, other: Channel[Any]) -> None:
        """Have one set of accounts, and one bandwidth, with another radio of the same agents."""
        self.traffic = other.traffic
        self._queues = other._queues

    def close(self) -> None:
        """Hear nothing more."""
        self._listening.close()

    def receive(self, positions: Mapping[int, Sequence[float]], t_us: int) -> dict[int, list[M]]:
        """What each local agent heard since the last call.

        Args:
            positions: of every local agent, ENU m, as it knows it.
            t_us: now.

        Returns:
            by agent, in ascending order of sender, then of sending; after them what was
            late, in the order in which it was due.
        """
        if self._truth is not None:
            self._truth.poll(t_us + to_us(FUTURE_S))
        self._accept(self._listening.drain(), t_us)
        if t_us >= self._follow_us:
            self._follow_us = t_us + to_us(FOLLOW_S)
            self._listening.follow([tuple(positions[agent]) for agent in self.agents])
        batch = self._due(t_us)
        heard: dict[int, list[M]] = {agent: [] for agent in self.agents}
        if not self.agents:
            return heard
        inboxes = list(heard.values())
        if batch:
            batch.sort(key=lambda arrival: (arrival.message.sender, arrival.number))
        if batch and len(self.agents) == 1 and self.radio.only_range:
            self._one_by_one(batch, positions[self.agents[0]], inboxes[0])
        elif batch:
            known = np.array([positions[agent] for agent in self.agents], np.float64)
            verdicts = self._judge(batch, known, t_us)
            for j, i in np.argwhere(verdicts.T == _DELIVERED).tolist():
                inboxes[j].append(batch[i].message)
            if self._log is not None:
                self._tell(batch, verdicts, self._log)
        for j, arrival in self._late.due(t_us):
            inboxes[j].append(arrival.message)
            self.traffic[self.agents[j]].hear(1, len(arrival.data))
            if self._log is not None:
                self._log(self.agents[j], arrival.data, True, Verdict.DELIVERED.reason)
        return heard

    def _accept(self, samples: list[Sample], t_us: int) -> None:
        """Decode what arrived, count what is of no use, and put the rest in line."""
        self.arrivals += len(samples)
        decode, malformed, number = self._decode, self._malformed, self._number
        screening, waiting = self._screening, self._waiting
        for key, data in samples:
            message = decode(data, malformed)
            if message is None:
                screening.refuse(key, malformed.popitem()[0])
            elif screening.passes(key, message, data[3], t_us):
                waiting.append(_Arrival(message, data, number(message), t_us))

    def _due(self, t_us: int) -> list[_Arrival[M]]:
        """Arrivals that can be judged now; the rest waits for the truth, but not for long."""
        waiting, self._waiting = self._waiting, []
        if self._truth is None or not self.radio.needs_positions:
            return waiting
        newest_us, hold_us = self._truth.newest_us, self._hold_us
        if newest_us is None:
            newest_us, hold_us = -1, to_us(HOLD_S)
        patience_us = t_us - hold_us
        due = []
        for arrival in waiting:
            if arrival.message.t_us <= newest_us:
                due.append(arrival)
            elif arrival.since_us <= patience_us:
                due.append(arrival)
                self.unsure += newest_us < 0
            else:
                self._waiting.append(arrival)
        return due

    def _one_by_one(
        self, batch: list[_Arrival[M]], believed: Sequence[float], inbox: list[M]
    ) -> None:
        """``_judge`` and all that follows, for one agent: plain numbers cost less than arrays."""
        agent, radio, log = self.agents[0], self.radio, self._log
        account, frames, octets = self.traffic[agent], 0, 0
        truth = self._truth if self._truth and self._truth.ids and radio.needs_positions else None
        for message, data, _, _ in batch:
            if message.sender == agent:
                continue
            source: Sequence[float] = message.position
            place = believed
            if truth is not None:
                true_source, true_place, inside = truth.two(message.t_us, message.sender, agent)
                self.unsure += not inside
                source, place = true_source or source, true_place or place
            heard = radio.reaches_one(source, place)
            if heard:
                inbox.append(message)
                frames, octets = frames + 1, octets + len(data)
            else:
                account.drop(_FAR, 1, len(data))
            if log is not None:
                log(agent, data, heard, _HEARD if heard else _FAR)
        account.hear(frames, octets)

    def _judge(self, batch: list[_Arrival[M]], known: F64, t_us: int) -> Verdicts:
        sent = Transmissions(
            np.array([arrival.message.sender for arrival in batch], np.int64),
            np.array([arrival.number for arrival in batch], np.int64),
            np.array([arrival.message.position for arrival in batch], np.float64),
            np.array([len(arrival.data) for arrival in batch], np.int64),
        )
        place = np.empty((len(batch), *known.shape))
        place[:] = known
        if self._truth is not None and self._truth.ids and self.radio.needs_positions:
            self._correct(self._truth, batch, sent.position, place)
        verdicts = self.radio.judge(sent, self._ids, place)
        if not self.radio.delivers_at_once:
            left_us = [self._left_us(arrival.message) for arrival in batch]
            held = self._late.hold(batch, sent, left_us, verdicts, t_us)
            verdicts[held] = Verdict.HELD
        self._count(verdicts, sent.size)
        return verdicts

    def _correct(
        self, truth: TruthTrack, batch: list[_Arrival[M]], source: F64, place: F64
    ) -> None:
        """Put the true positions at sending time in place of the believed ones."""
        positions, inside = truth.when(np.array([arrival.message.t_us for arrival in batch]))
        self.unsure += len(batch) - int(np.count_nonzero(inside))
        if self._truth_ids != truth.ids:
            self._truth_ids = truth.ids
            local = [(j, truth.row[a]) for j, a in enumerate(self.agents) if a in truth.row]
            self._local = np.array(local, np.int64).reshape(-1, 2)
        place[:, self._local[:, 0]] = positions[:, self._local[:, 1]]
        row = truth.row
        senders = [
            (i, row[a.message.sender]) for i, a in enumerate(batch) if a.message.sender in row
        ]
        if senders:
            i, j = np.array(senders).T
            source[i] = positions[i, j]

    def _count(self, verdicts: Verdicts, size: I64) -> None:
        delivered = verdicts == _DELIVERED
        traffic = self.traffic.values()
        frames, octets = delivered.sum(0).tolist(), (size @ delivered).tolist()
        for account, more, bytes_more in zip(traffic, frames, octets, strict=True):
            account.hear(more, bytes_more)
        if delivered.all():
            return
        for verdict in _LOSSES:
            lost = verdicts == verdict
            if lost.any():
                counts, octets = lost.sum(0).tolist(), (size @ lost).tolist()
                for account, count, gone in zip(traffic, counts, octets, strict=True):
                    if count:
                        account.drop(verdict.reason, count, gone)

    def _tell(self, batch: list[_Arrival[M]], verdicts: Verdicts, log: HeardLog) -> None:
        for arrival, row in zip(batch, verdicts.tolist(), strict=True):
            for agent, value in zip(self.agents, row, strict=True):
                if value not in _UNTOLD:
                    log(agent, arrival.data, value == _DELIVERED, _REASONS[value])
