"""The planners fly, and their adapters do what the batched kernels do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planners.belief import bayes, scores
from planners.grid import Grid
from planners.paths import loop
from planners.registry import BUILTIN, bind
from planners.search import boids, esustpm, flight, mower, random_walk, sweep
from planners.types import Neighbours, View
from tests.planners import ideal

CASE = ideal.scenario()


def view_of(case, index, position, velocity, belief, tick=0, others=None, theirs=None):
    rest = [i for i in range(len(case.team)) if i != index]
    others = position[rest] if others is None else others
    theirs = velocity[rest] if theirs is None else theirs
    pad = ((0, 0), (0, 1))
    heard = Neighbours(
        np.array(rest) + 1, np.pad(others, pad), np.pad(theirs, pad), np.zeros(len(rest))
    )
    place = np.array((*position[index], 50.0))
    speed = np.array((*velocity[index], 0.0))
    return View(
        tick * 1_000_000, tick, case.team[index], place, speed, 0.0, heard, belief, belief != 0.5
    )


def states(seed, runs=3):
    rng = np.random.default_rng(seed)
    position = rng.uniform(20, 980, (runs, 10, 2))
    velocity = rng.normal(0, 5, (runs, 10, 2))
    belief = rng.choice([0.05, 0.1, 0.5, 0.8, 0.97], (runs, 1, 10, 10))
    guide = rng.integers(-1, 100, (runs, 10))
    heading = rng.uniform(-3, 3, (runs, 10))
    others = np.broadcast_to(position[:, None], (runs, 10, 10, 2))
    theirs = np.broadcast_to(velocity[:, None], (runs, 10, 10, 2))
    present = np.broadcast_to(~np.eye(10, dtype=bool), (runs, 10, 10))
    return position, velocity, belief, guide, heading, others, theirs, present


@pytest.mark.parametrize(
    "params",
    [
        esustpm.EsustpmParams(),
        esustpm.EsustpmParams(keep="entered", escape_ratio=0.0, boundary="component"),
    ],
)
def test_esustpm_adapter_equals_the_batched_kernel(params):
    position, velocity, belief, guide, heading, others, _, present = states(5)
    noise = np.random.default_rng(7).standard_normal()
    rules = esustpm.Rules.of(params, CASE.detection_threshold)
    flown, chosen = esustpm.step(
        position,
        heading,
        others,
        present,
        belief,
        guide,
        np.full(guide.shape, noise),
        CASE,
        params,
        rules,
    )
    planner = esustpm.bind(CASE, params)
    for run, i in np.ndindex(3, 10):
        view = view_of(CASE, i, position[run], velocity[run], belief[run, 0])
        memory = esustpm.EsustpmMemory(int(guide[run, i]), float(heading[run, i]))
        goal, after = planner.plan(view, memory, np.random.default_rng(7))
        assert goal.setpoint.velocity[:2] == pytest.approx(flown[run, i], abs=1e-9)
        assert after.guide == chosen[run, i]


@pytest.mark.parametrize("params", [boids.BoidsParams(), boids.GuidedBoidsParams()])
def test_boids_adapter_equals_the_batched_kernel(params):
    position, velocity, belief, guide, heading, others, theirs, present = states(6)
    draw = np.random.default_rng(7)
    draw.uniform()
    noise = np.full(guide.shape, draw.standard_normal())
    flown, chosen = boids.step(
        position, heading, others, theirs, present, belief, guide, noise, CASE, params
    )
    planner = boids.bind(CASE, params)
    for run, i in np.ndindex(3, 10):
        view = view_of(CASE, i, position[run], velocity[run], belief[run, 0])
        memory = boids.BoidsMemory(float(heading[run, i]), int(guide[run, i]))
        goal, after = planner.plan(view, memory, np.random.default_rng(7))
        assert goal.setpoint.velocity[:2] == pytest.approx(flown[run, i], abs=1e-9)
        assert after.guide == chosen[run, i]


def test_loop_adapter_equals_the_batched_kernel():
    params = mower.MowerParams()
    loops = [mower.lanes_loop(CASE.grid, i, 4, params) for i in range(4)]
    points, count = loop.stack(loops)
    case = ideal.scenario(4)
    planner = mower.bind(case, params)
    position = np.array(case.starts[:, :2])
    leg, memory = np.zeros(4, int), [mower.LoopMemory(0)] * 4
    for tick in range(300):
        for i in range(4):
            view = view_of(case, i, position, position * 0.0, np.full((10, 10), 0.5), tick)
            goal, memory[i] = planner.plan(view, memory[i], np.random.default_rng(0))
            assert goal.setpoint.position[2] == 50.0
        flown, leg = mower.step(position, points, count, leg, params, 1.0)
        assert [m.leg for m in memory] == leg.tolist()
        position = position + flown


def test_mower_by_the_paper_gives_the_printed_uncertainty():
    """Liu 2022, Table 2: 52.34 and 100 cells after 200 cycles of 10 m, one lane an agent."""
    params = mower.MowerParams(inset_cells=0.0, reach_m=0.001)
    points, count = loop.stack([mower.lanes_loop(CASE.grid, i, 10, params) for i in range(10)])
    position, leg = points[:, 0].copy(), np.zeros(10, int)
    belief, visits = np.full((10, 10), 0.5), np.zeros((10, 10), int)
    cell = CASE.grid.cell_of(position)
    covered = 0
    for cycle in range(1, 201):
        flown, leg = mower.step(position, points, count, leg, params, 1.0)
        position = position + flown
        now = CASE.grid.cell_of(position)
        for column, row in now[(now != cell).any(axis=1)]:
            belief[column, row] = bayes.liu(belief[column, row], False, 0.3, 0.1)
            visits[column, row] += 1
        cell = now
        if covered == 0 and (visits[:, 1:] > 0).all():
            covered = cycle
    assert scores.uncertainty(belief) == pytest.approx(52.342, abs=5e-4)
    assert covered == 90
    assert (visits[:, 1:9] == 2).all()
    assert (visits[:, [0, 9]] == 1).all()


@pytest.mark.parametrize("along", ["north", "east"])
@pytest.mark.parametrize(
    "grid", [Grid(0, 0, 10, 10, 10), Grid(5, -5, 10, 3, 7), Grid(0, 0, 5, 1, 1)]
)
@pytest.mark.parametrize("team", [1, 2, 3, 7, 10, 13, 40])
def test_mowers_share_all_cells(along, grid, team):
    taken = []
    for index in range(team):
        lanes, cells = mower.share(grid, index, team, along)
        taken += [(lane, cell) for lane in lanes for cell in cells]
        points = mower.lanes_loop(grid, index, team, mower.MowerParams(along=along))
        assert grid.contains(points).all()
    shape = grid.shape if along == "north" else grid.shape[::-1]
    assert set(taken) == set(np.ndindex(shape))
    if team <= grid.size:
        assert len(taken) == grid.size  # nobody flies another's cell


def test_sweep_enters_at_even_distances_or_nearest():
    params = sweep.SweepParams()
    cells = sweep.LOOPS["closed-tour"](10, 10)
    entries = [sweep.entry_of(cells, CASE, i, params) for i in range(10)]
    assert entries == list(range(0, 100, 10))
    near = replace(params, entry="nearest")
    entry = sweep.entry_of(cells, CASE, 9, near)
    assert np.hypot(*(CASE.grid.centre_of(cells[entry]) - CASE.starts[9, :2])) <= 75.0


def test_random_directions_are_those_of_equation_12():
    square = np.random.default_rng(0).uniform(-1, 1, (200_000, 2))
    unit = random_walk.directions(square)
    assert np.hypot(*unit.T) == pytest.approx(1.0)
    angle = np.arctan2(unit[:, 1], unit[:, 0]) % (np.pi / 2)
    diagonal = (abs(angle - np.pi / 4) < 0.05).mean() / 0.1
    axis = ((angle < 0.05) | (angle > np.pi / 2 - 0.05)).mean() / 0.1
    assert diagonal / axis == pytest.approx(2.0, abs=0.1)  # twice the density on diagonals
    assert random_walk.directions(np.zeros(2)).tolist() == [0.0, 0.0]


def test_random_steps_keep_clear_where_they_can():
    drawn = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    here, other, heard = np.array([975.0, 500.0]), np.array([[975.0, 515.0]]), np.ones(1, bool)
    args = (10.0, CASE.grid, 20.0, 20.0)
    assert random_walk.clearest(here, other, heard, drawn, *args).tolist() == [-1.0, 0.0]
    alone = random_walk.clearest(here, other, ~heard, drawn, *args)
    assert alone.tolist() == [0.0, 1.0]


def test_random_keeps_a_direction_for_its_time():
    planner = random_walk.bind(CASE, random_walk.RandomWalkParams(hold_s=3.0))
    position, belief = np.array(CASE.starts[:, :2]) + 300.0, np.full((10, 10), 0.5)
    memory, flown = random_walk.RandomWalkMemory((0.0, 0.0), None), []
    for tick in range(7):
        view = view_of(CASE, 0, position, position * 0.0, belief, tick)
        _, memory = planner.plan(view, memory, np.random.default_rng(tick))
        flown.append(memory.drawn_us)
    assert flown == [0, 0, 0, 3_000_000, 3_000_000, 3_000_000, 6_000_000]


def test_speed_readings():
    wish = np.array([[30.0, 40.0], [3.0, 4.0]])
    assert flight.limit(wish, 10.0, "norm").tolist() == [[6.0, 8.0], [3.0, 4.0]]
    assert flight.limit(wish, 10.0, "component").tolist() == [[10.0, 10.0], [3.0, 4.0]]
    assert flight.limit(wish, 10.0, "none").tolist() == wish.tolist()


def test_reversal_at_the_boundary():
    at, grid = np.array([[995.0, 500.0], [500.0, 500.0]]), CASE.grid
    wish = np.array([[8.0, 6.0], [8.0, 6.0]])
    assert flight.turn_back(at, wish, grid, 1.0, 0.0, "vector").tolist() == [[-8, -6], [8, 6]]
    assert flight.turn_back(at, wish, grid, 1.0, 0.0, "component").tolist() == [[-8, 6], [8, 6]]
    corner = np.array([1.0, 999.0])
    assert grid.contains(
        corner + flight.turn_back(corner, np.array([-9.0, -9.0]), grid, 1.0, 0.0, "vector")
    )


def test_neighbours_are_carried_forward_and_forgotten():
    position, velocity = np.zeros((10, 2)), np.ones((10, 2))
    view = view_of(CASE, 0, position, velocity, np.full((10, 10), 0.5))
    heard = replace(view.neighbours, age_s=np.arange(9.0))
    others, _ = flight.neighbours(replace(view, neighbours=heard), 5.0)
    assert others.tolist() == [[age, age] for age in range(6)]


@pytest.mark.parametrize("seed", range(3))
def test_esustpm_finds_all_targets_in_time(seed):
    case = ideal.scenario()
    result = ideal.fly(bind(BUILTIN["esustpm"], case, {}), case, seed)
    assert result.done is not None
    assert result.done < 600


def test_esustpm_comes_back_to_a_cell_under_suspicion():
    """One hit lifts a cell to 0.947, below the threshold: it must be read again at once."""
    case = ideal.scenario()
    result = ideal.fly(bind(BUILTIN["esustpm"], case, {}), case, 1, noisy=False)
    assert set(result.declared) == set(ideal.TARGETS)
    assert not result.false


def test_mower_and_sweep_cover_everything_in_one_pass():
    for name in ("mower", "sweep"):
        case = ideal.scenario()
        result = ideal.fly(bind(BUILTIN[name], case, {}), case, 0, ticks=220, stop=False)
        assert result.coverage[-1] == 1.0
