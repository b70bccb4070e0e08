"""The runner: the same numbers whoever works, rows as documented, one line for bad input."""

import csv
import json

import numpy as np
import pytest
from click.testing import CliRunner

from planners.registry import described
from uavbridge.cli import main
from uavbridge.errors import UavbridgeError
from uavbridge.experiments import output, printed, registry, rows, runner, spread
from uavbridge.experiments.experiment import Axis

SMALL = ("--runs", "3", "--set", "methods=mower,random", "--set", "cycles=12")
ROW = {"case", "metric", "paper", "mean", "se", "median", "q25", "q75", "n"}


def run(*arguments):
    return CliRunner().invoke(main, ["experiment", *arguments], prog_name="uavbridge")


def table(workers_or_spread, **changes):
    experiment = registry.find("liu-table2")
    values = {"methods": "mower,esustpm", "cycles": 10, **changes.pop("values", {})}
    return runner.run(experiment, workers_or_spread, runs=5, values=values, **changes)


def backwards(work, tasks):
    done = list(spread.Here()(work, tasks))
    yield from reversed(done)


def test_the_order_of_the_work_changes_nothing():
    assert output.as_json(table(spread.Here()).rows) == output.as_json(table(backwards).rows)


def test_seeds_follow_from_seed_case_and_run_alone():
    experiment = registry.find("liu-table2")
    case = {"method": "esustpm", "targets": True}
    five = runner.seeds_of(experiment, case, 1, 5)
    assert len(set(five.tolist())) == 5
    assert (five >= 0).all()
    np.testing.assert_array_equal(runner.seeds_of(experiment, case, 1, 3), five[:3])
    turned = dict(reversed(case.items()))
    np.testing.assert_array_equal(runner.seeds_of(experiment, turned, 1, 5), five)
    read = {**case, "reading": "speed_reading=norm"}
    np.testing.assert_array_equal(runner.seeds_of(experiment, read, 1, 5), five)
    assert not set(five) & set(runner.seeds_of(experiment, case, 2, 5).tolist())
    other = runner.seeds_of(experiment, {**case, "targets": False}, 1, 5)
    assert not set(five) & set(other.tolist())
    paired = registry.find("liu-prior")
    np.testing.assert_array_equal(
        runner.seeds_of(paired, {"prior": "none"}, 1, 4),
        runner.seeds_of(paired, {"prior": "accurate"}, 1, 4),
    )


def test_other_seed_other_numbers():
    one, other = (
        table(spread.Here(), seed=seed).of(method="esustpm", targets=True) for seed in (1, 2)
    )
    assert (one["uncertainty"] != other["uncertainty"]).any()


def test_progress_ends_with_all_runs():
    told = []
    table(spread.Here(), progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (40, 40)  # 2 methods and 2 readings of one, with and without targets
    assert told == sorted(told)


def test_rows_have_the_documented_keys_and_types():
    found = [row.as_data() for row in table(spread.Here()).rows]
    assert all(set(row) - {"reading"} == ROW for row in found)
    plain = [row for row in found if "reading" not in row]
    assert all(set(row["case"]) == {"method", "targets"} for row in found)
    assert all(type(row["n"]) is int for row in found)
    mower = next(
        row
        for row in plain
        if row["case"] == {"method": "mower", "targets": False} and row["metric"] == "uncertainty"
    )
    assert mower["paper"] == 52.34
    assert mower["se"] == 0.0
    never = [row for row in plain if row["metric"] == "coverage_cycle"]
    assert all(row["n"] == 0 and row["mean"] is None for row in never)
    assert {row["reading"] for row in found if "reading" in row} == {
        "speed_reading=norm",
        "speed_reading=none",
    }


def test_figures_of_a_row():
    nothing = printed.Printed()
    row = rows.of_values({"range": 2}, "steps", np.array([1.0, 2.0, np.nan, 6.0]), nothing)
    assert (row.mean, row.median, row.q25, row.q75, row.n) == (3.0, 2.0, 1.5, 4.0, 3)
    assert row.se == pytest.approx(np.std([1, 2, 6], ddof=1) / np.sqrt(3))
    assert row.as_data()["case"] == {"range": 2}
    assert rows.of_values({}, "steps", np.array([4.0]), nothing).se is None


def test_curves_become_rows_with_their_axis():
    samples = {"cells@cycle": np.array([[1.0, 3.0], [1.0, 5.0]])}
    found = list(rows.of_samples({"a": 1}, samples, printed.Printed(), Axis("cycle", (0, 5))))
    assert [(row.case, row.metric, row.mean) for row in found] == [
        ({"a": 1, "cycle": 0}, "cells", 1.0),
        ({"a": 1, "cycle": 5}, "cells", 4.0),
    ]
    with pytest.raises(ValueError, match="no axis of its length"):
        list(rows.of_samples({}, samples, printed.Printed(), None))


def test_printed_numbers_belong_to_cases_that_are_run():
    for experiment in registry.everyone():
        known = [
            {key: value for key, value in case.items() if key != "reading"}
            for case in experiment.cases(experiment.params())
        ]
        for case, _ in printed.load(experiment.printed).numbers:
            if experiment.axis is not None:
                case = {key: value for key, value in case.items() if key != experiment.axis.name}
            assert case in known, (experiment.name, case)


@pytest.mark.parametrize("name", registry.MODULES)
def test_every_experiment_is_described(name):
    experiment = registry.find(name)
    assert experiment.name == name
    assert experiment.summary
    assert experiment.source
    for parameter in described(experiment.params):
        assert parameter.doc, parameter.name
        assert parameter.unit, parameter.name


def test_listing():
    told = run()
    assert told.exit_code == 0
    for name in registry.MODULES:
        assert name in told.stdout
    listed = json.loads(run("--json").stdout)
    assert [one["name"] for one in listed] == list(registry.MODULES)


def test_files(tmp_path):
    told = run("liu-table2", *SMALL, "--workers", "1", "--out", str(tmp_path / "new"))
    assert told.exit_code == 0, told.output
    assert "52.34" in told.stdout
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names == {f"liu-table2.{kind}" for kind in ("json", "csv", "png", "md")}
    found = json.loads((tmp_path / "new" / "liu-table2.json").read_text())
    table = list(csv.DictReader((tmp_path / "new" / "liu-table2.csv").read_text().splitlines()))
    assert len(table) == len(found)
    assert [row["metric"] for row in table] == [row["metric"] for row in found]
    page = (tmp_path / "new" / "liu-table2.md").read_text()
    changed = "--set methods=mower,random --set cycles=12"
    assert f"uavbridge experiment liu-table2 {changed} --runs 3 --seed 1" in page
    assert "(liu-table2.png)" in page


def test_json_on_standard_output():
    told = run("liu-table2", *SMALL, "--workers", "1", "--json")
    assert told.exit_code == 0
    assert {row["metric"] for row in json.loads(told.stdout)} >= {"uncertainty", "entropy"}


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("liu-table3",), "unknown experiment 'liu-table3'"),
        (("liu-table2", "--set", "cylces=3"), "unknown parameter 'cylces'"),
        (("liu-table2", "--set", "cycles=0"), "parameter cycles must be 1 to 100000, not 0"),
        (("liu-table2", "--set", "cycles=many"), "parameter cycles must be a whole number"),
        (("liu-table2", "--set", "cycles"), "--set cycles: must be KEY=VALUE"),
        (("liu-table2", "--set", "methods=mower,lawn"), "unknown method 'lawn'"),
        (("liu-table2", "--set", "p_d=0.05"), "needs p >= q"),
        (("liu-table2", "--fidelity", "real"), "no fidelity 'real'"),
        (("liu-table2", "--runs", "0"), "--runs must be at least 1"),
        (("liu-table2", "--workers", "0"), "--workers must be at least 1"),
        (("liu-table2", "--dask", "nowhere://x"), "--dask nowhere://x"),
    ],
    ids=lambda value: value[-1] if isinstance(value, tuple) else "",
)
def test_bad_input_is_one_line(arguments, told):
    result = run(*arguments)
    assert result.exit_code == 2
    error = result.stderr.strip().splitlines()[-1]
    assert error.startswith("error: ")
    assert told in error
    assert result.stdout == ""


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    told = run("liu-table2", *SMALL, "--workers", "1", "--out", str(tmp_path / "file"))
    assert told.exit_code == 2
    assert "--out" in told.stderr


def test_a_scheduler_that_is_not_there():
    silent = spread.Dask("tcp://127.0.0.1:9", timeout_s=0.5)
    with pytest.raises(UavbridgeError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        table(silent)
