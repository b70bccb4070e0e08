import csv
from dataclasses import replace

import numpy as np
import pytest

from planners.flocking.starling import goals
from planners.paths.ground import path_gap
from uavbridge.errors import ConfigError
from uavbridge.experiments import registry, runner, spread
from uavbridge.experiments.chen import flight, flock, measures, terrains
from uavbridge.experiments.chen.flock import FlockParams

SHORT = FlockParams(seconds=15.0)


def fly(case, params, seed=1):
    return flock.flown(case, params, np.random.default_rng(seed))


def test_starts_are_in_the_box_apart_and_as_fast_as_printed():
    for count in (8, 20):
        position, velocity = flight.start(count, np.random.default_rng(count))
        low, high = np.array(terrains.START_BOX)
        assert ((position >= low) & (position <= high)).all()
        assert goals.separation(position) >= 20.0
        assert ((velocity[:, 0] >= 40.0) & (velocity[:, 0] <= 100.0)).all()
        assert (velocity[:, 1:] == 0.0).all()


@pytest.mark.parametrize("name", terrains.NAMES)
def test_the_way_to_the_aim_is_barred_and_the_ends_are_free(name):
    ground = terrains.terrain(name)
    ends = np.array([[50.0, 50.0, 100.0], terrains.AIM])
    assert path_gap(ground, ends) < 0.0
    assert (ends[:, 2] - ground.height_at(ends) > 60.0).all()


def test_eight_pass_the_first_hill_as_one_flock():
    params = FlockParams(seconds=42.0)
    case = {"terrain": "one", "n": 8, "variant": "full"}
    tracks = fly(case, params)
    assert tracks.position[-1, :, 0].min() > 1700.0  # the hill's top is at 1500 m
    figures = measures.numbers(tracks, terrains.terrain("one"))
    assert figures["min_separation_m"] > 15.0
    assert figures["min_separation_start_m"] > 8.0
    assert figures["min_clearance_m"] > 20.0
    assert figures["groups_end"] == 1.0
    assert figures["speed_end_m_s"] == pytest.approx(50.0, abs=2.0)
    assert figures["polarisation_end"] > 0.98
    shares = [value for name, value in figures.items() if name.startswith("share_")]
    assert sum(shares[:5]) == pytest.approx(1.0)


def test_without_spring_and_with_printed_signs_aircraft_meet():
    least = {}
    for variant in ("full", "no-spring", "printed-signs"):
        tracks = fly({"terrain": "flat", "n": 20, "variant": variant}, SHORT)
        least[variant] = measures.numbers(tracks, terrains.terrain("flat"))["min_separation_m"]
    assert least["full"] > 20.0
    assert least["no-spring"] < 16.0
    assert least["printed-signs"] < 5.0


def test_the_same_seed_flies_the_same():
    case = {"terrain": "flat", "n": 8, "variant": "full"}
    params = replace(SHORT, seconds=6.0)
    assert np.array_equal(fly(case, params).position, fly(case, params).position)
    assert not np.array_equal(fly(case, params).position, fly(case, params, 2).position)


def test_each_for_itself_flies_too():
    params = FlockParams(seconds=5.0, planner="own")
    tracks = fly({"terrain": "flat", "n": 2, "variant": "full"}, params)
    assert np.isfinite(tracks.position).all()
    assert tracks.position[-1, :, 0].min() > 150.0


def test_cases():
    cases = flock.cases(FlockParams())
    assert {case["terrain"] for case in cases} == set(terrains.NAMES)
    assert {case["variant"] for case in cases} == set(flock.VARIANTS)
    assert {case["n"] for case in cases} == {8, 12, 16, 20}
    assert all(set(case) == {"terrain", "n", "variant"} for case in cases)
    one = flock.cases(FlockParams(terrain="two", n=9, variant="no-planner"))
    assert one == [{"terrain": "two", "n": 9, "variant": "no-planner"}]


def outcome(tmp_path, **values):
    values = {"terrain": "flat", "variant": "full", "seconds": 10.0, **values}
    experiment = registry.find("chen-flock")
    return runner.run(experiment, spread.choose(1), runs=1, seed=3, values=values)


def test_tracks_are_written_a_file_a_case(tmp_path):
    file = tmp_path / "tracks.csv"
    told = outcome(tmp_path, tracks=str(file))
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "tracks-flat-12-full.csv",
        "tracks-flat-16-full.csv",
        "tracks-flat-20-full.csv",
        "tracks.csv",
    ]
    with file.open() as lines:
        rows = list(csv.DictReader(lines))
    assert list(rows[0]) == ["t", "id", "x", "y", "z", "vx", "vy", "vz"]
    assert len(rows) == 100 * 8
    assert {row["id"] for row in rows} == {str(number) for number in range(1, 9)}
    late = np.array([[float(row[key]) for key in "xyz"] for row in rows]).reshape(100, 8, 3)
    after = late[np.array([float(row["t"]) for row in rows[::8]]) > 5.0]
    told_by = {row.metric: row.mean for row in told.rows if row.case["n"] == 8}
    assert goals.separation(after).min() == pytest.approx(told_by["min_separation_m"], abs=0.01)


def test_a_file_that_cannot_be_written(tmp_path):
    with pytest.raises(ConfigError, match="tracks"):
        outcome(tmp_path, n=2, tracks=str(tmp_path / "none" / "tracks.csv"))
