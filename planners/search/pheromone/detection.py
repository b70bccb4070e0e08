"""Target detection and revisit by digital pheromones, as a planner.

Shao, Zhao, Li and Zhou 2020, "Target detection for multi-UAVs via digital pheromones and
navigation algorithm in unknown environments", section 4. The decisions are those of
``planners.pheromone.detect``, one UAV's row; the maps are kept by place agents or by copies of
the UAVs' own, as the mission's ``[pheromones]`` says. A target is a cell that the own belief map
declares; obstacles are the columns in sight.
"""

from __future__ import annotations

from dataclasses import dataclass

from numpy.random import Generator

from planners.planner import PlannerKind
from planners.search import flight
from planners.search.pheromone.params import PheromoneParams
from planners.search.pheromone.walk import Turn, Walk, WalkMemory, way_to
from planners.types import Goal, Scenario, Setpoint, View


@dataclass(frozen=True, slots=True)
class Detection:
    """The planner."""

    scenario: Scenario
    walk: Walk

    def init(self, view: View) -> WalkMemory:
        return self.walk.begin(view)

    def plan(self, view: View, memory: WalkMemory, rng: Generator) -> tuple[Goal, WalkMemory]:
        turn = self.walk.turn(view, memory, rng)
        after = turn.memory
        note = f"to cell {after.cell[0]},{after.cell[1]}" if not turn.stays else "walled in"
        setpoint = walking(self.scenario, view, turn, self.walk.params.speed_m_s)
        return Goal(setpoint, edits=turn.edits, asks=turn.asks, note=note), after


def walking(scenario: Scenario, view: View, turn: Turn, speed_m_s: float) -> Setpoint:
    """The setpoint of a walk: on to the next cell without stopping."""
    point = scenario.grid.centre_of(turn.memory.cell)
    if turn.stays:
        return flight.level_point(scenario, view, point, speed_m_s)
    return flight.level_velocity(scenario, view, way_to(view.position, point, speed_m_s))


def bind(scenario: Scenario, params: PheromoneParams) -> Detection:
    """The planner for one mission."""
    box = (0, 0, scenario.grid.columns, scenario.grid.rows)
    return Detection(scenario, Walk(scenario, params, box))


PHEROMONE = PlannerKind(
    "pheromone",
    "Detection and revisit by digital pheromones (Shao 2020, Eqs. 9-11)",
    PheromoneParams,
    bind,
)
