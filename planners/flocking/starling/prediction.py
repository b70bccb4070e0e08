r"""Dynamic prediction as the paper has it: every aircraft for itself (Chen 2023, Eqs. 27-32).

    Y_p = Y_b(x_1 .. x_ks), then one of the branches to x_kp                        (28)
    Y_b = k_s updates of those that the aircraft perceives, until it flies freely   (29)
    branches: n_l rollouts of the flock with other draws, n_r RRT ways              (30)
    J = sum_k L_D(x_k, x_k+1) + K_aim L_D(x_kp, x_aim)                              (27)
    Y_i = the longest prefix of Y_p with L_D < v Dt                                 (31)
    K_learn(t) = K_learn (1 - t / t_e), t the time since the space was safe         (32)

| symbol | name |
| --- | --- |
| k_p, k_s | ``Foresight.nodes``, ``Foresight.settle`` at most |
| K_learn, K_r | ``Foresight.learning`` and ``Foresight.ways``, numbers of branches |
| K_aim | ``Foresight.aim`` |
| t_e | ``Foresight.learning_s`` |

Readings: weights of Eq. (30) are numbers of branches; Eq. (31) is a length against v Dt; J is
taken over nodes 2 R_min apart, because between nodes that are nearer every bend costs a loop; a
branch is kept unless another is better by ``Foresight.better``. ``route`` is what does better.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from planners.flocking.starling.behaviours import FREE
from planners.flocking.starling.flock import Flock, Setting, update
from planners.flocking.starling.wing import flown
from planners.paths import rrt
from planners.paths.dubins import airplane_lengths
from planners.paths.ground import path_gap
from planners.types import F64


@dataclass(frozen=True, slots=True)
class Foresight:
    """How far and how wide is looked ahead."""

    period_s: float = 1.0  # Dt
    nodes: int = 24
    settle: int = 3
    learning: int = 4
    ways: int = 2
    learning_s: float = 20.0
    aim: float = 1.0
    reach_m: float = 1400.0  # RRT ways lead to the aim or so far towards it
    better: float = 0.07
    substep_s: float = 0.5
    samples: int = 600
    clearance_m: float = 40.0
    ceiling_m: float = 300.0


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """A predicted path and what it costs."""

    points: F64  # (k, 3) m, from where the aircraft is
    cost: float  # J, m
    kind: str  # "learning", "rrt" or "kept"


def predict(
    agent: int,
    flock: Flock,
    setting: Setting,
    foresight: Foresight,
    unsafe_s: float,
    kept: Branch | None,
    rng: Generator,
) -> Branch | None:
    """The branch that one aircraft should fly, or None when all are blocked.

    Args:
        agent: its row.
        flock: all, (n, 3); only those it perceives are used.
        setting: rules, limits, terrain and aim (3,).
        foresight: how far.
        unsafe_s: t_u, how long its space has not been safe.
        kept: the branch of the last time.
        rng: of draws and trees.
    """
    group, own = _perceived(agent, flock, setting)
    settled, before = _settled(group, own, setting, foresight, rng)
    left = max(foresight.nodes - len(before), 1)
    share = max(1.0 - unsafe_s / foresight.learning_s, 0.0)  # Eq. (32)
    rollouts = math.ceil(foresight.learning * share)
    paths = [
        ("learning", path)
        for path in _rollouts(settled, own, rollouts, left, setting, foresight, rng)
    ]
    paths += [("rrt", path) for path in _ways(settled, own, left, setting, foresight, rng)]
    start = flock.position[agent][None]
    found = []
    for kind, path in paths:
        points = np.concatenate((start, before, path))
        if _flyable(points, setting, foresight):
            found.append(
                Branch(points, _cost(points, flock.velocity[agent], setting, foresight), kind)
            )
    old = _carried_on(kept, flock.position[agent], flock.velocity[agent], setting, foresight)
    best = min(found, key=lambda branch: branch.cost, default=None)
    if old is not None and (best is None or best.cost > old.cost * (1.0 - foresight.better)):
        return old
    return best


def prefix(points: F64, speed_m_s: float, period_s: float) -> F64:
    """Eq. (31): the points (j, 3) of a branch (k, 3) that are flown before the next prediction."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    count = int((np.cumsum(lengths) < speed_m_s * period_s).sum())
    return points[: max(count, 1) + 1]


def _perceived(agent: int, flock: Flock, setting: Setting) -> tuple[Flock, int]:
    away = np.linalg.norm(flock.position - flock.position[agent], axis=-1)
    mine = np.nonzero(away <= setting.rules.perception_m)[0]
    group = Flock(
        flock.position[mine], flock.velocity[mine], flock.danger_s[mine], flock.alarm_s[mine]
    )
    return group, int(np.nonzero(mine == agent)[0][0])


def _advance(
    group: Flock, setting: Setting, foresight: Foresight, rng: Generator
) -> tuple[Flock, F64]:
    """The group after one period, and the behaviours at its end."""
    steps = max(round(foresight.period_s / foresight.substep_s), 1)
    step = foresight.period_s / steps
    mode = np.zeros(group.position.shape[:-1])
    for _ in range(steps):
        lead = group.position.shape[:-1]
        aims = np.broadcast_to(setting.aim, group.position.shape)
        nobody = np.zeros((*lead[:-1], 0, 3))
        chance, noise = rng.uniform(size=lead), rng.standard_normal((*lead, 3))
        done = update(group, aims, nobody, chance, noise, setting, step)
        velocity = flown(group.velocity, done.acceleration, setting.wing, step)
        position = group.position + (group.velocity + velocity) * (step / 2.0)
        group = Flock(position, velocity, done.danger_s, done.alarm_s)
        mode = done.mode.astype(np.float64)
    return group, mode


def _settled(
    group: Flock, own: int, setting: Setting, foresight: Foresight, rng: Generator
) -> tuple[Flock, F64]:
    """Eq. (29): the group when the aircraft flies freely, and its nodes (k_s, 3)."""
    nodes = []
    for _ in range(foresight.settle):
        group, mode = _advance(group, setting, foresight, rng)
        nodes.append(group.position[own])
        if mode[own] == FREE:
            break
    return group, np.array(nodes).reshape(-1, 3)


def _rollouts(
    group: Flock,
    own: int,
    count: int,
    nodes: int,
    setting: Setting,
    foresight: Foresight,
    rng: Generator,
) -> list[F64]:
    if not count:
        return []
    copies = Flock(
        *(
            np.repeat(part[None], count, axis=0)
            for part in (group.position, group.velocity, group.danger_s, group.alarm_s)
        )
    )
    out = []
    for _ in range(nodes):
        copies, _ = _advance(copies, setting, foresight, rng)
        out.append(copies.position[:, own])
    return list(np.stack(out, axis=1))


def _ways(
    group: Flock, own: int, nodes: int, setting: Setting, foresight: Foresight, rng: Generator
) -> list[F64]:
    if setting.terrain is None:
        return []
    start = group.position[own]
    offset = setting.aim - start
    away = float(np.linalg.norm(offset))
    goal = start + offset * min(1.0, foresight.reach_m / max(away, 1e-9))
    rules = rrt.RrtRules(
        step_m=setting.rules.speed_m_s * foresight.period_s * 3.0,
        clearance_m=foresight.clearance_m,
        ceiling_m=foresight.ceiling_m,
        climb_rad=0.25,
        goal_bias=0.2,
        nodes=foresight.samples,
    )
    floor = float(setting.terrain.height_at(goal)) + foresight.clearance_m
    goal[2] = max(goal[2], floor) if floor <= foresight.ceiling_m else goal[2]
    found = []
    for _ in range(foresight.ways):
        try:
            path = rrt.plan(setting.terrain, start, goal, rules, rng)
        except ValueError:  # the point on the way lies in a hill: farther on
            goal = setting.aim
            continue
        if path is not None:
            spacing = setting.rules.speed_m_s * foresight.period_s
            found.append(rrt.resampled(path.points, spacing)[1 : nodes + 1])
    return found


def _flyable(points: F64, setting: Setting, foresight: Foresight) -> bool:
    if setting.terrain is None:
        return True
    low = min(foresight.clearance_m, setting.watch.clearance_m)
    return path_gap(setting.terrain, points) >= low


def _cost(points: F64, velocity: F64, setting: Setting, foresight: Foresight) -> float:
    """Eq. (27) over nodes 2 R_min apart."""
    speed, wing = setting.rules.speed_m_s, setting.wing
    radius = wing.radius(speed)
    nodes = rrt.resampled(points, 2.0 * radius)
    legs = np.diff(np.concatenate((nodes, setting.aim[None])), axis=0)
    course = np.arctan2(legs[:, 1], legs[:, 0])
    heading = np.concatenate(([math.atan2(velocity[1], velocity[0])], course[1:], course[-1:]))
    poses = np.column_stack((np.concatenate((nodes, setting.aim[None])), heading))
    climb = min(wing.climb_rad, wing.sink_rad)
    lengths = airplane_lengths(poses[:-1], poses[1:], radius, climb)
    return float(lengths[:-1].sum() + foresight.aim * lengths[-1])


def _carried_on(
    kept: Branch | None, position: F64, velocity: F64, setting: Setting, foresight: Foresight
) -> Branch | None:
    """What is left of the branch of the last time, when it can still be flown."""
    if kept is None or len(kept.points) < 4:
        return None
    nearest = int(np.argmin(np.linalg.norm(kept.points - position, axis=1)))
    points = np.concatenate((position[None], kept.points[nearest + 1 :]))
    if len(points) < foresight.nodes // 2 or not _flyable(points, setting, foresight):
        return None
    return replace(
        kept, points=points, cost=_cost(points, velocity, setting, foresight), kind="kept"
    )
