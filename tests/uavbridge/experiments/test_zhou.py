"""Zhou 2023 in batches: laws of every run, the literal form's stall, limits beyond the paper."""

import math
import pickle
import time

import numpy as np
import pytest

from planners.search.mountain import MountainParams
from planners.terrain import mountains
from uavbridge.experiments import registry, runner, spread
from uavbridge.experiments.zhou import setting, table1, trace
from uavbridge.experiments.zhou.setting import ZhouParams
from uavbridge.experiments.zhou.world import World, simulate

NAMES = [name for name in registry.MODULES if name.startswith("zhou-")]


def fly(n=30, runs=3, world=None, params=None, slope_deg=40.0, side=600.0, targets=4):
    draws = [np.random.default_rng([5, run]) for run in range(runs)]
    starts = np.stack([draw.uniform(0.0, 100.0, (n, 2)) for draw in draws])
    places = np.stack([draw.uniform(100.0, side - 100.0, (targets, 2)) for draw in draws])
    ground = mountains(np.random.default_rng(3), (0.0, 0.0, side, side), math.radians(slope_deg))
    world = world or World(steps=600)
    return ground, simulate(ground, starts, places, draws, params or MountainParams(), world)


def ends(states):
    """Step at which each run was done."""
    done = {}
    for state in states:
        for row in np.flatnonzero(state.reached.all(axis=1)):
            done[int(state.run[row])] = state.t
    return done


def test_laws_of_every_step():
    ground, states = fly()
    west, south, east, north = ground.bounds
    before, members = {}, 0
    for state in states:
        x, y, z = np.moveaxis(state.position, -1, 0)
        assert z == pytest.approx(ground.height_at(state.position), abs=1e-9)
        assert (x >= west).all()
        assert (y >= south).all()
        assert (x <= east).all()
        assert (y <= north).all()
        told = state.robots.told
        for row, run in enumerate(state.run.tolist()):
            task = told.task[row][state.robots.member[row]]
            count = np.bincount(task, minlength=4)
            assert count.max() <= 6, "membership never exceeds N_m"
            members = max(members, int(count.max()))
            if run in before:
                old, roamed = before[run]
                step = state.position[row] - old
                level = np.hypot(step[:, 0], step[:, 1])
                assert (step[:, 2] <= math.tan(math.radians(30.0)) * level + 1e-6).all()
                assert (level <= 10.0 + 1e-9).all()
                assert roamed.shape == level.shape
            before[run] = state.position[row], ~state.robots.member[row]
    assert members == 6


def test_a_run_of_sixty_robots_takes_well_under_a_second():
    _, states = fly(60, 1, slope_deg=30.0, side=1000.0, targets=10)
    begin = time.process_time()
    assert len(ends(states)) == 1
    assert time.process_time() - begin < 1.0


def test_the_literal_form_stalls_and_the_escape_rules_do_not():
    """Members that contracted onto one point: R* = g* = R, so Eq. (9) moves nothing again."""
    found, last = {}, {}
    for escape in ("none", "roam", "current"):
        world, params = World(steps=300), MountainParams(escape=escape)
        _, states = fly(12, 6, world, params, targets=3)
        states = list(states)
        found[escape], last[escape] = len(ends(states)), states[-1].robots
    assert found["none"] < 6
    assert found["roam"] == found["current"] == 6
    speed = np.sqrt((last["none"].velocity ** 2).sum(axis=-1))
    assert (last["none"].member & (speed < 0.1)).sum() >= 2


def test_the_radio_that_loses_nothing_is_the_plain_one():
    plain = ends(fly(world=World(steps=600))[1])
    late = ends(fly(world=World(steps=600, delay=0, loss=1e-12))[1])
    assert len(plain) == len(late) == 3


@pytest.mark.parametrize(
    "change", [{"loss": 0.4}, {"delay": 3}, {"radio_m": 0.0}, {"radio_m": 1e4}]
)
def test_other_radios(change):
    assert len(ends(fly(world=World(steps=1500, **change))[1])) == 3


def test_a_robot_whose_energy_is_spent_stands():
    _, states = fly(world=World(steps=60, energy_m=100.0), targets=8)
    last = list(states)[-1]
    assert (last.driven <= 100.0 + 10.5).all()
    assert (last.driven >= 99.0).any()


def test_same_seeds_same_numbers_whatever_the_block():
    params = ZhouParams(domain_m=400.0)
    case, seeds = {"table": 4, "n_u": 30}, np.array([4, 5])
    whole = setting.measure(case, params, seeds, "ideal")
    for row in range(2):
        alone = setting.measure(case, params, seeds[row : row + 1], "ideal")
        for metric in whole:
            assert alone[metric][0] == pytest.approx(whole[metric][row])


def test_table_1():
    outcome = runner.run(table1.EXPERIMENT, spread.Here(), runs=1)
    assert len(outcome.rows) == 12
    assert all(row.mean == row.paper for row in outcome.rows)


@pytest.mark.parametrize("name", NAMES)
def test_experiments_travel_to_workers(name):
    found = registry.find(name)
    assert pickle.loads(pickle.dumps(found)).name == name
    assert found.cases(found.params())


@pytest.mark.parametrize("number", [3, 4])
def test_the_printed_numbers_stand_beside_ours(number):
    experiment = registry.find(f"zhou-table{number}")
    values = {"domain_m": 300.0, "robots": "30,60"}
    outcome = runner.run(experiment, spread.Here(), runs=2, values=values)
    for row in outcome.rows:
        assert row.case in ({"table": number, "n_u": 30}, {"table": number, "n_u": 60})
        assert (row.paper is None) == (row.metric == "found")
    metrics = {row.metric for row in outcome.rows}
    assert {"steps", "energy", "unfinished", "steps_sd", "energy_sd"} <= metrics


def test_the_readings_are_all_parameters():
    case = {"table": 3, "n_u": 30}
    for label in setting.READINGS:
        assert setting.read(ZhouParams(), {**case, "reading": label}) != ZhouParams()
    assert setting.read(ZhouParams(), {**case, "radio_m": 50.0}).radio_m == 50.0


def test_a_trace_tells_who_found_what():
    run = trace.trace({"table": 4, "n_u": 30}, ZhouParams(domain_m=500.0), 3)
    for target, (step, robot) in enumerate(zip(run.reached_at, run.reached_by, strict=True)):
        there = run.tracks[step - 1, robot]
        goal = (*run.targets[target], run.terrain.height_at(run.targets[target]))
        assert math.dist(there, goal) < 10.0


@pytest.mark.parametrize("robots", ["30,x", "0", ""])
def test_numbers_of_robots_that_are_none(robots):
    from uavbridge.errors import ConfigError

    with pytest.raises(ConfigError, match="zhou-table3: robots must be"):
        runner.run(registry.find("zhou-table3"), spread.Here(), runs=1, values={"robots": robots})
