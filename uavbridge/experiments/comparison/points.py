"""A mission with point masses or bare vehicle models; planners, maps and radio are the live ones.

What is missing against a flight: take-off, autopilot, MAVLink, safety filter. Agents
hear and map by the code of the live agent (``uavbridge.agent``), at the same ticks.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from planners.belief.maps import BeliefMap
from planners.belief.merge import unpack
from planners.belief.scores import coverage, entropy, uncertainty
from planners.planner import Planner
from planners.types import F64, FlySegment, FlyVelocity, Goal, Reading, Setpoint
from sim_vehicles.dynamics import MODELS, Setpoints, Wind, WindSpec
from uavbridge.agent.agent import view_of
from uavbridge.agent.guidance import sound, wanted
from uavbridge.agent.hearing import Hearing
from uavbridge.agent.mapping import Mapping
from uavbridge.agent.plan import AgentPlan
from uavbridge.agent.telling import Telling
from uavbridge.bus.wire import Frame, Vector, encode
from uavbridge.clock import SECOND_US, to_s, to_us
from uavbridge.config import Mission
from uavbridge.experiments.comparison.trial import Ages, Trial, components
from uavbridge.radio.radio import Radio
from uavbridge.rng import stream
from uavbridge.runner import assemble
from uavbridge.runner.control import CONTROL_US

_STEP_S = to_s(CONTROL_US)


class Bodies(Protocol):
    """What carries the agents."""

    @property
    def position(self) -> F64:
        """(n, 3) ENU m."""
        ...

    @property
    def velocity(self) -> F64:
        """(n, 3) m/s."""
        ...

    def fly(self, setpoints: list[Setpoint | None]) -> None:
        """One control step."""
        ...


class Points:
    """Point masses: they do what they are told, within the mission's speed."""

    def __init__(self, mission: Mission, plans: list[AgentPlan]) -> None:
        self.position: F64 = np.array([plan.start for plan in plans])
        self.velocity: F64 = np.zeros_like(self.position)
        self._speed = mission.safety.speed_m_s

    def fly(self, setpoints: list[Setpoint | None]) -> None:
        for row, setpoint in enumerate(setpoints):
            self.velocity[row] = self._velocity(row, setpoint)
        self.position = self.position + self.velocity * _STEP_S

    def _velocity(self, row: int, setpoint: Setpoint | None) -> F64:
        if setpoint is None:
            return np.zeros(3)
        if isinstance(setpoint, FlyVelocity):
            speed = float(np.hypot(setpoint.velocity[0], setpoint.velocity[1]))
            return setpoint.velocity * min(1.0, self._speed / max(speed, 1e-9))
        asked = self._speed if setpoint.speed_m_s is None else setpoint.speed_m_s
        if isinstance(setpoint, FlySegment):
            goal = _ahead(setpoint, self.position[row], min(asked, self._speed) * _STEP_S)
        else:
            goal = setpoint.position
        offset = goal - self.position[row]
        distance = float(np.sqrt(offset @ offset))
        pace = min(asked, self._speed, distance / _STEP_S)
        return np.asarray(offset / max(distance, 1e-9) * pace)


class Vehicles:
    """The mission's vehicle model, guided like a live vehicle but without autopilot and filter."""

    def __init__(self, mission: Mission, plans: list[AgentPlan]) -> None:
        start = np.array([plan.start for plan in plans])
        self._plans = plans
        self._model = MODELS[mission.fleet.model](start, np.full(len(plans), np.pi / 2.0))
        self._asked = Setpoints.idle(len(plans))
        self._asked.motors[:] = True
        self._steps = max(1, round(_STEP_S / mission.simulator.step_s))
        blows = mission.wind
        spec = WindSpec((blows.east_m_s, blows.north_m_s, blows.up_m_s), blows.gust_m_s)
        self._wind = Wind(spec, len(plans), stream(mission.seed, "wind"))

    @property
    def position(self) -> F64:
        return self._model.states.position

    @property
    def velocity(self) -> F64:
        return self._model.states.velocity

    def fly(self, setpoints: list[Setpoint | None]) -> None:
        for row, (plan, setpoint) in enumerate(zip(self._plans, setpoints, strict=True)):
            self._asked.velocity[row] = self._velocity(row, plan, setpoint)
        step_s = _STEP_S / self._steps
        for _ in range(self._steps):
            self._model.step(self._asked, self._wind.step(step_s), step_s)

    def _velocity(self, row: int, plan: AgentPlan, setpoint: Setpoint | None) -> Vector:
        if setpoint is None:
            return 0.0, 0.0, 0.0
        x, y, z = self.position[row].tolist()
        east, north, up = wanted(setpoint, (x, y, z), plan.start[2], plan.envelope)
        factor = min(1.0, plan.envelope.speed_m_s / max(float(np.hypot(east, north)), 1e-9))
        climb = plan.envelope.climb_m_s
        return east * factor, north * factor, min(max(up, -climb), climb)


@dataclass(slots=True, eq=False)
class Searcher:
    """One agent."""

    plan: AgentPlan
    mapping: Mapping
    telling: Telling
    hearing: Hearing = field(default_factory=Hearing)
    memory: Any = None
    goal: Goal | None = None
    readings: list[Reading] = field(default_factory=list)
    bytes_sent: int = 0

    @staticmethod
    def of(plan: AgentPlan) -> Searcher:
        """One that has seen nothing."""
        mapping = Mapping(plan)
        return Searcher(plan, mapping, Telling(plan, mapping))


class Search:
    """One mission under way."""

    def __init__(self, mission: Mission, planner: Planner, flown: bool) -> None:
        plans = assemble.agent_plans(mission.for_agents(), planner)
        agents = tuple(plan.agent for plan in plans)
        self.mission = mission
        self.team = agents
        self.bodies: Bodies = Vehicles(mission, plans) if flown else Points(mission, plans)
        self.agents = [Searcher.of(plan) for plan in plans]
        self.trial = Trial(mission.duration)
        self._sensor = assemble.sensor_of(mission, agents)
        self._radio = Radio(mission.radio.range_m, mission.seed)
        self._ages = Ages(agents)
        self._tick_us = to_us(mission.tick)
        self._air: list[Frame] = []  # sent at the last tick, in the order of the team
        self._where = self.bodies.position.copy()  # (n, 3) m, of everybody then
        self._rule = plans[0].rule.onlooker
        self.union: BeliefMap = self._rule.empty(mission.grid, plans[0].prior, plans[0].sensor)

    def run(self) -> Trial:
        """Until the goal is reached or the time is over."""
        end_us, t_us = to_us(self.mission.duration), 0
        while t_us <= end_us and np.isnan(self.trial.goal_s):
            self._look(t_us)
            if t_us % self._tick_us < CONTROL_US:
                self._hear()
                for row, agent in enumerate(self.agents):
                    self._decide(row, agent, t_us)
                self._tell(t_us)
            if t_us % SECOND_US == 0:
                self._sample(t_us)
            self.bodies.fly([None if a.goal is None else a.goal.setpoint for a in self.agents])
            t_us += CONTROL_US
        targets = set(self.mission.target_cells())
        self.trial.false_targets = len(self._declared() - targets)
        return self.trial

    def _look(self, t_us: int) -> None:
        for row, cell, detected in self._sensor.look(t_us, self.bodies.position):
            reading = Reading(t_us, cell, detected)
            self.agents[row].mapping.observe(reading)
            self.agents[row].readings.append(reading)

    def _hear(self) -> None:
        """Frames of the last tick, at all who were in range when they were sent."""
        reach = self._radio.reaches(self._where[:, None, :], self._where[None, :, :])
        for row, agent in enumerate(self.agents):
            heard = [
                frame
                for sender, frame in enumerate(self._air)
                if sender != row and reach[sender, row]
            ]
            for frame in heard:
                agent.hearing.frame(frame)
            agent.mapping.merge(heard)
        self._air = []

    def _decide(self, row: int, agent: Searcher, t_us: int) -> None:
        position, velocity = self.bodies.position[row].copy(), self.bodies.velocity[row].copy()
        moving = float(np.hypot(velocity[0], velocity[1])) > 0.1
        heading = float(np.arctan2(velocity[1], velocity[0])) if moving else np.pi / 2.0
        tick = t_us // self._tick_us
        own = (position, velocity, heading)
        view = view_of(
            agent.plan.agent, tick, t_us, own, agent.hearing, agent.mapping, agent.readings
        )
        if tick == 0:
            agent.memory = agent.plan.planner.init(view)
        rng = stream(self.mission.seed, "planner", agent.plan.agent, tick)
        goal, agent.memory = agent.plan.planner.plan(view, agent.memory, rng)
        agent.goal = sound(goal)
        agent.readings = []

    def _tell(self, t_us: int) -> None:
        where = self._where = self.bodies.position.copy()
        for row, agent in enumerate(self.agents):
            x, y, z = where[row].tolist()
            vx, vy, vz = self.bodies.velocity[row].tolist()
            payload = agent.goal.payload if agent.goal else b""
            frame = agent.telling.frame(t_us, (x, y, z), (vx, vy, vz), payload)
            agent.bytes_sent += len(encode(frame))
            self._air.append(frame)
            records = unpack(self._rule, frame.cells)
            if records is not None and len(records):
                self.union, _ = self._rule.merge(self.union, records)

    def _declared(self) -> set[tuple[int, int]]:
        rows = self.mission.grid.rows
        return {
            (cell // rows, cell % rows) for agent in self.agents for cell in agent.mapping.declared
        }

    def _sample(self, t_us: int) -> None:
        t_s = to_s(t_us)
        targets = set(self.mission.target_cells())

        for agent in self.agents:
            self._ages.heard(agent.plan.agent, agent.hearing.neighbours(t_us), t_s)
        sent = sum(agent.bytes_sent for agent in self.agents)
        self.trial.add(
            t_s,
            self.mission,
            {
                "coverage": float(coverage(self.union.seen)),
                "entropy": float(entropy(self.union.probability)),
                "uncertainty": float(uncertainty(self.union.probability)),
                "targets_found": float(len(self._declared() & targets)),
                "components": float(components(self.bodies.position, self._radio)),
                "age_s": self._ages.mean(t_s),
                "bytes_per_agent": sent / len(self.team),
            },
        )


def _ahead(segment: FlySegment, position: F64, way_m: float) -> F64:
    """The point of a segment that lies ``way_m`` beyond the one nearest to a position."""
    along = segment.end - segment.start
    length = float(np.sqrt(along @ along))
    if length < 1e-9:
        return segment.end
    unit = along / length
    done = float((position - segment.start) @ unit) + way_m
    return np.asarray(segment.start + unit * min(max(done, 0.0), length))
