"""The whole scenario as a planner: a leader brings the rest to the region, then all detect.

Shao, Zhao, Li and Zhou 2020, sections 3 to 5. The team's lowest id leads by vector pheromones
(Algorithm 2), the others follow by the modified Olfati-Saber rule (Algorithm 3); once the leader
is at the target region's centre, all turn to detection and revisit inside it (Algorithm 1). That
it is there rides on the frames. Who has not heard of a lower id for a while leads.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from planners.pheromone.lead import cell_of
from planners.pheromone.words import ASK, Local, decode_local, encode_query
from planners.planner import PlannerKind
from planners.search import flight
from planners.search.pheromone.detection import walking
from planners.search.pheromone.params import ScenarioParams
from planners.search.pheromone.travel import Travel, in_cells
from planners.search.pheromone.walk import Walk, WalkMemory, edits_of, new_columns, way_to
from planners.types import F64, I64, Ask, FlyVelocity, Goal, Scenario, View

THERE, UNDER_WAY = b"\x01", b"\x00"
PATIENCE = 5  # ticks that a leader waits for an answer before it goes on without
_NO_CELLS: I64 = np.zeros((0, 2), np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class ScenarioMemory:
    """Of leader, follower and detecting UAV."""

    there: bool  # the region is reached: detection
    lower: int  # tick at which a lower id was last heard
    goal: F64  # (2,) where a leader's step ends, cells
    way: F64  # (2,) cells in a step
    waits: int  # ticks that a leader has stood at the end of its step
    local: bytes  # the field there; empty: not known
    told: I64  # (k,) flat cells of obstacles told
    walk: WalkMemory


@dataclass(frozen=True, slots=True)
class PheromoneScenario:
    """The planner."""

    scenario: Scenario
    params: ScenarioParams
    travel: Travel
    walk: Walk

    @property
    def step_s(self) -> float:
        """Time of a leader's step."""
        return self.params.length * self.scenario.grid.cell_m / self._pace

    @property
    def _pace(self) -> float:
        return self.params.leader_share * self.params.speed_m_s

    def init(self, view: View) -> ScenarioMemory:
        place = in_cells(self.scenario.grid, view.position)
        told = np.zeros(0, np.int64)
        walk = self.walk.begin(view)
        return ScenarioMemory(False, 0, place, np.zeros(2), 0, b"", told, walk)

    def plan(
        self, view: View, memory: ScenarioMemory, rng: Generator
    ) -> tuple[Goal, ScenarioMemory]:
        lower, there = self._heard(view)
        memory = replace(memory, lower=view.tick if lower else memory.lower)
        if there and not memory.there:
            memory = self._arrived(view, memory)
        if memory.there:
            return self._detect(view, memory, rng)
        if self._leads(view, memory):
            return self._lead(view, memory)
        return self._follow(view, memory)

    def _heard(self, view: View) -> tuple[bool, bool]:
        """Whether a lower id was heard lately, and whether somebody is at the region."""
        heard = view.neighbours
        fresh = heard.age_s <= self.params.forget_s
        lower = bool((fresh & (heard.ids < view.agent)).any())
        known = min(len(heard), len(heard.payloads))
        told = [heard.payloads[i] == THERE for i in range(known) if fresh[i]]
        return lower, any(told)

    def _leads(self, view: View, memory: ScenarioMemory) -> bool:
        first = view.agent == self.scenario.team[0]
        silence_s = (view.tick - memory.lower) * self.scenario.tick_s
        return first or silence_s > self.params.forget_s

    def _arrived(self, view: View, memory: ScenarioMemory) -> ScenarioMemory:
        walk = replace(self.walk.begin(view), told=memory.told)
        return replace(memory, there=True, walk=walk, local=b"")

    def _detect(
        self, view: View, memory: ScenarioMemory, rng: Generator
    ) -> tuple[Goal, ScenarioMemory]:
        turn = self.walk.turn(view, memory.walk, rng)
        cell = turn.memory.cell
        setpoint = walking(self.scenario, view, turn, self.params.speed_m_s)
        note = f"detects, to cell {cell[0]},{cell[1]}"
        goal = Goal(setpoint, THERE, turn.edits, turn.asks, note)
        return goal, replace(memory, walk=turn.memory)

    def _lead(self, view: View, memory: ScenarioMemory) -> tuple[Goal, ScenarioMemory]:
        grid, cell_m = self.scenario.grid, self.scenario.grid.cell_m
        here = in_cells(grid, view.position)
        if not grid.contains(view.position) or memory.waits < 0:
            memory = replace(memory, goal=in_cells(grid, grid.clip(view.position[:2])), waits=0)
        local = self._answer(view, memory)
        apart = float(np.hypot(*(memory.goal - here))) * cell_m
        near = max(self.params.capture * cell_m, 0.6 * self._pace * self.scenario.tick_s)
        point = self._point(memory.goal)
        if apart > near:
            goal = Goal(self._towards(view, point), UNDER_WAY, (), self._asks(memory), "leads")
            return goal, memory
        if not memory.local and local is None and memory.waits < PATIENCE:
            still = flight.level_velocity(self.scenario, view, np.zeros(2))
            goal = Goal(still, UNDER_WAY, (), self._asks(memory), "leads, asks the way")
            return goal, replace(memory, waits=memory.waits + 1)
        return self._step(view, memory, local)

    def _step(
        self, view: View, memory: ScenarioMemory, local: Local | None
    ) -> tuple[Goal, ScenarioMemory]:
        """The leader has come to the end of a step: the next one."""
        grid = self.scenario.grid
        columns = self._columns(view)
        way = self.travel.led(memory.goal, memory.way, local, columns)
        centre = np.array(self.travel.centre)
        if float(np.hypot(*(memory.goal - centre))) < self.params.capture:
            memory = self._arrived(view, memory)
            still = flight.level_velocity(self.scenario, view, np.zeros(2))
            return Goal(still, THERE, (), (), "has reached the region"), memory
        edge = np.array(grid.shape) - 1.0
        end = np.clip(memory.goal + way, 0.0, edge)
        fresh, told = new_columns(
            self.travel.closed_near(memory.goal, columns), memory.told, grid.rows
        )
        after = replace(memory, goal=end, way=way, waits=0, local=b"", told=told)
        edits = edits_of(cell_of(end)[None], fresh, _NO_CELLS)
        setpoint = self._towards(view, self._point(end))
        return Goal(setpoint, UNDER_WAY, edits, self._asks(after), "leads"), after

    def _answer(self, view: View, memory: ScenarioMemory) -> Local | None:
        """The field at the end of the leader's step, if it has been told."""
        cell = tuple(cell_of(memory.goal).tolist())
        for answer in view.answers:
            local = decode_local(answer.data) if answer.key == ASK else None
            if local is not None and local.cell == cell and local.radius == self._radius:
                return local
        return None

    @property
    def _radius(self) -> int:
        return self.params.leader_sensor + 1

    def _asks(self, memory: ScenarioMemory) -> tuple[Ask, ...]:
        column, row = cell_of(memory.goal).tolist()
        return (Ask(ASK, encode_query((column, row), self._radius)),)

    def _follow(self, view: View, memory: ScenarioMemory) -> tuple[Goal, ScenarioMemory]:
        grid, scale = self.scenario.grid, self.step_s / self.scenario.grid.cell_m
        heard = view.neighbours
        order = np.argsort(heard.ids, kind="stable")
        order = order[heard.age_s[order] <= self.params.forget_s]
        sound = np.isfinite(heard.position[order]).all(axis=-1)
        order = order[sound & np.isfinite(heard.velocity[order]).all(axis=-1)]
        if not len(order):
            still = flight.level_velocity(self.scenario, view, np.zeros(2))
            return Goal(still, UNDER_WAY, note="hears nobody"), memory
        carried = heard.position[order] + heard.velocity[order] * heard.age_s[order, None]
        places, ways = in_cells(grid, carried), heard.velocity[order, :2] * scale
        here = in_cells(grid, view.position)
        columns = self._columns(view)
        whole = self.travel.followed(
            here, memory.way, (places[1:], ways[1:]), (places[0], ways[0]), columns
        )
        share = min(1.0, self.scenario.tick_s / self.step_s)
        way = memory.way + share * (whole - memory.way)
        velocity = self._inside(view, way / scale)
        kept = velocity.velocity[:2] * scale
        note = f"follows {int(heard.ids[order[0]])}"
        return Goal(velocity, UNDER_WAY, note=note), replace(memory, way=kept, waits=-1)

    def _inside(self, view: View, velocity: F64) -> FlyVelocity:
        velocity = flight.limit(velocity, self.params.speed_m_s, "norm")
        kept = flight.turn_back(
            view.position[:2], velocity, self.scenario.grid, self.scenario.tick_s, 0.0, "component"
        )
        return flight.level_velocity(self.scenario, view, kept)

    def _towards(self, view: View, point: F64) -> FlyVelocity:
        return flight.level_velocity(self.scenario, view, way_to(view.position, point, self._pace))

    def _point(self, place: F64) -> F64:
        grid = self.scenario.grid
        return np.asarray((place + 0.5) * grid.cell_m + (grid.west_m, grid.south_m))

    def _columns(self, view: View) -> F64:
        return np.concatenate((self.scenario.obstacles, view.obstacles))


def region_of(scenario: Scenario, share: float) -> tuple[int, int, int, int]:
    """West, south, east, north: cells of the target region, in the area's north-east."""
    columns, rows = scenario.grid.shape
    wide, high = max(1, round(columns * share)), max(1, round(rows * share))
    return columns - wide, rows - high, columns, rows


def bind(scenario: Scenario, params: ScenarioParams) -> PheromoneScenario:
    """The planner for one mission."""
    west, south, east, north = box = region_of(scenario, params.region)
    travel = Travel(scenario.grid, params, ((west + east) // 2, (south + north) // 2))
    return PheromoneScenario(scenario, params, travel, Walk(scenario, params, box))


PHEROMONE_SCENARIO = PlannerKind(
    "pheromone-scenario",
    "Leader and followers go to a region, then all detect and revisit (Shao 2020, sections 3-5)",
    ScenarioParams,
    bind,
)
