"""A mission through the whole system in lockstep, sampled like the lighter fidelities."""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Mapping as Map

import numpy as np

from planners.planner import Planner
from uavbridge.agent.phases import ENDED, Phase
from uavbridge.bus.api import Bus
from uavbridge.clock import SECOND_US, to_s, to_us
from uavbridge.config import Mission
from uavbridge.experiments.comparison.trial import Ages, Cell, Trial, Until, components, motion
from uavbridge.radio.radio import Radio
from uavbridge.recording.recorder import Recorder
from uavbridge.runner.host import AgentHost
from uavbridge.runner.judge import Judge
from uavbridge.runner.stepped import fly_stepped

_SEARCHING = Phase.SEARCH.value
_NOT_YET = frozenset(
    phase.value for phase in (Phase.CONNECT, Phase.ARM, Phase.START, Phase.TAKEOFF, Phase.CLIMB)
)
_ENDED = frozenset(phase.value for phase in ENDED)
_PATIENCE_S = 120.0  # for the last to begin


class SearchJudge(Judge):
    """A judge that ends the flight with the search: nobody waits for the way home."""

    def __init__(self, mission: Mission, bus: Bus, until: Until) -> None:
        super().__init__(mission, bus)
        self._until = until
        self.began_us: int | None = None  # when nobody was on the way to its start any more
        self._team_size = len(mission.scenario().team)

    def step(self, t_us: int) -> None:
        super().step(t_us)
        if self.began_us is None and t_us % SECOND_US == 0:
            phases = [report.phase for report in self.reports.values()]
            begun = len(phases) == self._team_size and not set(phases) & _NOT_YET
            if begun or to_s(t_us) > _PATIENCE_S:
                self.began_us = t_us

    def ended(self, t_us: int) -> bool:
        if self.began_us is not None:
            late = t_us > self.began_us + to_us(self.mission.duration)
            there = bool(self.declared) if self._until == "named" else self.goal_reached
            if late or there:
                return True
        return super().ended(t_us)

    def since_start(self) -> dict[Cell, float]:
        """Cells declared, and the times (s) since the search began; 0: before that."""
        began = self.began_us or 0
        return {cell: max(0.0, to_s(one.t_us - began)) for cell, one in self.declared.items()}


def fly(
    mission: Mission,
    planner: Planner,
    until: Until = "goal",
    listen: Callable[[Bus], None] = lambda _bus: None,
) -> Trial:
    """One mission; the time of the trial begins with the search.

    Args:
        mission: with targets.
        planner: bound to its scenario.
        until: what ends the search.
        listen: is given a session of the mission's bus before the flight.
    """

    def judge_of(_longer: Mission, bus: Bus, _recorder: Recorder) -> SearchJudge:
        listen(bus)
        return SearchJudge(mission, bus, until)

    trial = Trial(mission.duration)
    radio = Radio(mission.radio.range_m, mission.seed)
    ages = Ages(mission.scenario().team)
    sent_before = 0

    def progress(t_us: int, judge: Judge, host: AgentHost) -> None:
        nonlocal sent_before
        assert isinstance(judge, SearchJudge)
        if judge.began_us is None or t_us % SECOND_US:
            if judge.began_us is None:
                sent_before = sum(report.bytes_sent for report in judge.reports.values())
            return
        values = _values(judge, host, radio, ages, t_us, sent_before)
        trial.add(to_s(t_us - judge.began_us), mission, values)

    # The time limit counts from the start of the search; the judge sees to it.
    longer = _with_duration(mission, mission.duration + _PATIENCE_S + 1.0)
    with Recorder(None, mission_name=mission.name, epoch_ns=0, mcap=False) as recorder:
        flown = fly_stepped(
            longer,
            planner,
            recorder=recorder,
            progress=progress,
            stop=lambda: False,
            judge_of=judge_of,
        )
    assert isinstance(flown.judge, SearchJudge)
    trial.declare(flown.judge.since_start(), mission)
    return trial


def _values(
    judge: SearchJudge, host: AgentHost, radio: Radio, ages: Ages, t_us: int, sent_before: int
) -> Map[str, float]:
    assert judge.began_us is not None
    last, t_s = judge.samples[-1], to_s(t_us - judge.began_us)
    hearings = {seat.agent.plan.agent: seat.agent.hearing for seat in host.seats}
    team = tuple(sorted(hearings))
    for agent in team:
        ages.heard(agent, hearings[agent].neighbours(t_us), t_s)
    here = np.array([judge.reports[agent].position for agent in team if agent in judge.reports])
    going = np.array([judge.reports[agent].velocity for agent in team if agent in judge.reports])
    sent = sum(report.bytes_sent for report in judge.reports.values()) - sent_before
    return {
        "coverage": last.coverage,
        "entropy": last.entropy,
        "uncertainty": last.uncertainty,
        "targets_found": float(last.found),
        "components": float(components(here, radio)),
        "age_s": ages.mean(t_s),
        "bytes_per_agent": sent / len(team),
        **motion(here, going),
    }


def _with_duration(mission: Mission, duration_s: float) -> Mission:
    from msgspec.structs import replace

    return replace(mission, duration=duration_s)
