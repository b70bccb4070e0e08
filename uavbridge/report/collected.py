"""What the messages of one recording say, put together for its report."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TypeAlias

import numpy as np

from planners.belief.merge import SensorModel
from planners.types import F64
from uavbridge.agent.phases import Phase
from uavbridge.agent.report import AgentReport
from uavbridge.bus.api import Sample
from uavbridge.bus.layers import Layer, decode_layer
from uavbridge.bus.messages import decode_map
from uavbridge.bus.wire import decode as decode_frame
from uavbridge.clock import to_s
from uavbridge.monitor.past import decode as decode_past
from uavbridge.monitor.shown import UnionMap, readable
from uavbridge.monitor.watch import MissionWatch
from uavbridge.monitor.watched import point_of
from uavbridge.recording.reader import Message
from uavbridge.recording.topics import EventRecord, ScoreRecord, decode
from uavbridge.replay.opened import Opened
from uavbridge.replay.play import key_of
from uavbridge.replay.record import score_of
from uavbridge.report.alliances import PLANNER, Rosters
from uavbridge.report.result import Event
from uavbridge.report.summary import Summary

Place: TypeAlias = tuple[float, float, float]
Scores: TypeAlias = list[tuple[int, ScoreRecord]]

_CONNECT = Phase.CONNECT.value


class Collected:
    """Filled by ``take``, in recorded order.

    Attributes:
        first_us: mission time of the first report; None before any.
        last_us: of the newest message.
        scores: one a second.
        tracks: where each vehicle was, by its own word, from where it knew it.
        reports: the newest of each agent.
        declared: when each cell was declared first, and by whom.
        reached: likewise each target that gives signals, by number.
        summary: at the end of a flight that came to one.
    """

    def __init__(self, opened: Opened) -> None:
        mission = opened.mission
        self.first_us: int | None = None
        self.last_us = 0
        self.scores: Scores = []
        self.tracks: defaultdict[int, list[Place]] = defaultdict(list)
        self.reports: dict[int, AgentReport] = {}
        self.declared: dict[tuple[int, int], tuple[int, int]] = {}
        self.reached: dict[int, tuple[int, int]] = {}
        self.events: list[Event] = []
        self.frames: Counter[int] = Counter()
        self.frame_bytes: Counter[int] = Counter()
        self.summary: Summary | None = None
        sensor = SensorModel(mission.sensor.p, mission.sensor.q, mission.belief.update)
        self.layers: dict[str, Layer] = {}  # newest of each name
        self.rosters = Rosters(len(mission.targets)) if mission.planner == PLANNER else None
        self.union = UnionMap(mission.grid, mission.prior(), sensor)

    def take(self, message: Message) -> None:
        """One message. Raises msgspec.DecodeError where it does not read."""
        kind, _, name = message.topic.partition("/")
        t_us, data = message.t_us, message.data
        self.last_us = max(self.last_us, t_us)
        if kind == "score":
            self.scores.append((t_us, decode(ScoreRecord, data)))
        elif kind == "state":
            self._report(decode(AgentReport, data))
        elif kind == "event":
            record = decode(EventRecord, data)
            agent = record.agent if isinstance(record.agent, int) else None
            self.events.append(Event(to_s(t_us), record.text, agent, record.kind))
        elif kind == "air":
            self._frame(int(name), data)
        elif kind == "layer" and (layer := decode_layer(data)) is not None:
            self.layers[name] = layer
        elif kind == "past":
            self._recall(data)
        elif kind == "fullmap" and (full := decode_map(data)) is not None:
            if full.probability.shape == self.union.grid.shape:
                self.union.take_map(full)
        elif kind == "summary":
            self.summary = decode(Summary, data)

    def track(self, agent: int) -> F64:
        """(k, 3) ENU m."""
        return np.array(self.tracks.get(agent, []), dtype=np.float64).reshape(-1, 3)

    def _report(self, report: AgentReport) -> None:
        if self.first_us is None:
            self.first_us = report.t_us
        self.reports[report.agent] = report
        if report.phase != _CONNECT:
            self.tracks[report.agent].append(report.position)
        for column, row, t_us in report.declared:
            cell = column, row
            self.declared[cell] = min(
                self.declared.get(cell, (t_us, report.agent)), (t_us, report.agent)
            )

        for target, t_us in report.found:
            now = t_us, report.agent
            self.reached[target] = min(self.reached.get(target, now), now)

    def _frame(self, sender: int, data: bytes) -> None:
        self.frames[sender] += 1
        self.frame_bytes[sender] += len(data)
        frame = decode_frame(data)
        if frame is not None and self.rosters is not None:
            self.rosters.hear(frame)
        content = None if frame is None else readable(frame)
        if content is not None:
            self.union.take_records(*content)

    def _recall(self, data: bytes) -> None:
        """What was before the recorder joined."""
        past = decode_past(data)
        for point in past.points:
            self.scores.append((point.t_us, score_of(point_of(point))))
        for agent, track in past.tracks.items():
            self.tracks[agent] += [(x, y, z) for _, x, y, z in track]
        self.events += [Event(to_s(e.t_us), e.text, e.agent, e.kind) for e in past.events]


def derived_scores(opened: Opened) -> Scores:
    """The scores of a recording that has none, as an onlooker would have them."""
    watch = MissionWatch()
    for message in opened.recording.messages():
        key = key_of(message)
        if key is not None:
            watch.apply(Sample(key, message.data), message.t_us)
    return [(p.t_us, score_of(p)) for p in watch.series if np.isfinite(p.coverage)]
