"""The planner flies what the kernels decide, step by step; terrain, limits, notes."""

import math

import numpy as np
import pytest

from planners import conformance, registry
from planners.grid import Grid
from planners.search.mountain import MountainParams, Rules, signal
from planners.search.mountain.payload import Told, encode
from planners.search.mountain.planner import MOUNTAIN
from planners.search.mountain.state import DRAWS, Draws, Heard, Sensed, fresh
from planners.search.mountain.step import step
from planners.terrain import Terrain, mountains
from planners.types import Limits, Neighbours, Scenario, Signal, View

GRID = Grid(0.0, 0.0, 100.0, 4, 4)
HILLS = mountains(np.random.default_rng(2), GRID.bounds, math.radians(40.0))
RADIO_M = 150.0
LIMITS = Limits(10.0, 8.0, 0.0, 500.0)


def case(n, tick_s=1.0, limits=LIMITS, height=0.0):
    starts = np.full((n, 3), height)
    return Scenario(GRID, tuple(range(n)), starts, tick_s, limits, radio_range_m=RADIO_M)


def view(place, velocity=(0.0, 0.0, 0.0), tick=0, agent=0, heard=None, signals=(), terrain=HILLS):
    velocity = np.array(velocity)
    heading = math.atan2(velocity[1], velocity[0])
    nothing = np.zeros(GRID.shape)
    heard = heard or Neighbours.none()
    return View(
        tick * 10**6, tick, agent, np.array(place), velocity, heading, heard, nothing,
        nothing > 0, signals=tuple(signals), terrain=terrain,
    )  # fmt: skip


def bound(n=1, values=None, **changes):
    return registry.bind(MOUNTAIN, case(n, **changes), values or {})


def grounded(xy):
    return np.concatenate((xy, HILLS.height_at(xy)[..., None]), axis=-1)


class Both:
    """The same robots twice: one kernel for all, and a planner for each."""

    def __init__(self, n, targets, seed, **values):
        self.n, self.ids = n, np.arange(n)
        self.draw = np.random.default_rng(seed)
        self.place = grounded(self.draw.uniform(20.0, 250.0, (n, 2)))
        self.targets = grounded(self.draw.uniform(20.0, 380.0, (targets, 2)))
        self.planner = bound(n, values)
        params = registry.parameters(MOUNTAIN, values)
        self.rules = Rules.of(params, RADIO_M, 1.0)
        heading = self.draw.uniform(-3.0, 3.0, n)
        self.velocity = 10.0 * np.stack((np.cos(heading), np.sin(heading), 0 * heading), -1)
        self.robots = fresh((n,), targets, params.members, self.velocity)
        self.memory = [self.planner.init(view(*pair)) for pair in self.pairs()]
        self.payloads = [encode(Told(free=True), 0)] * n
        self.tick = 0

    def pairs(self):
        return zip(self.place, self.velocity, strict=True)

    def sense(self):
        offset = self.place[:, None] - self.targets
        distance = np.sqrt((offset**2).sum(axis=-1))
        noise = self.draw.standard_normal(distance.shape)
        strength = signal(distance, noise, 0.1, 1e5, 100.0)
        return Sensed(self.place, strength, distance <= 100.0, distance < 10.0)

    def step(self):
        sensed = self.sense()
        apart = np.sqrt(((self.place[:, None] - self.place) ** 2).sum(axis=-1))
        near = apart <= RADIO_M
        numbers = np.stack([self.rng(i).random(DRAWS) for i in self.ids])
        heard = Heard(
            self.ids[None], self.place[None], near, self.robots.told.map(lambda part: part[None])
        )
        flown = [self.decide(i, sensed, near[i]) for i in self.ids]
        velocity, self.robots = step(
            self.ids, self.robots, sensed, heard, Draws.of(numbers), HILLS, GRID.bounds, self.rules
        )
        self.payloads = [goal.payload for goal in flown]
        self.velocity = velocity
        self.place = self.place + velocity
        self.tick += 1
        return np.stack([goal.setpoint.velocity for goal in flown]), velocity

    def rng(self, i):
        return np.random.default_rng([7, i, self.tick])

    def decide(self, i, sensed, near):
        rows = self.draw.permutation(self.ids[near & (self.ids != i)])
        payloads = tuple(self.payloads[row] for row in rows)
        heard = Neighbours(
            rows, self.place[rows], self.velocity[rows], np.zeros(len(rows)), payloads
        )
        signals = [
            Signal(0, j, sensed.strength[i, j], bool(sensed.arrived[i, j]))
            for j in np.flatnonzero(sensed.heard[i])
        ]
        ground = HILLS.around(self.place[i], 30.0)
        now = view(self.place[i], self.velocity[i], self.tick, int(i), heard, signals, ground)
        goal, self.memory[i] = self.planner.plan(now, self.memory[i], self.rng(i))
        return goal


@pytest.mark.parametrize("escape", ["roam", "current", "none"])
def test_a_robot_alone_decides_as_the_kernel_for_all(escape):
    both = Both(12, 3, seed=4, escape=escape, members=3)
    members = 0
    for _ in range(35):
        flown, decided = both.step()
        level = np.hypot(decided[:, 0], decided[:, 1])
        slow = level <= 10.0  # Eq. (28) alone may exceed a limit, and only upwards
        assert slow.all()
        assert flown[:, :2] == pytest.approx(decided[:, :2], abs=1e-6)
        assert flown[:, 2] == pytest.approx(np.clip(decided[:, 2], -8.0, 8.0), abs=1e-6)
        mine = [bool(memory.robots.member[0]) for memory in both.memory]
        assert mine == both.robots.member.tolist()
        members += sum(mine)
        for j in range(3):
            assert (both.robots.member & (both.robots.told.task == j)).sum() <= 3
    assert members > 10


def test_it_conforms():
    assert conformance.check(MOUNTAIN) == []


def test_it_keeps_the_limits_in_other_readings():
    trial = conformance.Trial(MOUNTAIN, {"escape": "current", "boundary": "clip", "members": 16})
    assert conformance.CHECKS["inside_limits"](trial) == []
    assert conformance.CHECKS["small_payload"](trial) == []


def test_it_keeps_its_height_above_ground():
    planner = bound(height=30.0)
    place = grounded(np.array((150.0, 150.0)))
    place[2] += 30.0
    now = view(place, (10.0, 0.0, 0.0))
    goal, _ = planner.plan(now, planner.init(now), np.random.default_rng(0))
    velocity = goal.setpoint.velocity
    ahead = HILLS.height_at(place[:2] + velocity[:2]) + 30.0
    assert place[2] + velocity[2] == pytest.approx(ahead)


def test_it_climbs_no_faster_than_its_limits():
    planner = bound(limits=Limits(10.0, 2.0, 0.0, 500.0), height=30.0)
    low = view(grounded(np.array((150.0, 150.0))), (10.0, 0.0, 0.0))
    goal, _ = planner.plan(low, planner.init(low), np.random.default_rng(0))
    assert goal.setpoint.velocity[2] == 2.0


def test_a_robot_that_comes_upon_a_target_says_so():
    planner, rng = bound(), np.random.default_rng(0)
    place, notes = np.array((80.0, 60.0, 0.0)), []
    velocity, target = np.array((10.0, 0.0, 0.0)), np.array((200.0, 63.0, 0.0))
    level = Terrain(0.0, 0.0, 400.0, np.zeros((2, 2)))
    memory = planner.init(view(place, velocity))
    for tick in range(400):
        distance = float(np.linalg.norm(place - target))
        strength = 1e4 / distance**2 + rng.standard_normal()
        heard = [Signal(0, 9, strength, distance < 10.0)] if distance <= 100.0 else []
        now = view(place, velocity, tick, signals=heard, terrain=level)
        goal, memory = planner.plan(now, memory, rng)
        velocity = goal.setpoint.velocity
        place = place + velocity
        notes.append(goal.note)
        if distance < 10.0:
            break
    assert distance < 10.0
    assert notes[0] == "roams"
    assert "leads 1 to target 9" in notes
    assert notes[-1] == "roams", "a found target is sought no more"
    again = view(place, velocity, tick, signals=[Signal(0, 9, 50.0, False)], terrain=level)
    assert planner.plan(again, memory, rng)[0].note == "roams"


def test_what_is_told_found_is_sought_no_more():
    planner, rng = bound(2), np.random.default_rng(0)
    teller = encode(Told(found=(9,)), 0)
    heard = Neighbours(np.array([1]), np.array([[60.0, 60.0, 0.0]]), np.zeros((1, 3)),
                       np.zeros(1), (teller,))  # fmt: skip
    now = view((50.0, 50.0, 0.0), (10.0, 0.0, 0.0), heard=heard, signals=[Signal(0, 9, 5.0, False)])
    goal, memory = planner.plan(now, planner.init(now), rng)
    assert goal.note == "roams"
    assert memory.targets.tolist() == [9]
    assert memory.robots.told.found.all()


def test_defaults_are_table_2():
    params = MountainParams()
    assert (params.speed_m_s, params.members, params.directions) == (10.0, 6, 360)
    assert (params.own_pull, params.shared_pull) == (1.0, 1.2)
    assert (params.inertia, params.response) == (0.5, 0.1)
    assert math.degrees(params.climb_rad) == pytest.approx(30.0)
    assert (params.detection_m, params.lattice_m) == (100.0, 1.0)
    assert (params.repel_m(300.0), params.repel_m(120.0)) == (200.0, 120.0)
