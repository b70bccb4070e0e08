"""Khan's tables and figures: exact where the paper is, in order where it is statistics."""

from dataclasses import replace

import numpy as np
import pytest

from uavbridge.errors import ConfigError
from uavbridge.experiments import registry, runner, spread
from uavbridge.experiments.khan import study
from uavbridge.experiments.khan.choices import KhanParams
from uavbridge.experiments.khan.teams import team_of
from uavbridge.experiments.khan.world import (
    Luck,
    Walk,
    entries,
    first_above,
    loop_of,
    reach_of,
    search,
    within,
)


def run(name, runs=40, **values):
    return runner.run(registry.find(name), spread.Here(), runs=runs, values=values)


def table(outcome, metric, *keys, reading=None):
    return {
        tuple(row.case[key] for key in keys): row.mean
        for row in outcome.rows
        if row.metric == metric and row.reading == reading
    }


def test_table_1_is_exact():
    rows = [
        row for row in run("khan-table1", runs=1).rows if row.paper is not None and not row.reading
    ]
    assert len(rows) == 6
    for row in rows:
        assert row.mean == pytest.approx(row.paper, abs=1e-6)


def test_only_ogmm_stays_stuck():
    outcome = run("khan-table1", runs=1)
    assert table(outcome, "probability", "time", "uav")[10, 2] == pytest.approx(0.9, abs=1e-6)
    for label in ("rule=BU", "rule=SDS"):
        stuck = table(outcome, "probability", "time", "uav", reading=label)
        assert stuck[10, 1] == stuck[10, 2] < 1e-6


def test_four_observations_are_needed_at_the_papers_sensor():
    outcome = run("khan-fig4", runs=1)
    needed = table(outcome, "observations", "p", "q")
    assert needed[0.9, 0.2] == 4
    assert needed == table(outcome, "observations_counted", "p", "q")
    jumps = [q for (p, q), m in needed.items() if p == 0.9 and m > needed.get((p, q - 0.02), m)]
    assert not jumps or min(jumps) > 0.09  # q = p / 99^(1/m)


def test_table_2_has_the_papers_order():
    params, seeds = study.StudyParams(), np.arange(60)

    def of(n, range_cells, rule):
        case = {"N": n, "range": range_cells, "rule": rule}
        return {k: v.mean() for k, v in study.simulate(case, params, seeds, "ideal").items()}

    five = {rule: of(5, 14, rule) for rule in ("UNC", "BU", "AVG", "MOGM", "SDS")}
    steps = {rule: one["steps"] for rule, one in five.items()}
    assert steps["SDS"] < steps["BU"] * 1.05
    assert steps["BU"] < steps["MOGM"] < steps["AVG"] < steps["UNC"]
    assert five["AVG"]["error_percent"] < five["SDS"]["error_percent"]
    assert of(5, 2, "SDS")["steps"] < of(5, 2, "BU")["steps"] - 20 < steps["UNC"] - 20
    assert of(2, 14, "SDS")["steps"] > steps["SDS"]


def test_every_cell_of_table_2_is_printed():
    outcome = run("khan-table2", runs=1, steps_most=3)
    gains = [row for row in outcome.rows if row.metric == "gain_percent"]
    assert len(gains) == 48
    assert all(row.paper is not None for row in gains)


def test_gain_is_a_ratio_of_means_with_its_error():
    outcome = run("khan-fig7", runs=60, rules="BU", steps_most=150)
    apart = outcome.of(N=3, range=14, rule="UNC")["steps"]
    together = outcome.of(N=3, range=14, rule="BU")["steps"]
    [row] = [r for r in outcome.rows if r.metric == "gain_percent" and r.case["N"] == 3]
    assert row.mean == pytest.approx(100 * (1 - together.mean() / apart.mean()))
    rng = np.random.default_rng(1)
    picks = rng.integers(0, 60, (2000, 60))
    again = 100 * (1 - together[picks].mean(axis=1) / apart[picks].mean(axis=1))
    assert row.se == pytest.approx(again.std(), rel=0.15)


def test_one_uav_has_nobody_to_merge_with():
    outcome = run("khan-fig7", runs=5, rules="BU,OGMM,SDS", steps_most=100)
    gain = table(outcome, "gain_percent", "N", "rule")
    assert gain[1, "BU"] == gain[1, "OGMM"] == gain[1, "SDS"] == 0


def test_other_readings_have_their_own_rows():
    outcome = run("khan-table2", runs=5, rules="BU", readings="exchange=whole", steps_most=150)
    whole = table(outcome, "gain_percent", "N", "range", "rule", reading="exchange=whole")
    plain = table(outcome, "gain_percent", "N", "range", "rule")
    assert whole.keys() == plain.keys()
    assert whole != plain
    assert {row.metric for row in outcome.rows} == {"steps", "error_percent", "gain_percent"}


@pytest.mark.parametrize("label", study.READINGS)
def test_every_reading_can_be_run(label):
    params = study.StudyParams(readings=label, steps_most=60)
    assert study.read_as(params, label) != params
    case = {"N": 3, "range": 4, "rule": "MOGM", "reading": label}
    samples = study.simulate(case, params, np.arange(4), "ideal")
    assert (samples["steps"] > 0).all()


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"rules": "BU,XYZ"}, "unknown rule 'XYZ'"),
        ({"readings": "exchange=half"}, "unknown reading 'exchange=half'"),
        ({"target_column": 10}, "outside the region"),
        ({"q": 0.95}, "q must be below p"),
    ],
)
def test_wrong_parameters_are_told_in_one_line(values, told):
    with pytest.raises(ConfigError, match=told):
        run("khan-table2", runs=1, **values)


def test_start_cells_are_uniform_and_every_sweep_passes_them():
    for sweep in ("snake-and-back", "snake-and-jump", "closed-tour", "columns-and-rows"):
        for phase in ("first", "random"):
            choices = KhanParams(sweep=sweep, phase=phase)
            loop = loop_of(choices)
            assert set(loop) == set(range(100))
            draws = Luck(np.arange(300), 2, choices).start
            places = entries(loop, draws, choices)
            cells = (draws[..., 0] * 100).astype(int)
            assert np.array_equal(loop[places], cells)
            assert len(np.unique(cells)) > 95
    once = Luck(np.arange(5), 3, KhanParams(starts="once")).start
    assert (once == once[0]).all()
    other = Luck(np.arange(5), 3, KhanParams(starts="once", starts_seed=1)).start
    assert not (other == once).any()


def test_range_is_between_cells_and_silence_is_a_switch_of_its_own():
    choices = KhanParams()
    cells = np.array([[0, 0, 2, 33]])  # (0, 0) twice, (0, 2), (3, 3)
    near = reach_of(cells, within(0, choices), False)[0]
    assert near[0, 1]
    assert near.sum() == 2
    assert reach_of(cells, within(2, choices), False)[0].sum() == 6
    chain = reach_of(cells, within(3.2, choices), True)[0]
    assert chain[0, 3]
    assert not reach_of(cells, within(3.2, choices), False)[0][0, 3]
    assert not within(14, replace(choices, talk=False)).any()


def test_the_first_uav_and_its_first_cell_are_named():
    maps = np.full((2, 2, 4), 0.5)
    maps[0, 1, 0] = maps[0, 0, 3] = maps[0, 0, 2] = 0.99
    over, cell = first_above(maps, 0.99)
    assert over.tolist() == [True, False]
    assert cell[0] == 2


def test_a_target_steps_to_a_cell_beside_it_or_stays():
    choices = KhanParams(columns=3, rows=3, target_column=0, target_row=0)
    walk = Walk(choices, 4000, 0.4)
    walk.step(np.random.default_rng(1).random(4000))
    counts = np.bincount(walk.cell, minlength=9) / 4000
    assert counts[[1, 3]] == pytest.approx([0.1, 0.1], abs=0.02)
    assert counts[0] == pytest.approx(0.8, abs=0.02)  # two ways lead out of the region


def test_forgetting_undoes_old_evidence_the_same_under_all_rules():
    choices = KhanParams(forget=0.1, steps_most=150)
    seeds = np.arange(3)
    lonely = [
        search(team_of(rule, choices, 3, 1), choices, 1, 0.0, seeds).steps
        for rule in ("UNC", "BU", "SDS")
    ]
    assert np.array_equal(lonely[0], lonely[1])
    assert np.array_equal(lonely[0], lonely[2])


def test_a_moving_target_is_named_wrongly_more_often():
    outcome = run("khan-moving", runs=30, rules="SDS", faded=0.0, steps_most=120)
    errors = table(outcome, "error_percent", "speed", "rule")
    assert errors[0.0, "SDS"] < errors[0.1, "SDS"]
