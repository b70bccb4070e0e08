"""A mission as an onlooker on its bus sees it, flown here, elsewhere, or recorded.

Rule 1: it only listens; what it asks for at the start, it asks once.
Rule 2: whatever comes may be wrong: what does not read is counted and left out.
"""

from __future__ import annotations

from planners.belief.merge import MERGE_RULES
from uavbridge.agent.report import AgentReport
from uavbridge.bus import keys
from uavbridge.bus.api import Bus, Sample
from uavbridge.bus.layers import decode_layer
from uavbridge.bus.messages import decode_map, decode_truth
from uavbridge.bus.wire import Vector, decode, decode_beacon
from uavbridge.monitor import told
from uavbridge.monitor.known import Known
from uavbridge.monitor.shown import tells_values
from uavbridge.monitor.watched import Declared, Happening, Point, Watched, point_of
from uavbridge.runner.separation import Floor

__all__ = ["Declared", "Happening", "MissionWatch", "Point", "Watched"]

_BLIND = "connect"  # the phase in which a position is not known yet


class MissionWatch(Known):
    """What can be known of a mission by listening to its bus.

    Args:
        bus: its session; None: samples are fed by ``apply`` alone.
        timeout_s: longest wait for the answers to what is asked at the start.
    """

    def __init__(self, bus: Bus | None = None, *, timeout_s: float = 1.0) -> None:
        super().__init__()
        self._mailboxes = [] if bus is None else [bus.subscribe("**"), bus.watch(keys.alive("*"))]
        if bus is not None:
            self._joining = True
            for pattern in (keys.MISSION, keys.state_map("*"), keys.PAST):
                self._ask(bus, pattern, timeout_s)
            if self.facts is not None and not tells_values(MERGE_RULES[self.facts.belief.merge]):
                self._ask(bus, keys.state_cells("*"), timeout_s)
            self._joining = False

    def _ask(self, bus: Bus, pattern: str, timeout_s: float) -> None:
        for sample in bus.query(pattern, timeout_s):
            self.apply(sample)

    def poll(self) -> None:
        """Take in what the bus brought since the last call."""
        for mailbox in self._mailboxes:
            for sample in mailbox.drain():
                self.apply(sample)

    def apply(self, sample: Sample, t_us: int | None = None) -> None:
        """Take in one sample.

        Args:
            sample: key relative to the mission, and data.
            t_us: mission time, where the sample itself does not tell it; None: now.
        """
        space, _, rest = sample.key.partition("/")
        if t_us is not None:
            self._passed(t_us)
        if space == "air":
            self._air(sample)
        elif space == "safety":
            self._beacon(sample)
        elif space == "state":
            self._state(sample, rest)
        elif sample.key == keys.TRUTH:
            self._truth(sample.data)
        elif sample.key == keys.MISSION:
            self._mission(sample.data)
        elif sample.key == keys.PAST:
            self._recall(sample.data)
        elif space == "layer":
            self._layer(keys.layer_of(sample.key), sample.data)
        elif space == "alive":
            self._token(sample)
        elif space == "cmd":
            self._order(rest, sample.data)

    def close(self) -> None:
        """Listen no more; what is known stays."""
        for mailbox in self._mailboxes:
            mailbox.close()

    def _air(self, sample: Sample) -> None:
        frame = decode(sample.data, self.rejects)
        if frame is not None and frame.sender != keys.agent_of(sample.key):
            self.rejects["sender"] += 1
            frame = None
        if frame is None or not self._passed(frame.t_us):
            return
        agent = self._agent(frame.sender, frame.t_us)
        agent.sent_us, agent.frame = frame.t_us, frame
        self._move(agent, frame.position, frame.velocity)
        if not self.maps.take_frame(frame):
            self.rejects["cells"] += 1

    def _beacon(self, sample: Sample) -> None:
        beacon = decode_beacon(sample.data, self.rejects)
        if beacon is None or beacon.sender != keys.agent_of(sample.key):
            return
        if self._passed(beacon.t_us):
            agent = self._agent(beacon.sender, beacon.t_us)
            self._move(agent, beacon.position, beacon.velocity)

    def _move(self, agent: Watched, position: Vector, velocity: Vector) -> None:
        if not self.simulated or agent.position is None:
            agent.position = position
        agent.velocity = velocity

    def _truth(self, data: bytes) -> None:
        truth = decode_truth(data, self.rejects)
        if truth is None or not self._passed(truth.t_us):
            return
        self.simulated = True
        ground_m = self.floor.under(truth.ids, truth.position)
        self.separation.add(truth.t_us, truth.position, ground_m=ground_m)
        for number, position in zip(truth.ids, truth.position.tolist(), strict=True):
            x, y, z = position
            self._agent(number, truth.t_us).position = (x, y, z)

    def _state(self, sample: Sample, rest: str) -> None:
        number, _, what = rest.partition("/")
        if not (number.isascii() and number.isdigit()):
            return
        if what == "map":
            self._full_map(int(number), sample.data)
        elif what == "cells":
            self._all_cells(int(number), sample.data)
        elif what == "ack":
            self._answered(int(number), sample.data)
        elif what == "event":
            self._told(int(number), sample.data)
        elif not what:
            self._reported(int(number), sample.data)

    def _all_cells(self, number: int, data: bytes) -> None:
        frame = decode(data, self.rejects)
        if frame is not None and (frame.sender != number or not self.maps.take_frame(frame)):
            self.rejects["cells"] += 1

    def _reported(self, number: int, data: bytes) -> None:
        report = told.report_of(data, self.rejects)
        if report is not None and report.agent != number:
            self.rejects["report"] += 1
        elif report is not None and self._passed(report.t_us):
            self.take_report(report)

    def take_report(self, report: AgentReport) -> None:
        """What an agent says of itself."""
        agent = self._agent(report.agent, report.t_us)
        before, agent.report = agent.report, report
        agent.heading = report.heading
        if report.phase != _BLIND:
            self._move(agent, report.position, report.velocity)
        if not agent.tells and (before is None or before.phase != report.phase):
            self.log.add(report.t_us, agent.id, "phase", report.phase)
        failed = report.failure and (before is None or before.failure != report.failure)
        if failed and not agent.tells:
            self.log.add(report.t_us, agent.id, "failure", report.failure)
        for t_us, text in self.finds.take(report):
            self.log.add(t_us, agent.id, "declared", text)

    def _full_map(self, number: int, data: bytes) -> None:
        full = decode_map(data, self.rejects)
        if full is None or full.agent != number or not self._passed(full.t_us):
            return
        self._agent(number, full.t_us)
        if not self.maps.take_full(full):
            self.rejects["grid"] += 1

    def _layer(self, name: str | None, data: bytes) -> None:
        layer = decode_layer(data, self.rejects)
        if layer is None or not self._passed(layer.t_us):
            return
        if name is None or not self.maps.take_layer(name, layer):
            self.rejects["layer"] += 1

    def _mission(self, data: bytes) -> None:
        found = told.mission_of(data, self.rejects, self.record)
        if found is not None:
            self.record, self.facts = found
            self.floor = Floor.of(self.facts, told.terrain_of(self.facts))
            self.finds.take_mission(self.facts)
            self.maps.take_mission(self.facts)

    def _token(self, sample: Sample) -> None:
        number = keys.agent_of(sample.key)
        if number is None:
            return
        agent = self._agent(number, -1)
        alive = bool(sample.data)
        if agent.alive is not None and agent.alive != alive:
            self.log.add(self.t_us, number, "link", "is back" if alive else "left the bus")
        agent.alive = alive

    def _order(self, target: str, data: bytes) -> None:
        verb = told.verb_of(data, self.rejects)
        if verb is not None:
            self.log.order(self.t_us, target, verb)

    def _told(self, number: int, data: bytes) -> None:
        event = told.event_of(data, self.rejects)
        if event is None:
            return
        self._agent(number, self.t_us).tells = True
        self.log.told(self.t_us, number, event.kind, event.text)

    def _answered(self, number: int, data: bytes) -> None:
        ack = told.ack_of(data, self.rejects)
        if ack is None or ack.agent != number:
            return
        if not self._agent(number, self.t_us).tells:
            self.log.add(self.t_us, number, "order", f"{ack.verb}: {ack.reason or 'done'}")

    def _recall(self, data: bytes) -> None:
        """What was before we came, as the judge has it."""
        past = told.past_of(data, self.rejects)
        if past is None or self.series or not past.points:
            return
        if not self._passed(past.points[-1].t_us):
            return
        self.series = [point_of(point) for point in past.points]
        for point in self.series:
            self.separation.recall(point.t_us, point.separation_m)
        for number, track in past.tracks.items():
            self._agent(number, self.t_us).track[:0] = track
        for event in past.events:
            self._agent(event.agent, event.t_us).tells = True
            self.log.recall(self.t_us, event)
