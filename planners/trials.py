"""Made-up scenarios and views on which the conformance suite tries a planner."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator

from planners.grid import Grid
from planners.types import (
    F64,
    MICROSECONDS,
    Bools,
    FlySegment,
    FlyVelocity,
    GoTo,
    Limits,
    Neighbours,
    Reading,
    Scenario,
    Setpoint,
    Signal,
    View,
)

GRIDS = (
    Grid(0.0, 0.0, 100.0, 10, 10),
    Grid(-350.0, 120.0, 50.0, 1, 7),
    Grid(1000.0, -2000.0, 25.0, 9, 2),
    Grid(-20.0, -20.0, 40.0, 1, 1),
)
TEAMS = (1, 2, 10, 13)


def scenario(grid: Grid = GRIDS[0], agents: int = 10, tick_s: float = 1.0) -> Scenario:
    """A search whose agents start in the grid's cells, in their order, over and over."""
    number = np.arange(agents) % grid.size
    cells = np.stack(np.divmod(number, grid.rows), axis=-1)
    height = 40.0 + 5.0 * np.arange(agents) % 30.0
    starts = np.concatenate((grid.centre_of(cells), height[:, None]), axis=-1)
    team = tuple(range(1, agents + 1))
    return Scenario(grid, team, starts, tick_s, Limits(), 0.95, 400.0)


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """A point mass that obeys a planner, and what it sees on its way."""

    case: Scenario
    agent: int
    seed: int
    ticks: int = 40

    def views(self, answer: Answers) -> Iterator[View]:
        """Views tick by tick; ``answer.setpoint`` must be set after each."""
        draw = np.random.default_rng([self.seed, self.agent])
        position = self.case.starts[self.case.index(self.agent)].copy()
        velocity = np.zeros(3)
        probability = np.full(self.case.grid.shape, 0.5)
        seen = np.zeros(self.case.grid.shape, np.bool_)
        for tick in range(self.ticks):
            readings = self._look(draw, position, probability, seen, tick)
            yield made_up(
                self.case, self.agent, tick, position, velocity, probability, seen, readings, draw
            )
            velocity = _flown(answer.setpoint, position, self.case)
            position = position + velocity * self.case.tick_s

    def _look(
        self, draw: Generator, position: F64, probability: F64, seen: Bools, tick: int
    ) -> tuple[Reading, ...]:
        column, row = self.case.grid.cell_of(position)
        if not self.case.grid.inside((column, row)):
            return ()
        cell = (int(column), int(row))
        detected = bool(draw.random() < 0.15)
        value = float(probability[cell])
        ratio = 18.0 if detected else 0.105
        probability[cell] = value * ratio / (value * ratio + 1.0 - value)
        seen[cell] = True
        return (Reading(round(tick * self.case.tick_s * MICROSECONDS), cell, detected),)


@dataclass(slots=True)
class Answers:
    """Where the caller of ``Flight.views`` puts the planner's last setpoint."""

    setpoint: Setpoint | None = None


def made_up(
    case: Scenario,
    agent: int,
    tick: int,
    position: F64,
    velocity: F64,
    belief: F64,
    seen: Bools,
    readings: tuple[Reading, ...],
    draw: Generator,
) -> View:
    """A read-only view with some of the team heard somewhere around."""
    others = np.array([one for one in case.team if one != agent], dtype=np.int64)
    others = others[draw.random(len(others)) < 0.7]
    around = np.concatenate(
        (draw.normal(0.0, 120.0, (len(others), 2)), draw.normal(0.0, 5.0, (len(others), 1))), -1
    )
    heard = Neighbours(
        others,
        position + around,
        draw.normal(0.0, 4.0, (len(others), 3)),
        draw.uniform(0.0, 3.0, len(others)),
        (b"",) * len(others),
    )
    heading = float(np.arctan2(velocity[1], velocity[0]))
    t_us = round(tick * case.tick_s * MICROSECONDS)
    view = View(
        t_us,
        tick,
        agent,
        position.copy(),
        velocity.copy(),
        heading,
        heard,
        belief.copy(),
        seen.copy(),
        readings,
        signals=tuple(_signals(case, agent, tick, t_us)),
    )
    read_only(view)
    return view


def _signals(case: Scenario, agent: int, tick: int, t_us: int) -> Iterator[Signal]:
    """Of three targets, each heard about every other tick; draws of their own."""
    draw = np.random.default_rng([agent, tick, case.grid.size])
    for target, heard in enumerate(draw.random(3) < 0.5):
        strength, arrived = float(draw.exponential(4.0)), bool(draw.random() < 0.05)
        if heard:
            yield Signal(t_us, target, strength, arrived)


def hard_views(case: Scenario, agent: int, seed: int) -> Iterator[tuple[str, View]]:
    """Views at the edge of what may happen, each with a few words."""
    draw = np.random.default_rng([seed, agent, 99])
    west, south, east, north = case.grid.bounds
    limits = case.limits
    middle = np.array(((west + east) / 2.0, (south + north) / 2.0, 50.0))
    places = {
        "in the middle": middle,
        "on the south-western corner": np.array((west, south, 50.0)),
        "on the north-eastern corner": np.array((east, north, 50.0)),
        "just inside the eastern edge": np.array((east - 0.1, middle[1], 50.0)),
        "outside the area": np.array((west - 60.0, north + 60.0, 50.0)),
        "below the altitude band": np.array((*middle[:2], limits.altitude_min_m - 10.0)),
        "above the altitude band": np.array((*middle[:2], limits.altitude_max_m + 10.0)),
    }
    maps = {
        "an untouched map": 0.5,
        "every cell found": 0.999,
        "every cell at 0": 0.0,
        "every cell at 1": 1.0,
        "a random map": None,
    }
    for where, place in places.items():
        for what, value in maps.items():
            belief = (
                draw.random(case.grid.shape) if value is None else np.full(case.grid.shape, value)
            )
            velocity = draw.normal(0.0, 5.0, 3) * (1.0, 1.0, 0.1)
            seen = belief != 0.5
            view = made_up(case, agent, 3, place, velocity, belief, seen, (), draw)
            yield f"{where}, {what}", view


def with_neighbours(view: View, heard: Neighbours) -> View:
    """The view with other neighbours, read-only."""
    changed = replace(view, neighbours=heard)
    read_only(changed)
    return changed


def reordered(heard: Neighbours, order: Any) -> Neighbours:
    """The same neighbours in another order of rows."""
    return Neighbours(
        heard.ids[order],
        heard.position[order],
        heard.velocity[order],
        heard.age_s[order],
        tuple(heard.payloads[i] for i in order),
    )


def read_only(value: Any) -> None:
    """Forbid writing to every array in a value of nested dataclasses and tuples."""
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    elif isinstance(value, tuple):
        for part in value:
            read_only(part)
    elif is_dataclass(value) and not isinstance(value, type):
        for part in fields(value):
            read_only(getattr(value, part.name))


def _flown(setpoint: object, position: F64, case: Scenario) -> F64:
    """Velocity (3,) m/s for the next tick; none for what no vehicle can fly."""
    if isinstance(setpoint, FlyVelocity):
        velocity = np.array(setpoint.velocity, dtype=np.float64)
    elif isinstance(setpoint, GoTo | FlySegment):
        goal = setpoint.position if isinstance(setpoint, GoTo) else setpoint.end
        offset = np.asarray(goal, dtype=np.float64) - position
        distance = float(np.sqrt(offset @ offset))
        velocity = offset / max(distance, 1e-9) * min(case.limits.speed_m_s, distance)
    else:
        return np.zeros(3)
    return velocity if np.isfinite(velocity).all() else np.zeros(3)
