"""The search in mountains as a planner: one robot's row of ``step``.

Zhou 2023, sections 3 and 4. What a robot knows of others is their frames: position,
and as the planner's payload its suballiance messages (``payload.py``). Without terrain
in the view the ground is level. Robots keep the height above ground that they start at.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from planners.planner import PlannerKind
from planners.search import flight
from planners.search.mountain import payload
from planners.search.mountain.decide import Rules
from planners.search.mountain.params import MountainParams
from planners.search.mountain.payload import Told
from planners.search.mountain.state import (
    DRAWS,
    Draws,
    Heard,
    Messages,
    Robots,
    Sensed,
    fresh,
)
from planners.search.mountain.step import step
from planners.terrain import Terrain, flat
from planners.types import F64, I64, FlyVelocity, Goal, Scenario, View


@dataclass(frozen=True, slots=True, eq=False)
class MountainMemory:
    """Targets that the robot knows of, ascending, and its state, leading axis (1,)."""

    targets: I64  # (T,)
    robots: Robots  # its task is a column of ``targets``


@dataclass(frozen=True, slots=True)
class _Neighbour:
    id: int
    position: F64  # (3,) m, carried forward, on the ground
    told: Told


@dataclass(frozen=True, slots=True)
class Mountain:
    """The planner."""

    scenario: Scenario
    params: MountainParams
    rules: Rules

    def init(self, view: View) -> MountainMemory:
        heading = view.heading_rad
        way = np.array([[np.cos(heading), np.sin(heading), 0.0]])
        robots = fresh((1,), 0, self.params.members, way * self.rules.speed_m)
        return MountainMemory(np.zeros(0, np.int64), robots)

    def plan(
        self, view: View, memory: MountainMemory, rng: Generator
    ) -> tuple[Goal, MountainMemory]:
        ground = flat(self.scenario.grid.bounds) if view.terrain is None else view.terrain
        others = tuple(self._others(view))
        targets = _targets(view, memory, others)
        robots = _renumbered(memory, targets)
        place = np.array([[*view.position[:2], ground.height_at(view.position)]])
        velocity, after = step(
            np.array([view.agent]),
            robots,
            _sensed(view, place, targets),
            _heard(view.agent, place[0], robots, others, targets, self.params.members),
            Draws.of(rng.random((1, DRAWS))),
            ground,
            self.scenario.grid.bounds,
            self.rules,
        )
        told = payload.encode(_told(after, targets), view.tick)
        goal = Goal(self._setpoint(view, velocity[0]), payload=told, note=_note(after, targets))
        return goal, MountainMemory(targets, after)

    def _others(self, view: View) -> Iterator[_Neighbour]:
        """Those heard lately, ascending id."""
        heard = view.neighbours
        for row in np.argsort(heard.ids, kind="stable"):
            place = heard.position[row] + heard.velocity[row] * heard.age_s[row]
            one = int(heard.ids[row])
            if heard.age_s[row] > self.params.forget_s or not np.isfinite(place).all():
                continue
            if view.terrain is None:
                place = np.array((*place[:2], 0.0))
            elif one in self.scenario.team:
                place = place - (0.0, 0.0, flight.altitude(self.scenario, one))
            data = heard.payloads[row] if row < len(heard.payloads) else b""
            yield _Neighbour(one, place, payload.decode(data, self.params.members))

    def _setpoint(self, view: View, velocity: F64) -> FlyVelocity:
        """The velocity (3,) in m a step, as m/s inside the limits, at the height above ground."""
        case = self.scenario
        planar = velocity[:2] / case.tick_s
        if not case.grid.contains(view.position):
            planar = flight.turn_back(
                view.position[:2], planar, case.grid, case.tick_s, 0.0, "component"
            )
        if view.terrain is None:
            return flight.level_velocity(case, view, planar)
        return _above(view.terrain, case, view, planar)


def _above(terrain: Terrain, case: Scenario, view: View, planar: F64) -> FlyVelocity:
    limits = case.limits
    planar = flight.limit(planar, limits.speed_m_s, "norm")
    ahead = view.position[:2] + planar * case.tick_s
    wanted = float(terrain.height_at(ahead)) + flight.altitude(case, view.agent)
    climb = (wanted - float(view.position[2])) / case.tick_s
    climb = max(-limits.climb_m_s, min(limits.climb_m_s, climb))
    return FlyVelocity(np.array((planar[0], planar[1], climb)))


def _targets(view: View, memory: MountainMemory, others: tuple[_Neighbour, ...]) -> I64:
    """All targets that matter now, ascending: heard, told of, worked for, found."""
    known = {one.target for one in view.signals}
    kept = memory.robots.told.found[0].copy()
    if memory.robots.told.task[0] >= 0:
        kept[memory.robots.told.task[0]] = True
    known.update(memory.targets[kept].tolist())
    for other in others:
        known.update(other.told.found)
        if other.told.task >= 0:
            known.add(other.told.task)
    return np.array(sorted(known), dtype=np.int64)


def _renumbered(memory: MountainMemory, targets: I64) -> Robots:
    robots = memory.robots
    found = np.zeros((1, len(targets)), np.bool_)
    found[0] = np.isin(targets, memory.targets[robots.told.found[0]])
    task = robots.told.task
    if task[0] >= 0:
        task = np.searchsorted(targets, memory.targets[task])
    return replace(robots, told=replace(robots.told, task=task, found=found))


def _sensed(view: View, place: F64, targets: I64) -> Sensed:
    strength = np.zeros((1, len(targets)))
    heard = np.zeros(strength.shape, np.bool_)
    arrived = np.zeros(strength.shape, np.bool_)
    for one in view.signals:
        column = int(np.searchsorted(targets, one.target))
        strength[0, column] = one.strength if np.isfinite(one.strength) else 0.0
        heard[0, column] = True
        arrived[0, column] |= one.arrived
    return Sensed(place, strength, heard, arrived)


def _heard(
    own: int,
    place: F64,
    robots: Robots,
    others: tuple[_Neighbour, ...],
    targets: I64,
    members: int,
) -> Heard:
    """Messages of others and the robot's own, ascending id, leading axis (1,)."""
    k = len(others) + 1
    ids = np.array([own, *(other.id for other in others)], dtype=np.int64)
    places = np.array([place, *(other.position for other in others)])
    rows = fresh((k,), len(targets), members, np.zeros((k, 3))).told.map(np.copy)
    rows.free[1:] = [other.told.free for other in others]
    columns = {target: column for column, target in enumerate(targets.tolist())}
    for row, other in enumerate(others, 1):
        told = other.told
        rows.task[row] = columns[told.task] if told.task >= 0 else -1
        rows.first[row], rows.leads[row] = told.first, told.leads
        rows.strength[row], rows.best[row] = told.strength, told.best
        rows.best_place[row] = told.best_place
        rows.roster[row, : len(told.roster)] = told.roster
        rows.found[row, [columns[target] for target in told.found]] = True
    mine = robots.told
    table = Messages(
        *(
            np.concatenate((getattr(mine, name), getattr(rows, name)[1:]))
            for name in Messages.__slots__
        )
    )
    order = np.argsort(ids, kind="stable")
    messages = table.map(lambda part: part[order][None])
    known = np.ones((1, k), np.bool_)
    return Heard(ids[order][None], places[order][None], known, messages)


def _told(robots: Robots, targets: I64) -> Told:
    told = robots.told
    task = int(told.task[0])
    roster = tuple(one for one in told.roster[0].tolist() if one >= 0)
    return Told(
        int(targets[task]) if task >= 0 else -1,
        bool(told.first[0]),
        bool(told.free[0]),
        bool(told.leads[0]),
        float(told.strength[0]),
        float(told.best[0]),
        (float(told.best_place[0, 0]), float(told.best_place[0, 1]), float(told.best_place[0, 2])),
        roster,
        tuple(targets[told.found[0]].tolist()),
    )


def _note(robots: Robots, targets: I64) -> str:
    told = robots.told
    if not robots.member[0]:
        return "resting, roams" if robots.rest[0] > 0 else "roams"
    target = int(targets[told.task[0]])
    if told.leads[0]:
        return f"leads {int((told.roster[0] >= 0).sum())} to target {target}"
    return f"class {'I' if told.first[0] else 'II'} at target {target}"


def bind(scenario: Scenario, params: MountainParams) -> Mountain:
    """The search in mountains for one mission."""
    held = replace(params, speed_m_s=min(params.speed_m_s, scenario.limits.speed_m_s))
    return Mountain(scenario, held, Rules.of(held, scenario.radio_range_m, scenario.tick_s))


MOUNTAIN = PlannerKind(
    "mountain",
    "Suballiances that home in on target signals, slopes avoided (Zhou 2023, Eqs. 1-29)",
    MountainParams,
    bind,
)
