"""Shao 2020 in batches: laws of every run, fixed routes, faults, leaders, the whole scenario."""

import pickle

import numpy as np
import pytest

from uavbridge.errors import ConfigError
from uavbridge.experiments import registry, runner, spread
from uavbridge.experiments.shao import detect, faults, ground, navigate, places, scenario, sweeps
from uavbridge.experiments.shao.detect import DetectParams
from uavbridge.experiments.shao.faults import FaultParams
from uavbridge.experiments.shao.world import NEVER, World, simulate

NAMES = [name for name in registry.MODULES if name.startswith("shao-")]
SMALL = DetectParams(size=24, targets=3, period=60, steps=300, uavs="3", obstacles=0.08)
SEEDS = np.arange(1, 4)


def drawn(n=4, size=24, runs=3, share=0.1):
    draws = [np.random.default_rng([7, run]) for run in range(runs)]
    return ground.draw(draws, size, 3, n, share, "anywhere"), draws


def test_laws_of_every_step():
    made, draws = drawn()
    before, heading, seen = made.starts, made.headings, 0.0
    for state in simulate(made, draws, World(period=40), 250):
        step = np.abs(state.cells - before).max(axis=-1)
        assert (step <= 1).all()
        run = np.arange(3)[:, None]
        assert not made.obstacles[run, state.cells[..., 0], state.cells[..., 1]].any()
        turn = np.abs((state.heading - heading + 4) % 8 - 4)
        assert (turn <= 2).mean() > 0.9, "backwards in dead ends only"
        covered = ground.shares(state.seen).sum()
        assert covered >= seen
        assert (state.found_at[state.due_at != NEVER] != NEVER).all()
        assert state.field.path.min() >= 0.1 - 1e-12
        before, heading, seen = state.cells, state.heading, covered
    assert (state.found_at != NEVER).all()
    assert sum(len(answer.run) for answer in state.answered) > 10
    for answer in state.answered:
        assert (answer.response >= 0).all()


def test_a_run_does_not_depend_on_the_others():
    made, draws = drawn()
    *_, together = simulate(made, draws, World(), 60)
    alone_made, alone_draws = drawn()
    part = ground.Ground(
        alone_made.obstacles[1:2], alone_made.targets[1:2], alone_made.starts[1:2],
        alone_made.headings[1:2],
    )  # fmt: skip
    *_, alone = simulate(part, alone_draws[1:2], World(), 60)
    np.testing.assert_array_equal(together.cells[1], alone.cells[0])
    np.testing.assert_array_equal(together.field.path[1], alone.field.path[0])


def test_all_free_cells_of_a_ground_can_be_reached():
    made, _ = drawn(share=0.3)
    for obstacles in made.obstacles:
        assert (ground.reached(~obstacles) == ~obstacles).all()


@pytest.mark.parametrize("sweepers", [1, 3, 8])
def test_sensor_wide_lanes_see_all_free_cells_and_never_fly_through_obstacles(sweepers):
    made, _ = drawn(runs=2)
    track = sweeps.tracks(made, sweepers, 9, 600)
    run = np.arange(2)[:, None, None]
    assert not made.obstacles[run, track[..., 0], track[..., 1]].any()
    assert (np.abs(np.diff(track, axis=1)).max(axis=-1) <= 1).all()
    covered = sweeps.coverage(made, track, 4.0, (600,))[:, 0]
    free = (~made.obstacles).mean(axis=(1, 2))
    assert (covered > 0.97 * free).all()


def test_case_names_and_metrics_are_as_agreed():
    samples = detect.simulate_case((0, 100, 300), {"n_uav": 3}, SMALL, SEEDS, "ideal")
    wanted = {"steps_all_found", "revisit_response", "revisits"}
    wanted |= {f"coverage_at_{step}" for step in (100, 185, 500)}
    assert wanted <= set(samples)
    assert np.isnan(samples["coverage_at_500"]).all()
    assert (samples["coverage_at_185"] >= samples["coverage_at_100"]).all()
    keys = [frozenset(case) for case in detect.cases(DetectParams())]
    for key in ({"n_uav"}, {"n_uav", "random_share"}, {"n_uav", "recovery"}):
        assert frozenset(key) in keys


def test_more_uavs_find_sooner_and_the_maximum_alone_starves_targets():
    few, many = (
        detect.simulate_case((0,), {"n_uav": n}, SMALL, np.arange(8), "ideal") for n in (1, 8)
    )
    assert np.nanmean(many["steps_all_found"]) < np.nanmean(few["steps_all_found"])
    assert many["revisits"].mean() > few["revisits"].mean()


def test_pheromones_go_on_where_fixed_routes_leave_gaps():
    params = FaultParams(
        size=30, targets=4, period=80, steps=400, swept_uavs=6, fail_from=2, fail_to=10
    )
    case = {"failed": 4}
    found = {
        search: faults.simulate_case({"search": search, **case}, params, np.arange(4), "ideal")
        for search in faults.SEARCHES
    }
    assert found["pheromones"]["coverage"].mean() > found["routes"]["coverage"].mean()


@pytest.fixture(scope="module")
def navigated():
    params = navigate.NavigateParams(size=61, steps=200)
    return {
        tuple(case.items()): navigate.simulate(case, params, np.arange(3), "ideal")
        for case in navigate.cases(params)
        if "reading" not in case
    }


def test_the_vector_leader_needs_fewer_steps_than_one_cell_at_a_time(navigated):
    steps = {name: navigated[("leader", name),]["iterations"] for name in navigate.LEADERS}
    assert all(navigated[("leader", name),]["arrived"].all() for name in ("vector", "scalar-2"))
    assert steps["vector"].mean() < 0.85 * np.nanmean(steps["scalar-1"])
    assert abs(steps["vector"].mean() - steps["scalar-2"].mean()) < 8.0


def test_followers_keep_to_the_leader_in_the_working_form_only(navigated):
    working, printed = (navigated[("form", form),] for form in ("working", "printed"))
    assert working["leader_distance"].max() < 8.0
    assert working["nearest_pair"].mean() > 0.5
    assert np.median(printed["leader_distance"]) > 1000.0


def test_the_group_arrives_and_finds_and_revisits_all():
    params = scenario.ScenarioParams(size=50, region=20, targets=3, period=60, steps=400)
    samples = scenario.simulate_case({"n_uav": 5}, params, np.arange(2), "ideal")
    assert (samples["steps_there"] < samples["steps_all_found"]).all()
    assert (samples["steps_all_found"] < samples["steps_all_revisited"]).all()
    assert samples["group_radius"].max() < 15.0


@pytest.mark.parametrize("name", NAMES)
def test_experiments_can_be_sent_to_workers(name):
    assert pickle.loads(pickle.dumps(registry.find(name))).name == name


def test_runs_make_rows_and_wrong_lists_are_refused():
    values = {
        "size": 20, "targets": 2, "steps": 120, "uavs": "2", "swept_uavs": 2,
        "random_shares": "0.5", "recoveries": "0.01",
    }  # fmt: skip
    experiment = registry.find("shao-detect-50")
    outcome = runner.run(experiment, spread.Here(), runs=2, values=values)
    assert {row.metric for row in outcome.rows} >= {"steps_all_found", "coverage_at_100"}
    for wrong in ({"uavs": "two"}, {"uavs": "0"}, {"random_shares": "1.5"}):
        with pytest.raises(ConfigError, match=next(iter(wrong))):
            runner.run(experiment, spread.Here(), runs=1, values=wrong)


def test_forms_of_the_map_are_the_missions():
    params = places.PlacesParams()
    for case in places.cases(params):
        mission = places.mission_of(case, params, 3)
        assert mission.clock == "stepped"
        assert bool(mission.pheromones.failures) == ("failed" in case)
