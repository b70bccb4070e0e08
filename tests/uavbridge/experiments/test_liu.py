"""Liu 2022 in batches, against the paper's own numbers and against the planners one by one."""

from dataclasses import replace

import numpy as np
import pytest

from planners.belief.merge import SensorModel
from planners.types import FlyVelocity, GoTo, Neighbours, View
from uavbridge.experiments.experiment import generators
from uavbridge.experiments.liu import measures, prior, table2
from uavbridge.experiments.liu.methods import method
from uavbridge.experiments.liu.setting import GRID, METHODS, TARGETS, LiuParams
from uavbridge.experiments.liu.world import search

PARAMS = LiuParams()
SEEDS = np.array([11, 12])
# Readings under which the batch must still be the planners, beside the default.
READINGS = (
    ("esustpm", {"speed_reading": "norm"}),
    ("esustpm", {"speed_reading": "none"}),
    ("esustpm", {"keep": "best", "escape_ratio": 0.5, "boundary": "component"}),
    ("esustpm", {"turns": "together", "neighbours": 1, "guide_law": "away"}),
    ("esustpm", {"ties": "lowest", "guide_point": "corner", "guide_law": "towards"}),
    ("boids-guided", {"keep": "best", "escape_ratio": 0.5}),
    ("boids", {"boids_speed_m": 14.14, "turns": "together"}),
    ("mower", {"mower_starts": "printed"}),
    ("random", {"update_on": "cycle", "start_cells": "read"}),
)


def fly(planner, case, params, draw, targets):
    """The same search through the planner seam: views, goals, one agent after the other."""
    team, sensor = len(case.team), SensorModel(params.p_d, params.p_f, params.update)
    position, velocity = case.starts.copy(), np.zeros((team, 3))
    belief = np.full(GRID.shape, params.prior)
    cell = np.clip(GRID.cell_of(position), 0, 9)
    memory = [None] * team
    tracks = [position[:, :2].copy()]

    def read(at):
        belief[at] = sensor.after(belief[at], at in targets)

    if params.start_cells == "read":
        for at in map(tuple, cell.tolist()):
            read(at)
    for cycle in range(params.cycles):
        old = (position.copy(), velocity.copy(), belief.copy())
        for agent in range(team):
            known = old if params.turns == "together" else (position, velocity, belief)
            others = np.delete(np.arange(team), agent)
            view = View(
                t_us=round(cycle * case.tick_s * 1e6),
                tick=cycle,
                agent=case.team[agent],
                position=position[agent].copy(),
                velocity=velocity[agent].copy(),
                heading_rad=np.pi / 2,
                neighbours=Neighbours(
                    others + 1, known[0][others], known[1][others], np.zeros(team - 1)
                ),
                belief=known[2].copy(),
                seen=np.zeros(GRID.shape, bool),
            )
            if cycle == 0:
                memory[agent] = planner.init(view)
            goal, memory[agent] = planner.plan(view, memory[agent], draw)
            velocity[agent] = flown(goal.setpoint, position[agent], case.tick_s)
            position[agent] += velocity[agent] * case.tick_s
            now = np.clip(GRID.cell_of(position[agent]), 0, 9)
            if params.update_on == "cycle" or (now != cell[agent]).any():
                read(tuple(now.tolist()))
            cell[agent] = now
        tracks.append(position[:, :2].copy())
    return np.array(tracks), belief


def flown(setpoint, position, step_s):
    if isinstance(setpoint, FlyVelocity):
        return setpoint.velocity
    assert isinstance(setpoint, GoTo)
    offset = setpoint.position - position
    distance = np.hypot(*offset[:2])
    return offset / max(distance, 1e-300) * min(setpoint.speed_m_s, distance / step_s)


@pytest.mark.parametrize(
    ("name", "changes"), [*((name, {}) for name in METHODS), *READINGS], ids=str
)
def test_the_batch_flies_as_the_planners_do(name, changes):
    params = replace(PARAMS, cycles=35, **changes)
    batch = search(method(name, params), params, generators(SEEDS), TARGETS)
    for run, draw in enumerate(generators(SEEDS)):
        one = method(name, params)
        tracks, belief = fly(one.planner(), one.scenario, params, draw, TARGETS)
        np.testing.assert_allclose(batch.tracks[run], tracks, atol=1e-6)
        np.testing.assert_allclose(batch.belief[run], belief, atol=1e-12)


def one(name, targets, **changes):
    params = replace(PARAMS, **changes)
    case = {"method": name, "targets": targets}
    return measures.numbers(measures.course(case, params, SEEDS[:1]), params)


def test_the_mowers_uncertainty_is_the_printed_one():
    mower = one("mower", targets=False)
    assert mower["uncertainty"][0] == pytest.approx(52.342, abs=5e-4)
    assert mower["coverage_cycle"][0] == 90
    assert mower["visited_cells"][0] == 100


def test_the_mowers_uncertainty_with_targets_is_not_the_printed_one():
    mower = one("mower", targets=True)
    assert mower["uncertainty"][0] == pytest.approx(51.187, abs=5e-4)  # printed: 52.34
    assert mower["targets_found"][0] == 0  # 0.5, 0.75, 0.9 < theta


def test_with_bayes_rule_the_mowers_uncertainty_is_another():
    assert one("mower", False, update="bayes")["uncertainty"][0] == pytest.approx(52.88, abs=5e-3)


def test_an_untouched_map_has_50():
    params = replace(PARAMS, cycles=1, start_cells="unvisited")
    start = search(method("mower", params), params, generators(SEEDS[:1]), ())
    assert start.uncertainty[0, 0] == 50.0
    assert start.entropy[0, 0] == 100.0
    assert start.visited[0, 0] == 0


def test_the_stop_rules():
    seeds = np.arange(6)
    case = {"method": "esustpm", "targets": True}
    params = replace(PARAMS, cycles=120)
    whole = measures.course(case, params, seeds)
    found = whole.found.max(axis=1)
    ended = measures.course(case, replace(params, stop="targets"), seeds)
    every = (whole.found >= 0).all(axis=1)
    assert every.any()
    np.testing.assert_array_equal(ended.stopped[every], found[every])
    for run in np.flatnonzero(every):
        at = found[run]
        assert (ended.visited[run, at:] == whole.visited[run, at]).all()
    certain = replace(params, stop="uncertainty", uncertainty_goal=47.0)
    low = measures.course(case, certain, seeds)
    first = [np.flatnonzero(run < 47.0)[:1] for run in whole.uncertainty]
    assert [int(run[0]) if len(run) else -1 for run in first] == low.stopped.tolist()
    both = measures.course(case, replace(certain, stop="both"), seeds)
    either = measures.course(case, replace(certain, stop="either"), seeds)
    assert ((both.stopped < 0) | (both.stopped >= low.stopped)).all()
    assert (either.stopped[every] <= found[every]).all()


def test_orders_of_the_paper_that_hold():
    values = {name: one(name, targets=True) for name in METHODS}
    uncertainty = {name: float(part["uncertainty"][0]) for name, part in values.items()}
    assert min(uncertainty, key=uncertainty.get) == "esustpm"
    assert max(uncertainty, key=uncertainty.get) == "mower"
    visited = {name: float(part["visited_cells"][0]) for name, part in values.items()}
    assert visited["random"] < visited["boids"] < visited["esustpm"]


def test_readings_are_cases_of_the_methods_they_concern():
    cases = table2.cases(table2.Params())
    assert [case for case in cases if "reading" not in case] == [
        {"method": name, "targets": targets} for name in METHODS for targets in (True, False)
    ]
    read = {(case["reading"], case["method"]) for case in cases if "reading" in case}
    assert ("speed_reading=norm", "esustpm") in read
    assert ("speed_reading=component", "esustpm") not in read  # the default
    assert ("boids_speed_m=14.14", "boids") in read


def test_a_good_prior_helps_a_wrong_one_fades():
    seeds = np.arange(10)
    told = {
        name: prior.simulate({"prior": name}, prior.Params(), seeds, "ideal")
        for name in prior.TRUTH
    }
    assert np.median(told["accurate"]["target_3_cycle"]) < np.nanmedian(
        told["none"]["target_3_cycle"]
    )
    assert (told["false-target"]["wrong_cell_probability"] < 0.5).all()
    assert told["hidden-target"]["targets_found"].mean() > 0.5


def test_the_prior_expects_the_targets():
    expected = prior.prior_map(prior.Params())
    best = sorted(zip(*np.unravel_index(expected.argsort(axis=None)[-3:], (10, 10)), strict=True))
    assert [tuple(map(int, cell)) for cell in best] == sorted(TARGETS)
