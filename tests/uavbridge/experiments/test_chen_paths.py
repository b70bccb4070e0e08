import math

import numpy as np
import pytest

from uavbridge.experiments import registry, runner, spread
from uavbridge.experiments.chen import dubins, intruder, rrt, track
from uavbridge.experiments.chen.dubins import DubinsParams
from uavbridge.experiments.chen.intruder import Intruder, IntruderParams
from uavbridge.experiments.chen.rrt import RrtParams
from uavbridge.experiments.chen.track import TrackParams


def means(name, runs=1, **values):
    outcome = runner.run(registry.find(name), spread.choose(1), runs=runs, values=values)
    return {(tuple(row.case.values()), row.metric): row for row in outcome.rows}


def test_the_papers_climbs():
    rows = means("chen-dubins")
    for height, case, length, turns in (
        (75, 0, math.hypot(185.0, 75.0), 0),
        (175, 1, 350.0, 0),
        (400, 2, 800.0, 2),
        (-400, 2, 800.0, 2),
    ):
        assert rows[(height,), "case"].mean == case
        assert rows[(height,), "length_m"].mean == pytest.approx(length)
        assert rows[(height,), "turns"].mean == turns
        assert rows[(height,), "height_error_m"].mean < 1e-6
    assert rows[(400,), "length_printed_form_m"].mean == pytest.approx(213.6, abs=0.1)
    assert rows[(400,), "car_m"].paper == 185.0


def test_an_end_that_no_car_path_of_that_length_reaches():
    params = DubinsParams(bearing_deg=0.0, heading_deg=180.0)
    with pytest.raises(ValueError, match="car's path"):
        dubins.path_of({"height_m": 75}, params)


def test_ways_are_shorter_when_nodes_are_skipped():
    params = RrtParams(goal_bias=0.2)
    length = {}
    for how in rrt.SMOOTHINGS:
        case = {"terrain": "one", "smoothing": how}
        figures = rrt.simulate(case, params, np.array([5]), "ideal")
        assert figures["found"][0] == 1.0
        assert figures["min_clearance_m"][0] >= params.clearance_m - 1e-6
        length[how] = figures["length_m"][0]
    assert length["farthest"] <= length["printed"] + 1e-9
    assert length["printed"] < length["none"]


def test_where_no_way_is_found_nothing_is_told():
    figures = rrt.simulate(
        {"terrain": "narrow", "smoothing": "farthest"},
        RrtParams(samples=3),
        np.array([1, 2]),
        "ideal",
    )
    assert (figures["found"] == 0.0).all()
    assert np.isnan(figures["length_m"]).all()


def test_intruders_come_and_go():
    params = IntruderParams(appears_s=5.0, stays_s=10.0)
    flock = np.zeros((4, 3))
    for kind in intruder.KINDS:
        foe = Intruder(kind, params)
        assert len(foe(4.0, np.zeros((0, 3)), flock)) == 0
        first = foe(5.0, np.zeros((0, 3)), flock)
        later = foe(5.1, first, flock)
        assert np.linalg.norm(first) > 800.0
        assert np.linalg.norm(later - first) == pytest.approx(params.speed_m_s * 0.1)
        assert len(foe(15.0, first, flock)) == 0


def test_a_flock_escapes_and_comes_together_again():
    params = IntruderParams(appears_s=5.0, stays_s=12.0, seconds=28.0)
    case = {"intruder": "crossing", "n": 8, "escape": "working"}
    figures = intruder.simulate(case, params, np.array([3]), "ideal")
    assert figures["share_escape"][0] > 0.0
    assert figures["min_intruder_m"][0] < 260.0
    assert figures["min_separation_m"][0] > 10.0
    assert figures["groups_end"][0] == 1.0
    assert 0.0 <= figures["all_know_s"][0] < 1.0


@pytest.mark.parametrize("model", ["six-dof", "guidance"])
def test_aircraft_come_to_their_tracks_and_stay(model):
    params = TrackParams(terrain="flat", n=4, seconds=30.0)
    figures = track.simulate({"model": model}, params, np.array([3]), "ideal")
    for axis in ("north", "east", "alt"):
        assert 2.0 < figures[f"rms_{axis}_start_m"][0] < 60.0
        assert figures[f"rms_{axis}_m"][0] < 2.5
    assert figures["airspeed_least_m_s"][0] > 20.0


def test_flown_tracks_are_written(tmp_path):
    file = tmp_path / "tracks.csv"
    values = {"tracks": str(file), "terrain": "flat", "n": 2, "seconds": 21.0}
    means("chen-track", **values)
    rows = file.read_text().splitlines()
    assert rows[0] == "t,id,x,y,z,vx,vy,vz"
    assert len(rows) == 1 + 2 * 210
    assert (tmp_path / "tracks-guidance.csv").exists()
