"""Flights of a flock as point masses within an aircraft's limits.

The paper's simulation is a MATLAB program of which it tells the start box, the start speeds and
the distances. Ours: decisions every 0.1 s; aircraft with limits of bank, climb, speed and
acceleration (``planners.flocking.starling.wing``); who sees whom looked at every 0.5 s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator

from planners.flocking.starling import prediction, route
from planners.flocking.starling.flock import Flock, Setting, update
from planners.flocking.starling.prediction import Branch, Foresight
from planners.flocking.starling.ridge import Watch
from planners.flocking.starling.route import RouteRules
from planners.flocking.starling.rules import StarlingRules
from planners.flocking.starling.wing import Wing, flown
from planners.terrain import Terrain
from planners.types import F64, I64, Bools
from uavbridge.experiments.chen.terrains import AIM, START_BOX

STEP_S = 0.1
_SIGHT = 5  # steps between two looks at who sees whom
_REPLAN = 100  # steps between two plans
_WIDE_M = 150.0  # high ground this near makes danger space
_APART_M = 20.0  # at the start

Intruders = Callable[[float, F64, F64], F64]  # (t, before (m, 3), flock (n, 3)) -> (m, 3)


@dataclass(frozen=True, slots=True)
class Rules:
    """How one flight is flown."""

    terrain: Terrain
    starling: StarlingRules
    seconds: float = 120.0
    planner: str = "shared"  # "own": every aircraft for itself, as printed; "none"
    wing: Wing = field(default_factory=Wing)
    watch: Watch = field(default_factory=Watch)
    route: RouteRules = field(default_factory=RouteRules)
    foresight: Foresight = field(default_factory=Foresight)


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """One flight; k steps."""

    t_s: F64  # (k,)
    position: F64  # (k, n, 3) m
    velocity: F64  # (k, n, 3) m/s
    mode: I64  # (k, n) of planners.flocking.starling.behaviours
    danger: Bools  # (k, n)
    alarm: Bools  # (k, n)
    intruders: F64  # (k, m, 3) m, NaN when there is none
    way: F64 | None  # (j, 3) m, the last one of the flock


def start(count: int, rng: Generator) -> tuple[F64, F64]:
    """Positions and velocities (n, 3): the paper's box and speeds, heading 0.

    "At a safe distance" is read as 20 m, and no two meet within three seconds before they
    could part.
    """
    low, high = np.array(START_BOX)
    position, speed = np.zeros((0, 3)), np.zeros(0)
    tries = 0
    while len(position) < count:
        tries += 1
        if tries > 500:  # the box is too full to go on: anew
            position, speed, tries = position[:0], speed[:0], 0
        place, pace = rng.uniform(low, high), rng.uniform(40.0, 100.0)
        offset = position - place
        relative = speed - pace
        closing = np.where(np.abs(relative) > 1e-9, relative, np.inf)
        when = np.clip(-offset[:, 0] / closing, 0.0, 3.0)
        miss = np.hypot(offset[:, 0] + relative * when, np.hypot(offset[:, 1], offset[:, 2]))
        apart = np.linalg.norm(offset, axis=1)
        if (apart < _APART_M).any() or (miss < 15.0 - 3.0 * when).any():
            continue
        position, speed = np.vstack((position, place)), np.append(speed, pace)
    return position, np.column_stack((speed, np.zeros((count, 2))))


def fly(count: int, rules: Rules, rng: Generator, intruders: Intruders | None = None) -> Tracks:
    """One flight of ``count`` aircraft."""
    flock = Flock.of(*start(count, rng))
    wide = route.widened(rules.terrain, _WIDE_M)
    aim = np.array(AIM)
    setting = Setting(rules.starling, rules.wing, rules.watch, rules.terrain, wide, aim)
    pilot = _PILOTS[rules.planner](rules, setting, count)
    steps = round(rules.seconds / STEP_S)
    rows: list[tuple[F64, F64, I64, F64, F64, F64]] = []
    visible: Bools | None = None
    foes = np.zeros((0, 3))
    for step in range(steps):
        if intruders is not None:
            foes = intruders(step * STEP_S, foes, flock.position)
        towards = pilot.towards(step, flock, visible, rng)
        look = None if step % _SIGHT == 0 else visible
        chance, noise = rng.uniform(size=count), rng.standard_normal((count, 3))
        done = update(flock, towards, foes, chance, noise, setting, STEP_S, look)
        visible = done.visible
        velocity = flown(flock.velocity, done.acceleration, rules.wing, STEP_S)
        position = flock.position + (flock.velocity + velocity) * (STEP_S / 2.0)
        flock = Flock(position, velocity, done.danger_s, done.alarm_s)
        shown = foes if len(foes) else np.full((1, 3), np.nan)
        rows.append((position, velocity, done.mode, done.danger_s, done.alarm_s, shown))
    position, velocity, mode, danger, alarm, seen = (
        np.array(part) for part in zip(*rows, strict=True)
    )
    safe = rules.starling.safe_s
    time = np.arange(1.0, steps + 1.0) * STEP_S
    return Tracks(time, position, velocity, mode, danger <= safe, alarm <= safe, seen, pilot.way)


class _Straight:
    """Everybody flies straight towards the aim."""

    way: F64 | None = None

    def __init__(self, rules: Rules, setting: Setting, count: int) -> None:
        self._aim = setting.aim

    def towards(self, step: int, flock: Flock, visible: Bools | None, rng: Generator) -> F64:
        return np.broadcast_to(self._aim, flock.position.shape)


class _Shared:
    """The best placed plans; its way goes one hop an update."""

    def __init__(self, rules: Rules, setting: Setting, count: int) -> None:
        self._rules, self._setting = rules, setting
        self._widths = route.grounds(rules.terrain, rules.route)
        self._ways: list[F64] = []
        self._version = np.zeros(count, np.int64)  # of the way each flies, 0: none
        self._width = 0  # the widest margin that let a way through

    @property
    def way(self) -> F64 | None:
        return self._ways[-1] if self._ways else None

    def towards(self, step: int, flock: Flock, visible: Bools | None, rng: Generator) -> F64:
        if step % _REPLAN == 0:
            self._plan(flock, rng)
        if visible is not None:
            heard = np.where(visible, self._version, 0).max(axis=-1, initial=0)
            self._version = np.maximum(self._version, heard)
        out = np.broadcast_to(self._setting.aim, flock.position.shape).copy()
        for version in set(self._version.tolist()) - {0}:
            mine = self._version == version
            way = self._ways[version - 1]
            out[mine] = route.ahead(way, flock.position[mine], self._rules.route.ahead_m)
        return out

    def _plan(self, flock: Flock, rng: Generator) -> None:
        rules, aim = self._rules.route, self._setting.aim
        leader = int(np.argmin(np.linalg.norm(flock.position - aim, axis=-1)))
        place, velocity = flock.position[leader], flock.velocity[leader]
        course = float(np.arctan2(velocity[1], velocity[0]))
        flown_at = self._setting.wing, self._setting.rules.speed_m_s
        old = self._ways[self._version[leader] - 1] if self._version[leader] else None
        for width in range(self._width, len(self._widths)):
            new = route.plan(self._widths[width], place, course, aim, rules, *flown_at, rng)
            if new is not None:
                break
        else:
            return
        self._width = width
        if old is not None:
            left = route.remaining(old, place)
            good = not route.blocked(self._rules.terrain, left, rules.clearance_m / 2.0)
            least = (1.0 - rules.better) * route.score(left, course, *flown_at)
            if good and route.score(new, course, *flown_at) > least:
                return
        self._ways.append(new)
        self._version[leader] = len(self._ways)


class _Own:
    """Every aircraft predicts for itself, once a period, as printed."""

    way: F64 | None = None

    def __init__(self, rules: Rules, setting: Setting, count: int) -> None:
        self._rules, self._setting = rules, setting
        self._branches: list[Branch | None] = [None] * count
        self._unsafe = np.zeros(count)

    def towards(self, step: int, flock: Flock, visible: Bools | None, rng: Generator) -> F64:
        every = round(self._rules.foresight.period_s / STEP_S)
        unsafe = flock.danger_s <= self._setting.rules.safe_s
        self._unsafe = np.where(unsafe, self._unsafe + STEP_S, 0.0)
        out = np.broadcast_to(self._setting.aim, flock.position.shape).copy()
        for agent, branch in enumerate(self._branches):
            if (step + agent) % every == 0 or step == 0:
                branch = prediction.predict(
                    agent,
                    flock,
                    self._setting,
                    self._rules.foresight,
                    float(self._unsafe[agent]),
                    branch,
                    rng,
                )
                self._branches[agent] = branch
            if branch is not None:
                place = flock.position[agent][None]
                out[agent] = route.ahead(branch.points, place, self._rules.route.ahead_m)[0]
        return out


_PILOTS: dict[str, Callable[[Rules, Setting, int], _Straight | _Shared | _Own]] = {
    "none": _Straight,
    "shared": _Shared,
    "own": _Own,
}
