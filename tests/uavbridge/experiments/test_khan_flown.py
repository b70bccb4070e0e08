"""Khan's searches as missions: the same setting, with vehicles, and steered by their maps."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from planners.belief.merge import MERGE_RULES
from uavbridge.cli import main
from uavbridge.config import rules
from uavbridge.errors import ConfigError
from uavbridge.experiments import registry, runner, spread
from uavbridge.experiments.comparison import points
from uavbridge.experiments.comparison.trial import Trial
from uavbridge.experiments.khan import choices, missions, steers, study
from uavbridge.experiments.khan.choices import Scale
from uavbridge.experiments.khan.world import Luck, entries, loop_of
from uavbridge.plugins import planners
from uavbridge.runner import assemble

PARAMS = study.FlownParams()
SMALL = {"columns": 3, "rows": 3, "target_column": 2, "target_row": 1, "threshold": 0.9}


def mission(rule="BU", uavs=3, reach=2, seed=4, **changes):
    return missions.mission_of(replace(PARAMS, **changes), PARAMS.scale, rule, uavs, reach, seed)


@pytest.mark.parametrize("rule", missions.MERGE)
def test_the_mission_is_the_papers_setting(rule):
    flown = mission(rule)
    rules.check(flown, planners())
    assert (flown.sensor.p, flown.sensor.q, flown.belief.threshold) == (0.9, 0.2, 0.99)
    assert flown.target_cells() == ((6, 7),)
    assert flown.radio.range_m == 2 * PARAMS.cell_m
    assert flown.belief.merge in MERGE_RULES
    paper = choices.rules(PARAMS)
    if rule in paper:
        assert MERGE_RULES[flown.belief.merge] == paper[rule]


def test_vehicles_start_where_the_papers_uavs_do_and_fly_the_same_loop():
    seeds = np.arange(20)
    start = Luck(seeds, 3, PARAMS).start
    cells = (start[..., 0] * 100).astype(int)
    loop = loop_of(PARAMS)
    entry = entries(loop, start, PARAMS)
    for seed in seeds.tolist():
        flown = mission(seed=seed)
        own = flown.grid.cell_of(np.array(flown.fleet.starts)) @ (10, 1)
        assert len(set(own.tolist())) == 3
        if len(set(cells[seed].tolist())) == 3:
            assert own.tolist() == cells[seed].tolist()
            planner = assemble.planner_of(flown)
            for place, points in enumerate(planner.loops):
                there = flown.grid.cell_of(points) @ (10, 1)
                ahead = np.roll(loop, -entry[seed, place])
                assert there[0] == ahead[0]
                assert np.isin(there, ahead).all()


def test_steps_are_counted_from_the_first_cell():
    scale = Scale(cell_m=20.0, speed_m_s=10.0, flight_s=100.0)
    assert [scale.step(t_s) for t_s in (0.0, 0.9, 1.0, 2.9, 3.0)] == [1, 1, 2, 2, 3]


def test_what_missions_do_their_own_way_is_told():
    with pytest.raises(ConfigError, match="exchange must stay current"):
        mission(exchange="whole")
    with pytest.raises(ConfigError, match="200 UAVs need as many cells"):
        mission(uavs=200)


def test_the_table_flies():
    values = {**SMALL, "uavs": "2", "ranges": "1,4", "rules": "BU", "flight_s": 20.0}
    outcome = runner.run(
        registry.find("khan-table2"), spread.Here(), runs=2, values=values, fidelity="dynamics"
    )
    assert [dict(case) for case, _ in outcome.samples] == [
        {"N": 2, "range": reach, "rule": rule} for reach in (1, 4) for rule in ("UNC", "BU")
    ]
    alone, again = outcome.of(N=2, range=1, rule="UNC"), outcome.of(N=2, range=4, rule="UNC")
    assert alone is again  # who merges nothing is flown once
    for _, samples in outcome.samples:
        assert (samples["steps"] >= 1).all()
        assert (samples["steps"] <= PARAMS.scale.step(20.0)).all()
    assert {row.metric for row in outcome.rows} == {"steps", "error_percent", "gain_percent"}


def test_it_flies_through_the_whole_system():
    setting = replace(PARAMS, **SMALL, flight_s=8.0)
    case = {"N": 2, "range": 4, "rule": "SDS"}
    samples = study.simulate(case, setting, np.array([1]), "mavlink")
    assert 1 <= samples["steps"][0] <= setting.scale.step(8.0)


def trial(**declared):
    one = Trial(100.0)
    one.declared = {(int(cell[1]), int(cell[2])): t_s for cell, t_s in declared.items()}
    one.curves["bytes_per_agent"].append(5.0)
    return one


def test_a_steered_search_ends_with_the_target_and_counts_what_was_named_first():
    told = steers._metrics([trial(c11=30.0, c22=10.0), trial(c11=7.0), trial()], (1, 1), 100.0)
    assert told["found_s"].tolist() == [30.0, 7.0, 100.0]
    assert told["named_s"].tolist() == [10.0, 7.0, 100.0]
    assert told["found_percent"].tolist() == [100.0, 100.0, 0.0]
    assert told["error_percent"].tolist() == [100.0, 0.0, 100.0]


def test_every_rule_steers_every_planner():
    values = {**SMALL, "uavs": 2, "flight_s": 12.0, "ranges": "2"}
    values["planners"] = "esustpm,boids-guided,sweep"
    outcome = runner.run(registry.find("merge-steers"), spread.Here(), runs=2, values=values)
    assert len(outcome.samples) == 3 * len(missions.MERGE)
    gains = [row for row in outcome.rows if row.metric == "gain_percent"]
    assert len(gains) == 3 * (len(missions.MERGE) - 1)
    assert all(row.n == 2 for row in gains)
    for _, samples in outcome.samples:
        assert (samples["named_s"] <= samples["found_s"]).all()


def test_merged_maps_change_where_vehicles_go():
    setting = replace(PARAMS, **{**SMALL, "threshold": 0.999})

    def goals(rule):
        flown = missions.mission_of(
            setting, Scale(100.0, 10.0, 40.0), rule, 3, 14, 5,
            planner="esustpm", parameters={}, tick=1.0,
        )  # fmt: skip
        search = points.Search(flown, assemble.planner_of(flown))
        points.run([search], flown=False)
        return np.array([agent.goal.setpoint.velocity for agent in search.agents])

    assert not np.array_equal(goals("UNC"), goals("SDS"))


def test_texts_that_read_like_numbers_are_texts():
    run = ["experiment", "khan-table2", "--runs", "2", "--workers", "1", "--json"]
    chosen = ["--set", "uavs=2", "--set", "ranges=14", "--set", "rules=BU", "--set", "q=0.1"]
    told = CliRunner().invoke(main, [*run, *chosen])
    assert told.exit_code == 0, told.output
    cases = [row["case"] for row in json.loads(told.stdout)]
    assert all(
        case in [{"N": 2, "range": 14, "rule": rule} for rule in ("UNC", "BU")] for case in cases
    )


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("uavs=two", "uavs must be whole numbers from 1 on"),
        ("ranges=2.5", "ranges must be whole numbers from 0 on"),
        ("rules=XYZ", "unknown rule 'XYZ'"),
    ],
)
def test_bad_lists_are_one_line(setting, told):
    result = CliRunner().invoke(main, ["experiment", "khan-table2", "--set", setting])
    assert result.exit_code == 2
    assert told in result.stderr.strip().splitlines()[-1]


def test_flown_runs_are_few_unless_asked():
    table = registry.find("khan-table2")
    assert table.usual_runs("ideal") == 1000
    assert table.usual_runs("mavlink") == 2
