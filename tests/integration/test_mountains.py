"""Missions on terrain: rovers, and multirotors that follow it; stepped, paced, verified."""

import json

import numpy as np
import pytest

import uavbridge
from planners.terrain import mountains
from tests.integration.missions import document, launch, write
from uavbridge.config import load
from uavbridge.config.load import packaged
from uavbridge.errors import ConfigError
from uavbridge.recording.reader import Recording
from uavbridge.recording.topics import SignalRecord, decode
from uavbridge.replay.verify import verify
from uavbridge.report.recorded import recorded_result

pytestmark = pytest.mark.integration

HILLS = """
name = "hills"
seed = 2
planner = "mountain"
vehicles = 4
duration = 150

[area]
cell_m = 50
columns = 6
rows = 6

[terrain]
seed = 3
steepest_deg = 35
hills = 6

[signals]
range_m = 100
arrival_m = 15

[radio]
range_m = 300

[fleet]
kind = "{kind}"
altitude_m = 25
spacing_m = {spacing_m}

[safety]
separation_m = {separation_m}
altitude_min_m = 10
altitude_max_m = 60
speed_m_s = 8
climb_m_s = 5
sink_m_s = 4

[[targets]]
position = [110, 120]
"""
ROVERS = HILLS.format(kind="rover", spacing_m=12, separation_m=3)
MULTIROTORS = HILLS.format(kind="multirotor", spacing_m=25, separation_m=8)


@pytest.fixture(scope="module", params=[ROVERS, MULTIROTORS], ids=["rovers", "multirotors"])
def flown(request, tmp_path_factory):
    """The folder and the result of a stepped mission."""
    folder = tmp_path_factory.mktemp("hills")
    path = write(folder, request.param)
    return folder / "out", uavbridge.run(path, out=folder / "out"), load(path)


def test_the_target_is_found_and_all_come_home(flown):
    _, result, mission = flown
    assert result.reached_goal, result.failures
    assert result.failures == ()
    assert {agent.state for agent in result.agents} == {"landed"}
    assert result.min_separation_m > 0.5 * mission.safety.separation_m
    starts = {member.id: member.start for member in mission.team()}
    for agent, track in result.tracks.items():
        assert np.hypot(*(track[-1, :2] - starts[agent])) < 5.0


def test_they_stay_on_the_ground_or_above_it(flown):
    _, result, mission = flown
    terrain = mission.terrain()
    assert terrain is not None
    for track in result.tracks.values():
        height = track[:, 2] - terrain.height_at(track)
        if mission.fleet.kind == "rover":
            assert abs(height).max() < 0.5
        else:
            assert height.min() > -0.5
            far = np.hypot(*(track[:, :2] - track[0, :2]).T) > 30.0
            assert not far.any() or height[far].min() > 0.7 * mission.safety.altitude_min_m


def test_decisions_are_taken_again_with_signals_and_ground(flown):
    folder, _, _ = flown
    messages = (m for m in Recording(folder).messages() if m.topic.startswith("signal/"))
    heard = [decode(SignalRecord, m.data) for m in messages]
    assert any(one.arrived for one in heard)
    again = verify(folder)
    assert again.ok, again.difference
    assert again.decisions > 50


def test_the_report_shows_the_ground_and_the_suballiances(flown):
    folder, result, _ = flown
    page = (folder / "report.html").read_text()
    for words in ("targets found by their signals", "Suballiances", "1 / 1", "<th>target</th>"):
        assert words in page
    again = recorded_result(folder)
    assert [t.found_at_s for t in again.targets] == [t.found_at_s for t in result.targets]
    assert again.alliances is not None
    np.testing.assert_array_equal(again.alliances.members, result.alliances.members)
    assert again.alliances.members.max() <= 6
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["coverage"] is None


def test_the_same_seed_gives_the_same_bytes(flown, tmp_path):
    _, result, mission = flown
    if mission.fleet.kind == "rover":
        again = uavbridge.run(mission, out=tmp_path / "again")
        assert again.digest == result.digest


def test_rovers_in_real_time(tmp_path):
    # its signals reach where they start: 60 s at most in lockstep, whatever the seed
    mission = write(tmp_path, ROVERS.replace("[110, 120]", "[60, 70]"))
    done = launch(mission, "--speed", 8, "--json", "--out", tmp_path / "out")
    summary = document(done)
    assert summary["failures"] == []
    assert {agent["state"] for agent in summary["agents"]} == {"landed"}
    assert summary["targets"][0]["found_at_s"] is not None
    assert done.returncode == 0


@pytest.mark.parametrize("name", sorted(packaged()))
def test_missions_of_the_package_load_by_name(name):
    mission = load(name)
    assert mission.name == name
    assert mission.targets or mission.only_flies


def test_the_ground_goes_with_its_recording(tmp_path):
    (tmp_path / "home").mkdir()
    heights = mountains(np.random.default_rng(3), (0, 0, 300, 300), 0.5, hills=6).heights
    np.save(tmp_path / "home" / "hills.npy", heights)
    text = ROVERS.replace(
        "seed = 3\nsteepest_deg = 35\nhills = 6", 'file = "hills.npy"\ncell_m = 5'
    )
    mission = write(tmp_path / "home", text)
    result = uavbridge.run(mission, out=tmp_path / "out", overrides={"duration": 15.0})
    assert result.terrain is not None
    (tmp_path / "home" / "hills.npy").unlink()
    (tmp_path / "out").rename(tmp_path / "elsewhere")
    again = verify(tmp_path / "elsewhere")
    assert again.ok, again.difference
    assert again.decisions > 30
    load(tmp_path / "elsewhere" / "mission.toml")
    (tmp_path / "elsewhere" / "terrain.npy").unlink()
    with pytest.raises(ConfigError, match=r"its ground can not be read: terrain.npy: No such file"):
        verify(tmp_path / "elsewhere")
