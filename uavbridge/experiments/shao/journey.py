"""A leader that goes to the target region by pheromones, and its followers (Shao 2020, section 5).

Many runs at once. The decisions are ``planners.pheromone.lead``'s and ``follow``'s, which also fly.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planners.pheromone import Field, FieldLaw, SpreadLaw, Weights, spread
from planners.pheromone import step as update
from planners.pheromone.field import disc
from planners.pheromone.follow import FollowLaw, flock
from planners.pheromone.lead import cell_of, scalar_step, sensed, vector_step
from planners.pheromone.sectors import inside
from planners.types import F64, I64, Bools

LEADERS = ("vector", "scalar-1", "scalar-2")
ARRIVED = 1e-6  # cells


@dataclass(frozen=True, slots=True)
class Journey:
    """All that holds for every run."""

    leader: str = "vector"
    radius: float = 5.0  # sensorLD, cells
    length: float = 2.0  # rho, cells a step
    law: FieldLaw = dataclasses.field(default_factory=FieldLaw)
    weights: Weights = dataclasses.field(default_factory=Weights)
    scale: float = 0.1  # of target pheromone as it is sensed
    log: bool = True  # its logarithm is sensed
    before: int = 300  # steps that the field had to spread
    follow: FollowLaw = dataclasses.field(default_factory=FollowLaw)

    @property
    def reach(self) -> float:
        """Cells that the leader goes in a step."""
        return 1.0 if self.leader == "scalar-1" else self.length


@dataclass(slots=True, eq=False)
class Flock:
    """All runs after some steps: leading axes runs (r), followers (n)."""

    t: int
    leader: F64  # (r, 2) cells
    leader_velocity: F64  # (r, 2) cells a step
    position: F64  # (r, n, 2)
    velocity: F64  # (r, n, 2)
    field: Field  # (r, columns, rows)
    seen: Bools  # (r, columns, rows) by the leader
    arrived_at: I64  # (r,) step, -1: not yet


def travel(
    obstacles: Bools, start: F64, goal: I64, followers: F64, journey: Journey, steps: int
) -> Iterator[Flock]:
    """The state at t = 0, 1, ...: one object, changed in place; ends when all have arrived.

    Args:
        obstacles: (r, columns, rows).
        start: (r, 2) of the leader.
        goal: (r, 2) cell of the region's centre, the one source of target pheromone.
        followers: (r, n, 2) where they start.
        journey: what holds for all.
        steps: at most.
    """
    runs = len(obstacles)
    source = np.zeros(obstacles.shape)
    source[np.arange(runs), goal[:, 0], goal[:, 1]] = 1.0
    state = Flock(
        0,
        start.copy(),
        np.zeros((runs, 2)),
        followers.copy(),
        np.zeros(followers.shape),
        _grown(Field.fresh(obstacles.shape, journey.law), source, journey),
        np.zeros(obstacles.shape, np.bool_),
        np.full(runs, -1),
    )
    _see(state, journey)
    yield state
    while state.t < steps and (state.arrived_at < 0).any():
        _step(state, obstacles, source, goal, journey)
        yield state


def _step(state: Flock, obstacles: Bools, source: F64, goal: I64, journey: Journey) -> None:
    known = obstacles & state.seen
    velocity = _led(state, known, goal, journey)
    followed = flock(
        state.position, state.velocity, state.leader, state.leader_velocity, journey.follow
    )
    state.leader, state.leader_velocity = state.leader + velocity, velocity
    state.position, state.velocity = state.position + followed, followed  # Eq. (24)
    state.t += 1
    there = np.hypot(*(goal - state.leader).T) < ARRIVED
    state.arrived_at = np.where(there & (state.arrived_at < 0), state.t, state.arrived_at)
    _see(state, journey)
    state.field = update(
        state.field,
        source * journey.law.target.deposit,
        np.asarray((obstacles & state.seen) * journey.law.obstacle.deposit, np.float64),
        cell_of(state.leader)[:, None],
        journey.law,
    )


def _led(state: Flock, known: Bools, goal: I64, journey: Journey) -> F64:
    """Velocities (r, 2) of the leaders, Algorithm 2."""
    ahead = goal - state.leader
    distance = np.hypot(ahead[:, 0], ahead[:, 1])
    total = sensed(state.field, journey.weights, journey.scale, journey.log)
    if journey.leader == "vector":
        velocity = vector_step(
            state.leader, state.leader_velocity, total, known, journey.radius, journey.length
        )
    else:
        lattice = journey.leader == "scalar-1"
        velocity = scalar_step(state.leader, total, known, journey.radius, journey.reach, lattice)
    share = np.minimum(1.0, journey.reach / np.maximum(distance, ARRIVED))
    sight = (distance <= journey.radius)[:, None]
    return np.where(sight, ahead * share[:, None], velocity)


def _grown(field: Field, source: F64, journey: Journey) -> Field:
    """The field after the source has given off pheromone for a while."""
    law: SpreadLaw = journey.law.target
    target = field.target
    for _ in range(journey.before):
        target = spread(target, source * law.deposit, law)
    return Field(target, field.obstacle, field.path)


def _see(state: Flock, journey: Journey) -> None:
    around = cell_of(state.leader)[:, None] + disc(journey.radius)
    valid = inside(around, state.seen.shape[1:])
    run = np.broadcast_to(np.arange(len(around))[:, None], valid.shape)[valid]
    column, row = around[valid].T
    state.seen[run, column, row] = True
