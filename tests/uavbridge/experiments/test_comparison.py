"""Planners on one mission: the light worlds against each other and against the whole system."""

import json

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner

from planners.types import FlySegment, Neighbours
from uavbridge import config
from uavbridge.cli import main
from uavbridge.experiments import runner, spread
from uavbridge.experiments.comparison import compare, gap, points
from uavbridge.experiments.comparison.bodies import _ahead
from uavbridge.experiments.comparison.trial import Ages, components
from uavbridge.experiments.intervals import half_width, t_quantile
from uavbridge.radio.radio import Radio
from uavbridge.runner import assemble

SMALL = """
name = "small"
duration = 40
coverage_goal = 1.0
vehicles = 2
[area]
cell_m = 40
columns = 3
rows = 2
[fleet]
starts = [[20, 20], [100, 20]]
[[targets]]
position = [60, 60]
"""


@pytest.fixture
def mission(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return str(path)


def params(mission, planners="mower,esustpm", **changes):
    return compare.CompareParams(planners=planners, mission=mission, **changes)


def trial_of(asked, planner, seed, fidelity):
    (trial,) = compare.trials(asked, planner, [seed], fidelity)
    return trial


def test_the_same_seed_the_same_trial(mission):
    one, other = (trial_of(params(mission), "esustpm", 5, "ideal") for _ in range(2))
    assert one.curves == other.curves
    assert trial_of(params(mission), "esustpm", 6, "ideal").curves != one.curves


@pytest.mark.parametrize("fidelity", ["ideal", "dynamics"])
def test_a_trial_ends_with_the_goal_or_the_time(mission, fidelity):
    trial = trial_of(params(mission), "mower", 2, fidelity)
    assert trial.t_s[0] == 0.0
    assert trial.t_s == sorted(trial.t_s)
    if np.isnan(trial.goal_s):
        assert trial.t_s[-1] == 40.0
    else:
        assert trial.t_s[-1] == trial.goal_s <= 40.0
        assert trial.curves["targets_found"][-1] == 1
    assert (np.diff(trial.curves["coverage"]) >= 0).all()
    assert (np.diff(trial.curves["bytes_per_agent"]) > 0).all()


def test_vehicles_take_longer_than_points(mission):
    ideal, flown = (
        trial_of(params(mission), "mower", 3, fidelity) for fidelity in ("ideal", "dynamics")
    )
    assert ideal.covered_s < flown.covered_s < ideal.covered_s + 20.0


@pytest.mark.parametrize("fidelity", ["ideal", "dynamics"])
def test_missions_side_by_side_are_missions_alone(mission, fidelity):
    asked = params(mission)
    together = compare.trials(asked, "esustpm", [3, 4, 5], fidelity)
    alone = [trial_of(asked, "esustpm", seed, fidelity) for seed in (3, 4, 5)]
    assert [one.curves for one in together] == [one.curves for one in alone]
    assert [one.declared for one in together] == [one.declared for one in alone]


def test_out_of_range_nobody_hears(mission):
    loaded = config.load(mission, {"radio.range_m": 10.0, "planner": "mower", "duration": 6.0})
    loaded = msgspec.structs.replace(loaded, seed=1)
    search = points.Search(loaded, assemble.planner_of(loaded))
    (trial,) = points.run([search], flown=False)
    assert trial.curves["components"][-1] == 2
    assert trial.curves["age_s"][-1] == 6.0
    assert all(len(agent.hearing.neighbours(6_000_000)) == 0 for agent in search.agents)


def test_a_frame_is_heard_a_tick_later(mission):
    loaded = config.load(mission, {"planner": "mower", "duration": 3.0})
    search = points.Search(loaded, assemble.planner_of(loaded))
    points.run([search], flown=False)
    heard = search.agents[0].hearing.neighbours(3_000_000)
    assert heard.ids.tolist() == [2]
    assert heard.age_s.tolist() == [1.0]


def test_components_are_joined_through_others():
    line = np.array([(0.0, 0, 0), (90.0, 0, 0), (180.0, 0, 0), (400.0, 0, 0)])
    assert components(line, Radio(100.0)) == 2
    assert components(line, Radio(50.0)) == 4
    assert components(line, Radio(np.inf)) == 1


def test_ages_count_from_the_last_word():
    ages = Ages((3, 7))
    assert ages.mean(5.0) == 5.0
    ages.heard(
        3, Neighbours(np.array([7]), np.zeros((1, 3)), np.zeros((1, 3)), np.array([2.0])), 5.0
    )
    assert ages.mean(5.0) == (2.0 + 5.0) / 2
    ages.heard(3, Neighbours.none(), 9.0)
    assert ages.mean(9.0) == (6.0 + 9.0) / 2


def test_along_a_segment():
    segment = FlySegment(np.zeros(3), np.array([100.0, 0.0, 0.0]))
    assert _ahead(segment, np.array([30.0, 20.0, 0.0]), 5.0).tolist() == [35.0, 0.0, 0.0]
    assert _ahead(segment, np.array([300.0, 0.0, 0.0]), 5.0).tolist() == [100.0, 0.0, 0.0]


def test_students_quantiles():
    for freedom, value in ((1, 12.706), (4, 2.776), (9, 2.262), (19, 2.093), (99, 1.984)):
        assert t_quantile(freedom) == pytest.approx(value, abs=2e-3)
    assert half_width(2.0, 4) == pytest.approx(3.182, abs=6e-3)


def test_differences_are_run_by_run(mission):
    values = {"planners": "mower,random,mower", "mission": mission}
    outcome = runner.run(compare.EXPERIMENT, spread.Here(), runs=3, values=values)
    assert [case["planner"] for case, _ in outcome.samples] == ["mower", "random"]
    first, second = (samples for _, samples in outcome.samples)
    row = next(row for row in outcome.rows if row.metric == "entropy_difference")
    assert row.case == {"planner": "random"}
    assert row.mean == pytest.approx(float((second["entropy"] - first["entropy"]).mean()))
    again = runner.run(
        compare.EXPERIMENT,
        spread.Here(),
        runs=3,
        values={**values, "planners": "random"},
    )
    np.testing.assert_array_equal(again.of(planner="random")["entropy"], second["entropy"])


def test_the_gap_to_point_masses(mission):
    values = {"planners": "mower", "mission": mission, "fidelities": "ideal,dynamics"}
    outcome = runner.run(gap.EXPERIMENT, spread.Here(), runs=2, values=values)
    row = next(row for row in outcome.rows if row.metric == "coverage_s_gap")
    assert row.case == {"planner": "mower", "fidelity": "dynamics"}
    assert row.n == 2
    assert row.mean > 0.0


def test_the_same_mission_through_the_whole_system(mission):
    flown = trial_of(params(mission), "mower", 3, "mavlink")
    ideal = trial_of(params(mission), "mower", 3, "ideal")
    assert flown.t_s[0] == 0.0
    assert flown.curves["coverage"][-1] == 1.0
    assert abs(flown.covered_s - ideal.covered_s) < 15.0
    assert flown.curves["bytes_per_agent"][-1] > 0.0
    assert max(flown.curves["age_s"]) <= 3.0


def test_command(mission, tmp_path):
    arguments = ["compare", "--planner", "mower,random", "--mission", mission]
    told = CliRunner().invoke(
        main, [*arguments, "--runs", "2", "--workers", "1", "--out", str(tmp_path / "out")]
    )
    assert told.exit_code == 0, told.output
    assert "95 % interval" in told.stdout
    rows = json.loads((tmp_path / "out" / "compare.json").read_text())
    assert {row["case"]["planner"] for row in rows} == {"mower", "random"}
    assert (tmp_path / "out" / "compare.png").stat().st_size > 10_000
    page = (tmp_path / "out" / "compare.md").read_text()
    assert "uavbridge compare --planner mower,random --mission" in page


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--planner", "mower,hover"), "unknown planner 'hover'"),
        (("--planner", "mower", "--mission", "nowhere.toml"), "nowhere.toml"),
        (("--planner", "mower", "--fidelity", "real"), "no fidelity 'real'"),
        (("--planner", "mower", "--duration", "-1"), "parameter duration must be 0 to 86400"),
    ],
    ids=lambda value: value[-1] if isinstance(value, tuple) else "",
)
def test_bad_input_is_one_line(arguments, told):
    result = CliRunner().invoke(main, ["compare", *arguments])
    assert result.exit_code == 2
    assert told in result.stderr.strip().splitlines()[-1]


@pytest.mark.parametrize(
    ("kind", "fidelity"), [("rover", "ideal"), ("multirotor", "ideal"), ("rover", "dynamics")]
)
def test_signals_are_followed_over_mountains(tmp_path, kind, fidelity):
    path = tmp_path / "hills.toml"
    path.write_text(
        'name = "hills"\nplanner = "mountain"\nvehicles = 4\nduration = 400\n'
        "[area]\ncell_m = 50\ncolumns = 6\nrows = 6\n"
        "[terrain]\nseed = 3\nsteepest_deg = 35\nhills = 6\n"
        "[signals]\nrange_m = 150\narrival_m = 25\n"
        f'[fleet]\nkind = "{kind}"\naltitude_m = 25\nspacing_m = 12\n'
        "[safety]\nseparation_m = 3\n"
        "[[targets]]\nposition = [80, 80]\n"
    )
    trial = trial_of(params(str(path), "mountain"), "mountain", 1, fidelity)
    assert trial.curves["targets_found"][-1] == 1.0
    assert trial.goal_s < 400.0
