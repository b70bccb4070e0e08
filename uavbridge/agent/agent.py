"""One agent of a mission: ``step(inputs) -> effects``, at every control tick.

Order of a step: hear (frames, beacons), sense (readings into the belief map),
decide (the planner, at its own slower tick), fly (``Flight``), tell (frame,
beacon). No I/O: a runner feeds it and carries its effects out.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from planners.types import F64, Answer, Goal, Reading, Signal, View
from uavbridge.agent.effects import Decided, Effect, Inputs, Publish, Shine
from uavbridge.agent.flight import Flight
from uavbridge.agent.guidance import sound
from uavbridge.agent.hearing import Hearing
from uavbridge.agent.mapping import Mapping
from uavbridge.agent.phases import ENDED, Phase
from uavbridge.agent.plan import AgentPlan
from uavbridge.agent.telling import Telling
from uavbridge.bus.wire import Beacon, Frame
from uavbridge.clock import SECOND_US, to_us
from uavbridge.rng import stream
from uavbridge.safety.filter import Vector
from uavbridge.vehicle.api import VehicleState

BEACON_US = 200_000  # between two separation beacons
SLICE_US, SLICES = 100_000, 8  # all hear at one time; in which slice after it one takes that in

_log = logging.getLogger(__name__)


@dataclass(slots=True, eq=False)
class Sensed:
    """What the own sensors said since the last decision."""

    readings: list[Reading] = field(default_factory=list)
    signals: list[Signal] = field(default_factory=list)
    answers: list[Answer] = field(default_factory=list)


class Agent:
    """Joins a planner, a belief map and a vehicle."""

    def __init__(self, plan: AgentPlan) -> None:
        self.plan = plan
        self.flight = Flight(plan)
        self.mapping = Mapping(plan)
        self.hearing = Hearing()
        self.goal: Goal | None = None
        self.tick = 0  # decisions taken
        self.found: dict[int, int] = {}  # target -> t_us of its being reached
        self._tick_us = to_us(plan.scenario.tick_s)
        self._memory: Any = None
        self._sensed = Sensed()
        self._intake: list[tuple[Sequence[Frame], Sequence[Reading]]] = []  # not in the map yet
        self._next_decision_us = 0
        self._telling = Telling(plan, self.mapping)

    @property
    def phase(self) -> Phase:
        """What it is doing."""
        return self.flight.phase

    def remember(self, frames: Sequence[Frame]) -> None:
        """Learn from what this agent sent before its process died."""
        self.mapping.merge(frames)

    def step(self, inputs: Inputs) -> list[Effect]:
        """Everything this agent wants done now."""
        for frame in inputs.frames:
            self.hearing.frame(frame)
        for beacon in inputs.beacons:
            self.hearing.beacon(beacon)
        self._sensed.readings.extend(inputs.readings)
        self._learn(inputs)
        if inputs.obstacles and self.mapping.obstacles.learn(inputs.obstacles):
            self.flight.keep_off(self.mapping.obstacles.kept_off())
        self._sensed.answers.extend(inputs.answers)
        for signal in inputs.signals:
            self._sensed.signals.append(signal)
            if signal.arrived:
                self.found.setdefault(signal.target, signal.t_us)
        decided: list[Effect] = []
        if self._decides(inputs.t_us):
            decided = self._decide(inputs)
        setpoint = self.goal.setpoint if self.goal else None
        traffic = self.hearing.traffic(inputs.t_us)
        effects = self.flight.step(inputs, setpoint, traffic)
        return decided + effects + self._tell(inputs)

    def _learn(self, inputs: Inputs) -> None:
        """Frames and readings into the map: in their order, and before the map is looked at.

        Merging is most of an agent's work, and a team hears within one control tick. So each
        of a process's agents merges in a tick of its own.
        """
        t_us = inputs.t_us
        if inputs.frames or inputs.readings:
            self._intake.append((inputs.frames, inputs.readings))
        elif not self._intake:
            return
        mine = (t_us // SLICE_US + self.plan.agent) % SLICES == 0
        looked_at = t_us % SECOND_US == 0 or t_us % self._tick_us == 0
        if mine or looked_at or self._decides(t_us):
            for frames, readings in self._intake:
                if frames:
                    self.mapping.merge(frames)
                for reading in readings:
                    self.mapping.observe(reading)
            self._intake.clear()

    def _decides(self, t_us: int) -> bool:
        return self.phase is Phase.SEARCH and t_us >= self._next_decision_us

    def _decide(self, inputs: Inputs) -> list[Effect]:
        plan, tick = self.plan, self.tick
        decided: list[Effect] = []
        view = self._view(inputs)
        rng = stream(plan.seed, "planner", plan.agent, self.tick)
        try:
            if self.tick == 0:
                self._memory = plan.planner.init(view)
            goal, self._memory = plan.planner.plan(view, self._memory, rng)
            self.goal = sound(goal)
            decided.append(
                Decided(tick, view.position, view.velocity, view.heading_rad, goal, self._memory)
            )
        except Exception as fault:  # noqa: BLE001 - whatever a planner does, its vehicle comes home
            _log.debug("planner of agent %d", plan.agent, exc_info=True)
            self.flight.come_home(f"planner raised {type(fault).__name__}: {fault}", inputs.t_us)
        self._sensed = Sensed()
        self.tick += 1
        # On the tick's own raster, however late this decision came.
        self._next_decision_us = (inputs.t_us // self._tick_us + 1) * self._tick_us
        return decided

    def _view(self, inputs: Inputs) -> View:
        state = inputs.state
        return view_of(
            self.plan,
            self.tick,
            inputs.t_us,
            (state.position, state.velocity, state.heading_rad),
            self.hearing,
            self.mapping,
            self._sensed,
        )

    def _tell(self, inputs: Inputs) -> list[Effect]:
        """The frame at the planner's rate; the beacon five times a second, but landed."""
        state, t_us = inputs.state, inputs.t_us
        effects: list[Effect] = []
        if not state.has_position:
            return effects
        shines = (state.in_air or self.plan.drives) and t_us % BEACON_US == 0
        speaks = t_us % self._tick_us == 0 and self.phase not in ENDED
        if not (shines or speaks):
            return effects
        position, velocity = _vectors(state)
        if shines:
            effects.append(Shine(Beacon(self.plan.agent, t_us, position, velocity)))
        if speaks:
            # Who does not search any more is no part of the planners' plans.
            searches = self.phase is Phase.SEARCH
            payload = self.goal.payload if self.goal and searches else b""
            effects.append(Publish(self._telling.frame(t_us, position, velocity, payload)))
        return effects


def view_of(
    plan: AgentPlan,
    tick: int,
    t_us: int,
    own: tuple[F64, F64, float],
    hearing: Hearing,
    mapping: Mapping,
    sensed: Sensed,
) -> View:
    """What a planner is shown, in flight and when a recording is verified.

    Args:
        plan: of whose decision it is.
        tick: its number.
        t_us: mission time.
        own: position (3,) ENU m, velocity (3,) m/s, heading in rad.
        hearing: who was heard.
        mapping: the own map.
        sensed: since the last decision.
    """
    position, velocity, heading_rad = own
    terrain = plan.terrain
    return View(
        t_us=t_us,
        tick=tick,
        agent=plan.agent,
        position=position,
        velocity=velocity,
        heading_rad=heading_rad,
        neighbours=hearing.neighbours(t_us),
        belief=mapping.belief.probability,
        seen=mapping.belief.seen,
        readings=tuple(sensed.readings),
        answers=tuple(sensed.answers),
        signals=tuple(sensed.signals),
        terrain=None if terrain is None else terrain.around(position, plan.sensing_m),
        obstacles=mapping.obstacles.columns,
    )


def _vectors(state: VehicleState) -> tuple[Vector, Vector]:
    x, y, z = state.position.tolist()
    vx, vy, vz = state.velocity.tolist()
    return (x, y, z), (vx, vy, vz)
