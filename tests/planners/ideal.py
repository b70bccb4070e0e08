"""Point masses that search: planners without vehicles, radio or bus.

Ten agents, a map each. A tick: every agent decides on what it knew at the end
of the last one, all move, readings on entering a cell, then those in range
exchange maps by belief update ("whole" maps, or only the cell just read: "own").
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from planners.belief.merge import SensorModel
from planners.grid import Grid
from planners.types import FlyVelocity, GoTo, Neighbours, Scenario, View

GRID = Grid(0.0, 0.0, 100.0, 10, 10)
TARGETS = ((4, 5), (4, 7), (7, 5))
STARTS = np.array([(100.0 * (1 + i // 5), 100.0 * (1 + i % 5), 50.0) for i in range(10)])


def scenario(agents=10, grid=GRID, tick_s=1.0, **changes):
    starts = np.concatenate([STARTS] * (1 + agents // 10))[:agents]
    return Scenario(grid, tuple(range(1, agents + 1)), starts, tick_s, **changes)


@dataclass
class Result:
    coverage: list = field(default_factory=list)  # union of maps, after each tick
    declared: dict = field(default_factory=dict)  # cell -> tick
    false: set = field(default_factory=set)
    closest_m: float = np.inf
    done: int | None = None  # first tick with coverage >= 0.9 and all targets declared
    covered: int | None = None  # first tick with coverage >= 0.9
    tracks: list = field(default_factory=list)


def fly(
    planner,
    case,
    seed,
    ticks=600,
    targets=TARGETS,
    sensor=SensorModel(),  # noqa: B008
    range_m=400.0,
    exchange="whole",
    noisy=True,
    stop=True,
):
    n, size = len(case.team), case.grid.size
    sense = np.random.default_rng([seed, 1])
    position = case.starts.copy()
    velocity = np.zeros((n, 3))
    probability = np.full((n, size), 0.5)
    stamp = np.full((n, size), -1, np.int64)  # time * 64 + origin: the rule's total order
    cell = case.grid.cell_of(position)
    memory = [None] * n
    result = Result()
    for tick in range(ticks):
        views = [
            _view(case, i, tick, position, velocity, probability, stamp, range_m) for i in range(n)
        ]
        for i, view in enumerate(views):
            if tick == 0:
                memory[i] = planner.init(view)
            rng = np.random.default_rng([seed, 2, i, tick])
            goal, memory[i] = planner.plan(view, memory[i], rng)
            velocity[i] = _velocity(goal.setpoint, position[i], case)
        position = position + velocity * case.tick_s
        result.tracks.append(position[:, :2].copy())
        now = case.grid.cell_of(position)
        now = np.clip(now, 0, np.array(case.grid.shape) - 1)
        fresh = np.zeros((n, size), bool)
        for i in np.flatnonzero((now != cell).any(axis=1)):
            flat = now[i, 0] * case.grid.rows + now[i, 1]
            there = tuple(now[i].tolist()) in targets
            chance = sensor.p if there else sensor.q
            detected = sense.random() < chance if noisy else there
            probability[i, flat] = np.clip(
                sensor.after(probability[i, flat], detected), 1e-7, 1 - 1e-7
            )
            stamp[i, flat] = (tick + 1) * 64 + i
            fresh[i, flat] = True
        cell = now
        exchange_maps(position, probability, stamp, range_m, fresh if exchange == "own" else None)
        if _score(result, case, tick + 1, position, probability, stamp, targets) and stop:
            break
    return result


def _view(case, i, tick, position, velocity, probability, stamp, range_m):
    others = np.array([j for j in range(len(position)) if j != i], int)
    gap = np.hypot(*(position[others] - position[i]).T[:2])
    heard = others[gap <= range_m]
    shape = case.grid.shape
    return View(
        t_us=int(tick * case.tick_s * 1e6),
        tick=tick,
        agent=case.team[i],
        position=position[i],
        velocity=velocity[i],
        heading_rad=np.pi / 2,
        neighbours=Neighbours(heard + 1, position[heard], velocity[heard], np.zeros(len(heard))),
        belief=probability[i].reshape(shape).copy(),
        seen=(stamp[i] >= 0).reshape(shape),
    )


def _velocity(setpoint, position, case):
    if isinstance(setpoint, FlyVelocity):
        return setpoint.velocity
    assert isinstance(setpoint, GoTo)
    offset = setpoint.position - position
    distance = np.hypot(*offset[:2])
    speed = min(setpoint.speed_m_s or case.limits.speed_m_s, distance / case.tick_s)
    return offset / max(distance, 1e-9) * speed


def exchange_maps(position, probability, stamp, range_m, only=None):
    """Belief update among all in range at once: the greatest stamp of every cell wins."""
    gap = np.hypot(*(position[:, None, :2] - position[None, :, :2]).transpose(2, 0, 1))
    sent = np.broadcast_to(stamp, (len(stamp), *stamp.shape))
    if only is not None:
        sent = np.where(only[None] | np.eye(len(stamp), dtype=bool)[..., None], sent, -1)
    heard = np.where((gap <= range_m)[..., None], sent, -2)
    best = heard.argmax(axis=1)
    column = np.arange(stamp.shape[1])
    better = heard.max(axis=1) > stamp
    probability[:] = np.where(better, probability[best, column], probability)
    stamp[:] = np.where(better, stamp[best, column], stamp)


def _score(result, case, tick, position, probability, stamp, targets):
    coverage = float((stamp >= 0).any(axis=0).mean())
    result.coverage.append(coverage)
    found = np.flatnonzero((probability >= case.detection_threshold).any(axis=0))
    for flat in found.tolist():
        cell = divmod(flat, case.grid.rows)
        if cell in targets:
            result.declared.setdefault(cell, tick)
        else:
            result.false.add(cell)
    if len(position) > 1:
        gap = np.hypot(*(position[:, None, :2] - position[None, :, :2]).transpose(2, 0, 1))
        result.closest_m = min(result.closest_m, gap[np.triu_indices(len(gap), 1)].min())
    if coverage >= 0.9 and result.covered is None:
        result.covered = tick
    if result.covered is not None and len(result.declared) == len(targets):
        result.done = tick
    return result.done is not None
