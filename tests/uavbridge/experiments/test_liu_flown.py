"""Liu's search with vehicles: the same figures, a little later."""

from dataclasses import replace

import numpy as np
import pytest

from uavbridge.errors import ConfigError
from uavbridge.experiments.liu import measures, missions, prior
from uavbridge.experiments.liu.methods import method
from uavbridge.experiments.liu.setting import LiuParams
from uavbridge.runner import assemble

PARAMS = replace(LiuParams(), cycles=40)
SEEDS = np.array([3, 4])


def course(method, fidelity, targets=True, params=PARAMS):
    return measures.course({"method": method, "targets": targets}, params, SEEDS, fidelity)


def test_vehicles_sweep_like_point_masses_with_lag():
    ideal, flown = (course("mower", fidelity) for fidelity in ("ideal", "dynamics"))
    np.testing.assert_allclose(flown.tracks[..., 0], ideal.tracks[..., 0], atol=1e-3)
    behind = ideal.tracks[0, -1, :, 1] - flown.tracks[0, -1, :, 1]
    assert (behind > 5.0).all()
    assert (behind < 40.0).all()
    assert (np.diff(flown.visited, axis=1) >= 0).all()


def test_the_batch_of_vehicles_is_its_runs():
    both = course("esustpm", "dynamics")
    case = {"method": "esustpm", "targets": True}
    for run in range(2):
        one = measures.course(case, PARAMS, SEEDS[run : run + 1], "dynamics")
        np.testing.assert_allclose(one.tracks[0], both.tracks[run], atol=1e-6)
        np.testing.assert_allclose(one.belief[0], both.belief[run], atol=1e-12)


def test_a_vehicle_that_stopped_stays():
    params = replace(PARAMS, stop="uncertainty", uncertainty_goal=50.2)
    flown = course("random", "dynamics", params=params)
    run = int(np.flatnonzero(flown.stopped >= 0)[0])
    at = flown.stopped[run]
    assert (flown.tracks[run, at:] == flown.tracks[run, at]).all()
    assert (flown.uncertainty[run, at:] == flown.uncertainty[run, at]).all()


def test_through_the_whole_system():
    params = replace(LiuParams(), cycles=12)
    seeds = SEEDS[:1]
    flown = measures.course({"method": "mower", "targets": True}, params, seeds, "mavlink")
    again = measures.course({"method": "mower", "targets": True}, params, seeds, "mavlink")
    assert flown.tracks.shape == (1, 13, 10, 2)
    np.testing.assert_array_equal(flown.tracks, again.tracks)
    np.testing.assert_allclose(
        flown.tracks[0, :, :, 0], np.full((13, 10), np.arange(50, 1000, 100)), atol=2.0
    )
    assert flown.visited[0, -1] == 20  # ten start cells, and the next of each
    metrics = measures.numbers(flown, params)
    assert np.isfinite(metrics["uncertainty"]).all()


def test_what_missions_cannot_do_is_told():
    with pytest.raises(ConfigError, match="stop early"):
        course("mower", "mavlink", params=replace(PARAMS, stop="targets"))


def test_missions_begin_with_the_prior_map():
    params = prior.Params(cycles=6)
    searcher = method("esustpm", params, flown=True)
    belief = missions.belief_of(params, **prior.mission_keys(params))
    mission = missions.mission_of("esustpm", params, searcher, 1, (), belief)
    np.testing.assert_array_equal(mission.prior(), prior.prior_map(params))
    (plan, *_) = assemble.agent_plans(mission, searcher.planner())
    np.testing.assert_array_equal(plan.prior, prior.prior_map(params))


def test_priors_fly():
    params = prior.Params(cycles=6)
    told = prior.simulate({"prior": "false-target"}, params, np.array([1]), "mavlink")
    assert told["wrong_cell_probability"].tolist() == [
        pytest.approx(0.8, abs=0.01)
    ]  # not there so soon
    assert told["uncertainty"][0] < 45.0  # a map at 0.5 has 50
