"""Missions with point masses or bare vehicle models; planners, maps and radio are the live ones.

What is missing against a flight: take-off, autopilot, MAVLink, safety filter. Agents
hear and map by the code of the live agent (``uavbridge.agent``), at the same ticks; pheromone
maps are copies, whatever the mission says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from planners.belief.maps import BeliefMap
from planners.belief.merge import unpack
from planners.belief.scores import coverage, entropy, uncertainty
from planners.planner import Planner
from planners.types import F64, Goal, Reading, Setpoint, Signal
from uavbridge.agent.agent import Sensed, view_of
from uavbridge.agent.guidance import sound
from uavbridge.agent.hearing import Hearing
from uavbridge.agent.mapping import Mapping
from uavbridge.agent.plan import AgentPlan
from uavbridge.agent.telling import Telling
from uavbridge.bus.ether import Ether
from uavbridge.clock import SECOND_US, to_s, to_us
from uavbridge.config import Mission
from uavbridge.config.radio import radio_of
from uavbridge.experiments.comparison.bodies import Bodies, Flock, Points, Vehicles
from uavbridge.experiments.comparison.trial import Ages, Cell, Trial, Until, components, motion
from uavbridge.rng import stream
from uavbridge.runner import assemble, places
from uavbridge.runner.ticks import CONTROL_US


@dataclass(slots=True, eq=False)
class Searcher:
    """One agent."""

    plan: AgentPlan
    mapping: Mapping
    telling: Telling
    hearing: Hearing = field(default_factory=Hearing)
    memory: Any = None
    goal: Goal | None = None
    sensed: Sensed = field(default_factory=Sensed)

    @staticmethod
    def of(plan: AgentPlan) -> Searcher:
        """One that has seen nothing."""
        mapping = Mapping(plan)
        return Searcher(plan, mapping, Telling(plan, mapping))


class Search:
    """One mission under way; what carries its agents tells it where they are."""

    def __init__(self, mission: Mission, planner: Planner) -> None:
        self.plans = assemble.agent_plans(mission.for_agents(), planner)
        agents = tuple(plan.agent for plan in self.plans)
        self.mission = mission
        self.team = agents
        self.agents = [Searcher.of(plan) for plan in self.plans]
        self.trial = Trial(mission.duration)
        self._receiver = assemble.receiver_of(mission, agents)
        self._sensor = None if self._receiver else assemble.sensor_of(mission, agents)
        self._detector = assemble.detector_of(mission, agents)
        self._hidden = assemble.hidden_of(mission)
        self._radio = radio_of(mission)
        self._ether = Ether(self._radio, agents)
        self._ages = Ages(agents)
        self._copies = places.copies_of(mission, None, agents)
        self._reached: set[int] = set()  # targets that give signals
        self._tick_us = to_us(mission.tick)
        self._position = self._velocity = np.zeros((len(agents), 3))
        first = self.plans[0]
        self._rule = first.rule.onlooker
        self.union: BeliefMap = self._rule.empty(mission.grid, first.prior, first.sensor)

    def step(self, t_us: int, position: F64, velocity: F64) -> list[Setpoint | None]:
        """One control step of agents at positions (n, 3) m with velocities (n, 3) m/s."""
        self._position, self._velocity = position, velocity
        self._sense(t_us)
        if t_us % self._tick_us < CONTROL_US:
            self._hear(t_us)
            for row, agent in enumerate(self.agents):
                self._decide(row, agent, t_us)
            self._tell(t_us)
        if self._copies is not None:
            self._copies.step(t_us)
        if t_us % SECOND_US == 0:
            self._sample(t_us)
        return [None if agent.goal is None else agent.goal.setpoint for agent in self.agents]

    def finish(self) -> Trial:
        """How it went."""
        self.trial.declare(self._declared(), self.mission)
        return self.trial

    def _sense(self, t_us: int) -> None:
        if self._sensor is not None:
            for row, cell, detected in self._sensor.look(t_us, self._position):
                reading = Reading(t_us, cell, detected)
                self.agents[row].mapping.observe(reading)
                self.agents[row].sensed.readings.append(reading)
        if self._receiver is not None:
            for one in self._receiver.listen(t_us, self._position):
                signal = Signal(t_us, one.target, one.strength, one.arrived)
                self.agents[one.vehicle].sensed.signals.append(signal)
                if one.arrived:
                    self._reached.add(one.target)

        for seen in self._detector.look(t_us, self._position) if self._detector else ():
            self.agents[seen.vehicle].mapping.obstacles.learn([self._hidden[seen.column]])

    def _hear(self, t_us: int) -> None:
        """Frames of the last tick, and of earlier ones that are due."""
        frames = dict(zip(self.team, self._ether.receive(t_us), strict=True))
        answers = {} if self._copies is None else self._copies.receive({}, frames, t_us)
        for agent in self.agents:
            heard = frames[agent.plan.agent]
            for frame in heard:
                agent.hearing.frame(frame)
            agent.mapping.merge(heard)
            agent.sensed.answers += answers.get(agent.plan.agent, [])

    def _decide(self, row: int, agent: Searcher, t_us: int) -> None:
        position, velocity = self._position[row].copy(), self._velocity[row].copy()
        moving = float(np.hypot(velocity[0], velocity[1])) > 0.1
        heading = float(np.arctan2(velocity[1], velocity[0])) if moving else np.pi / 2.0
        tick = t_us // self._tick_us
        own = (position, velocity, heading)
        view = view_of(agent.plan, tick, t_us, own, agent.hearing, agent.mapping, agent.sensed)
        if tick == 0:
            agent.memory = agent.plan.planner.init(view)
        rng = stream(self.mission.seed, "planner", agent.plan.agent, tick)
        goal, agent.memory = agent.plan.planner.plan(view, agent.memory, rng)
        agent.goal = sound(goal)
        if self._copies is not None:
            x, y, z = position.tolist()
            self._copies.wish(agent.plan.agent, agent.goal, tick, (x, y, z), t_us)
        agent.sensed = Sensed()

    def _tell(self, t_us: int) -> None:
        frames = []
        for row, agent in enumerate(self.agents):
            x, y, z = self._position[row].tolist()
            vx, vy, vz = self._velocity[row].tolist()
            payload = agent.goal.payload if agent.goal else b""
            frame = agent.telling.frame(t_us, (x, y, z), (vx, vy, vz), payload)
            frames.append(frame if self._copies is None else self._copies.outgoing(frame))
            records = unpack(self._rule, frame.cells)
            if records is not None and len(records):
                self.union, _ = self._rule.merge(self.union, records)
        self._ether.send(frames, self._position)

    def _declared(self) -> dict[Cell, float]:
        first: dict[int, int] = {}
        for agent in self.agents:
            for cell, t_us in agent.mapping.declared.items():
                first[cell] = min(t_us, first.get(cell, t_us))
        rows = self.mission.grid.rows
        return {(cell // rows, cell % rows): to_s(t_us) for cell, t_us in first.items()}

    def _sample(self, t_us: int) -> None:
        t_s = to_s(t_us)
        self.trial.declare(self._declared(), self.mission)
        found = len(self._reached)
        if self._receiver is None:
            found = sum(cell in self.trial.declared for cell in self.mission.target_cells())
        for agent in self.agents:
            self._ages.heard(agent.plan.agent, agent.hearing.neighbours(t_us), t_s)
        sent = sum(account.bytes_sent for account in self._ether.traffic.values())
        self.trial.add(
            t_s,
            self.mission,
            {
                "coverage": float(coverage(self.union.seen)),
                "entropy": float(entropy(self.union.probability)),
                "uncertainty": float(uncertainty(self.union.probability)),
                "targets_found": float(found),
                "components": float(components(self._position, self._radio)),
                "age_s": self._ages.mean(t_s),
                "bytes_per_agent": sent / len(self.team),
                **motion(self._position, self._velocity),
            },
        )


def fly(
    missions: Sequence[tuple[Mission, Planner]], *, flown: bool, until: Until = "goal"
) -> list[Trial]:
    """Missions side by side, each until it has what it is for, or its time is over.

    Args:
        missions: with bound planners; equal in vehicles, terrain and simulator.
        flown: with vehicle models, else with point masses.
        until: what ends a search.
    """
    return run([Search(mission, planner) for mission, planner in missions], flown, until)


def run(searches: Sequence[Search], flown: bool, until: Until = "goal") -> list[Trial]:
    """Like ``fly``, for searches that have not begun."""
    flocks = [Flock(search.mission, search.plans) for search in searches]
    bodies: Bodies = Vehicles(flocks) if flown else Points(flocks)
    ends = np.cumsum([len(search.team) for search in searches])
    rows = [slice(end - len(each.team), end) for each, end in zip(searches, ends, strict=True)]
    going, t_us = list(range(len(searches))), 0
    setpoints: list[Setpoint | None] = [None] * int(ends[-1])
    while going:
        for place in going:
            mine = rows[place]
            told = searches[place].step(t_us, bodies.position[mine], bodies.velocity[mine])
            setpoints[mine] = told
        bodies.fly(setpoints)
        t_us += CONTROL_US
        for place in [each for each in going if _over(searches[each], t_us, until)]:
            going.remove(place)
            setpoints[rows[place]] = [None] * len(searches[place].team)
    return [search.finish() for search in searches]


def _over(search: Search, t_us: int, until: Until) -> bool:
    return t_us > to_us(search.mission.duration) or search.trial.over(until)
