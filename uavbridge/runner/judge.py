"""The judge of a mission: is the goal reached, who goes home, what came of it.

A bus subscriber like any monitor: it merges every frame, whoever hears it, into
the union of maps, reads the agents' reports, and gives one kind of order: return.
It knows the true targets; the agents do not.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from math import inf, nan

import msgspec
import numpy as np

from planners.belief.merge import MERGE_RULES, BeliefMap, unpack
from planners.belief.scores import coverage, entropy, uncertainty
from planners.types import F64
from uavbridge.agent.orders import Order, Verb
from uavbridge.agent.orders import decode as decode_order
from uavbridge.agent.orders import encode as encode_order
from uavbridge.agent.phases import ENDED, Phase
from uavbridge.agent.report import AgentReport, decode
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.api import Sample as Heard
from uavbridge.bus.layers import Layer, decode_layer
from uavbridge.bus.messages import Truth, decode_truth
from uavbridge.bus.screening import FUTURE_S, Screening
from uavbridge.bus.wire import Frame
from uavbridge.bus.wire import decode as decode_frame
from uavbridge.clock import SECOND_US, to_s, to_us
from uavbridge.config import Mission, to_toml
from uavbridge.monitor.past import Chronicle, PastPoint
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import MissionRecord
from uavbridge.recording.topics import encode as encode_record
from uavbridge.report.alliances import PLANNER as ROSTERED
from uavbridge.report.alliances import Rosters
from uavbridge.runner import assemble
from uavbridge.runner.gaps import Gaps
from uavbridge.runner.separation import AIRBORNE_M, Floor, SeparationWatch
from uavbridge.thinned import keep

OVERTIME_S = 600.0  # for the way home after the time limit
TOLD_S = 10.0  # between two tellings of what is flown, for monitors
YIELDED_S = 60.0  # after all were called home, a vehicle that somebody else has is left to them
ASK_S = 0.3  # wall time for which agents may think about their answer
SILENCE_S = 10.0  # an agent that reports no more for so long is lost

_log = logging.getLogger(__name__)
_ENDED = {phase.value for phase in ENDED}
_FAILED = Phase.FAILED.value
_GO_HOME = encode_order(Order(Verb.RETURN))
_ENDS_ALL = frozenset({Verb.RETURN, Verb.LAND, Verb.ABORT})
_YIELDED = Phase.YIELDED.value
_BLIND = Phase.CONNECT.value  # its position is not known yet


class Verdict(Enum):
    """How far the mission is."""

    FLYING = "flying"
    GOAL = "goal reached"
    TIME = "time limit"
    STOPPED = "stopped by hand"
    LOST = "no agent left"


@dataclass(frozen=True, slots=True)
class Found:
    """A cell that somebody declared."""

    cell: tuple[int, int]
    t_us: int
    by: int


@dataclass(frozen=True, slots=True)
class Sample:
    """The mission in numbers at one second."""

    t_us: int
    coverage: float
    entropy: float
    uncertainty: float
    found: int
    separation_m: float


class Judge:
    """Watches one mission over the bus.

    Args:
        mission: with the true targets.
        bus: its session.
        recorder: gets the true positions; None: nobody.
    """

    def __init__(self, mission: Mission, bus: Bus, recorder: Recorder | None = None) -> None:
        self.mission = mission
        self.verdict = Verdict.FLYING
        self.reports: dict[int, AgentReport] = {}
        self.declared: dict[tuple[int, int], Found] = {}
        self.reached: dict[int, Found] = {}  # by target, where targets give signals
        self.dead: dict[int, int] = {}  # mission time of the death of an agent's process
        self.samples: list[Sample] = []
        self.tracks: dict[int, list[tuple[float, float, float]]] = {}
        self.separation = SeparationWatch()
        self.rosters = Rosters(len(mission.targets)) if mission.planner == ROSTERED else None
        self._gaps = Gaps()
        self._screening = Screening(assemble.bounds_of(mission))
        self.rejects = self._screening.rejects
        self._bus, self._recorder = bus, recorder
        self._rule = MERGE_RULES[mission.belief.merge]
        self._grid = mission.grid
        self._onlooker = self._rule.onlooker
        self.union: BeliefMap = self._onlooker.empty(
            self._grid, mission.prior(), assemble.sensor_model(mission)
        )
        self._targets = set(mission.target_cells())
        self._team = mission.scenario().team
        self._floor = Floor.of(mission, mission.terrain())
        self._frames = bus.subscribe("air/**")
        self._states = bus.subscribe(keys.state("*"))
        self._truth = bus.subscribe(keys.TRUTH)
        self._orders = bus.subscribe(keys.cmd("*"))
        self._layers = bus.subscribe("layer/**")
        self.layers: dict[str, Layer] = {}  # newest of each name
        self._simulated = False
        self._newest_truth: Truth | None = None
        self._began_us = 0
        self._over_us: int | None = None  # when all were called home
        self._deaf_us = 0
        self._silence_s = assemble.patience(mission, SILENCE_S)
        self._late_s = assemble.patience(mission, mission.bus.wait_s)  # of other processes
        self._apart = mission.apart()
        self._record = encode_record(MissionRecord(to_toml(mission), mission.seed, mission.clock))
        bus.serve(keys.MISSION, lambda _key: self._record)
        self._chronicle = Chronicle(bus)

    @property
    def found(self) -> int:
        """True targets declared by some agent; reached, where targets give signals."""
        if self.mission.signals is not None:
            return len(self.reached)
        return sum(cell in self._targets for cell in self.declared)

    @property
    def seen_share(self) -> float:
        """Share of the cells seen by some agent."""
        return float(coverage(self.union.seen))

    @property
    def goal_reached(self) -> bool:
        """Every target found, and enough of the area seen, where cells are looked at.

        Where there is nothing to find and all begin in the air: all flew on to the end.
        """
        if self.mission.only_flies:
            phases = {report.phase for report in self.reports.values()}
            return len(self.reports) == len(self._team) and phases == {Phase.ALOFT.value}
        if self.mission.signals is not None:
            return self.found == len(self.mission.targets)
        enough = self.seen_share >= self.mission.coverage_goal
        return enough and self.found == len(self._targets)

    def ended(self, t_us: int) -> bool:
        """Nobody flies any more, or the time for the way home is over."""
        if t_us > to_us(self.mission.duration + OVERTIME_S):
            return True
        return all(self._gone(agent, t_us) for agent in self._team)

    def step(self, t_us: int) -> None:
        """Take in what the bus brought; once a second, decide."""
        for sample in self._truth.drain():
            truth = decode_truth(sample.data, self.rejects)
            if truth is not None:
                self._newest_truth = truth
                self._simulated = set(truth.ids) == set(self._team)
                if self._simulated:
                    ground_m = self._floor.under(truth.ids, truth.position)
                    self.separation.add(truth.t_us, truth.position, ground_m=ground_m)
                if self._recorder:
                    self._recorder.write("truth", truth.t_us, sample.data)
        for sample in self._layers.drain():
            self._keep_layer(*sample, t_us)
        for sample in self._states.drain():
            self._report(*sample, t_us)
        for sample in self._orders.drain():
            self._overhear(sample, t_us)
        if t_us % SECOND_US == 0:
            self._second(t_us)

    def _keep_layer(self, key: str, data: bytes, t_us: int) -> None:
        """Layers are for people: those who watch now, and those who open the recording."""
        name, layer = keys.layer_of(key), decode_layer(data, self.rejects)
        if name is None or layer is None:
            return
        self.layers[name] = layer
        if self._recorder:
            self._recorder.write(key, t_us, data)

    def _overhear(self, sample: Heard, t_us: int) -> None:
        """Orders are written down; one to all may end the mission."""
        try:
            order = decode_order(sample.data)
        except ValueError:
            self.rejects["order"] += 1
            return
        if self._recorder:
            self._recorder.write(sample.key, t_us, sample.data)
        to_all = sample.key == keys.cmd()
        if to_all and order.verb in _ENDS_ALL and self.verdict is Verdict.FLYING:
            self.verdict = Verdict.STOPPED

    def miss(self, t_us: int) -> None:
        """Nothing that anybody says can be heard now: nobody is taken for lost by that."""
        self._deaf_us = t_us

    def stop(self, t_us: int) -> None:
        """Call all home now, by a person's wish; further calls change nothing."""
        if self.verdict is Verdict.FLYING:
            self._call_home(Verdict.STOPPED, t_us)

    def _second(self, t_us: int) -> None:
        if t_us % to_us(TOLD_S) == 0:
            self._bus.publish(keys.MISSION, self._record)
        for sample in self._frames.drain():
            frame = decode_frame(sample.data, self.rejects)
            if frame and self._screening.passes(sample.key, frame, frame.kind, t_us):
                self._merge(frame)
                self._gaps.note(frame.sender, frame.tick)
                if self.rosters is not None:
                    self.rosters.hear(frame)
        if self._gaps.due(t_us):
            self._catch_up()
        for report in self._placed():
            keep(self.tracks.setdefault(report.agent, []), report.position)
        if not self._simulated:
            self._separation_by_reports(t_us)
        now = Sample(
            t_us,
            self.seen_share,
            float(entropy(self.union.probability)),
            float(uncertainty(self.union.probability)),
            self.found,
            self.separation.take_recent(),
        )
        keep(self.samples, now)
        self._chronicle.add(self._past_point(), self._placed())
        if self.verdict is not Verdict.FLYING and self._over_us is None:
            self._over_us = t_us
        if self.verdict is Verdict.FLYING:
            self._decide(t_us)
        elif not self.ended(t_us):
            # Said again every second: an order may be lost like anything else.
            self._bus.publish(keys.cmd(), _GO_HOME)

    def _catch_up(self) -> None:
        """Frames were lost on the way here, with what they told of the map: ask all for theirs."""
        for key, data in self._bus.query(keys.state_cells("*"), ASK_S):
            frame = decode_frame(data, self.rejects)
            if frame is not None and key == keys.state_cells(frame.sender):
                self._merge(frame)

    def _placed(self) -> list[AgentReport]:
        """Of the agents whose position is known."""
        return [report for report in self.reports.values() if report.phase != _BLIND]

    def _past_point(self) -> PastPoint:
        now, reports = self.samples[-1], self.reports.values()
        return PastPoint(
            now.t_us,
            now.coverage,
            now.entropy,
            now.uncertainty,
            len(self.declared),
            now.found,
            now.separation_m,
            sum(report.bytes_sent for report in reports),
            sum(report.bytes_heard for report in reports),
            sum(report.frames_sent for report in reports),
            sum(report.frames_heard for report in reports),
        )

    def _decide(self, t_us: int) -> None:
        if self.goal_reached:
            self._call_home(Verdict.GOAL, t_us)
        elif to_s(t_us) >= self.mission.duration:
            self._call_home(Verdict.TIME, t_us)
        elif self.ended(t_us):
            self.verdict = Verdict.LOST

    def _call_home(self, verdict: Verdict, t_us: int) -> None:
        self.verdict = verdict
        _log.info("%.0f s: %s, all return", to_s(t_us), verdict.value)
        self._bus.publish(keys.cmd(), _GO_HOME)

    def _is_theirs(self, key: str, sender: int, sent_us: int, t_us: int) -> bool:
        """Whether one of the team sent it, under its own key, and not tomorrow; else counted."""
        if sender != keys.agent_of(key) or sender not in self._team:
            self.rejects["sender"] += 1
        elif sent_us > t_us + to_us(FUTURE_S):
            self.rejects["future"] += 1
        else:
            return True
        return False

    def join(self, frames: Iterable[Frame], t_us: int) -> None:
        """Come late to a mission, with what agents told before."""
        self._began_us = t_us
        for frame in frames:
            self._merge(frame)

    def _merge(self, frame: Frame) -> None:
        """Add what a frame tells of cells to the union."""
        records = unpack(self._rule, frame.cells) if frame.rule == self._rule.code else None
        if records is None:
            self.rejects["cells"] += 1
            return
        # As agents do: nothing can have been observed after it was sent.
        honest = records[self._rule.valid(self.union, records, until_us=frame.t_us)]
        if len(honest) < len(records):
            self.rejects["cells"] += len(records) - len(honest)
        if len(honest):
            self.union, _ = self._onlooker.merge(self.union, honest)

    def _report(self, key: str, data: bytes, t_us: int) -> None:
        try:
            report = decode(data)
        except msgspec.DecodeError:
            self.rejects["report"] += 1
            return
        if not self._is_theirs(key, report.agent, report.t_us, t_us):
            return
        self.reports[report.agent] = report
        for column, row, t_us in report.declared:
            known = self.declared.get((column, row))
            if known is None or (t_us, report.agent) < (known.t_us, known.by):
                self.declared[column, row] = Found((column, row), t_us, report.agent)

        for target, t_us in report.found:
            self._reached(target, t_us, report.agent)

    def _reached(self, target: int, t_us: int, agent: int) -> None:
        if not 0 <= target < len(self.mission.targets):
            self.rejects["target"] += 1
            return
        known = self.reached.get(target)
        if known is None or (t_us, agent) < (known.t_us, known.by):
            column, row = self._grid.cell_of(self.mission.targets[target].position).tolist()
            self.reached[target] = Found((column, row), t_us, agent)

    def _gone(self, agent: int, t_us: int) -> bool:
        report = self.reports.get(agent)
        if report is None:
            patience_s = self._late_s if agent in self._apart else self._silence_s
            return to_s(t_us - self._began_us) > patience_s
        if report.phase == _YIELDED and self._over_us is not None:
            return to_s(t_us - self._over_us) > YIELDED_S
        if report.phase in _ENDED:
            return True
        heard_us = max(report.t_us, self._deaf_us)
        return to_s(t_us - heard_us) > self._silence_s and not self._flies(agent, t_us)

    def _flies(self, agent: int, t_us: int) -> bool:
        """Whether a simulated vehicle is in the air, as one whose agent died on its way home."""
        truth = self._newest_truth
        if truth is None or agent not in truth.ids or agent in self._floor.driving:
            return False
        if to_s(t_us - truth.t_us) > self._silence_s:
            return False
        row = truth.ids.index(agent)
        ground_m = np.broadcast_to(self._floor.under(truth.ids, truth.position), len(truth.ids))
        return bool(truth.position[row, 2] > ground_m[row] + AIRBORNE_M)

    def _separation_by_reports(self, t_us: int) -> None:
        flying = [r.position for r in self._placed() if r.in_air or r.agent in self._floor.driving]
        self.separation.add(t_us, np.array(flying).reshape(-1, 3), ground_m=-inf)

    def failures(self) -> tuple[str, ...]:
        """What went wrong with agents, by id."""
        texts = []
        for agent in self._team:
            report = self.reports.get(agent)
            if agent in self.dead:
                texts.append(f"agent {agent}: its process died at {to_s(self.dead[agent]):.1f} s")
            elif report is None:
                texts.append(f"agent {agent}: never reported")
            elif report.phase == _FAILED or report.failure:
                texts.append(f"agent {agent}: {report.failure or 'failed'}")
            elif report.phase not in _ENDED:
                texts.append(f"agent {agent}: last heard in phase {report.phase}")
        return tuple(texts)

    def track(self, agent: int) -> F64:
        """(k, 3) ENU m, one a second; of flights over two hours the older ones are sparser."""
        return np.array(self.tracks.get(agent, [])).reshape(-1, 3)

    def latest(self) -> Sample:
        """The newest sample."""
        return self.samples[-1] if self.samples else Sample(0, 0.0, nan, nan, 0, nan)
