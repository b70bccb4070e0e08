"""Fixed-wing aircraft in missions: flocks from air to air, and one from the runway."""

from dataclasses import dataclass

import numpy as np
import pytest

import uavbridge
from planners.flocking.starling import goals
from planners.types import F64
from tests.integration.missions import document, launch, write
from uavbridge.bus.messages import decode_truth
from uavbridge.config import load
from uavbridge.recording.reader import Recording
from uavbridge.replay.verify import verify

pytestmark = pytest.mark.integration

LINK_M = 120.0  # aircraft nearer than that are one group


@dataclass
class Flown:
    """What really happened."""

    t_s: F64
    position: F64  # (k, n, 3)

    @staticmethod
    def read(folder):
        truths = [
            truth
            for message in Recording(folder).messages()
            if message.topic == "truth" and (truth := decode_truth(message.data)) is not None
        ]
        return Flown(
            np.array([truth.t_us * 1e-6 for truth in truths]),
            np.array([truth.position for truth in truths]),
        )

    def check(self, mission):
        """No collision, no ground, one flock, airspeeds that the aircraft has."""
        ground = mission.terrain()
        assert ground is not None
        assert goals.separation(self.position).min() > mission.safety.separation_m
        above = self.position[..., 2] - ground.height_at(self.position)
        assert above.min() > mission.safety.altitude_min_m
        assert goals.groups(self.position[-1:], LINK_M)[0] == 1
        velocity = np.gradient(self.position, self.t_s, axis=0)[1:-1]
        speed = np.linalg.norm(velocity, axis=-1)
        assert speed.min() > mission.safety.slowest_m_s
        assert speed.max() < 1.1 * mission.safety.speed_m_s
        assert goals.polarisation(velocity[-1]) > 0.99


def test_a_flock_of_twelve_sets_out_in_lockstep(tmp_path):
    mission = load("chen2023-twelve", {"clock": "stepped", "duration": 24.0})
    result = uavbridge.run(mission, out=tmp_path / "out")
    assert result.failures == ()
    assert result.reached_goal
    assert {agent.state for agent in result.agents} == {"aloft"}
    Flown.read(tmp_path / "out").check(mission)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Tracks in space" in page
    assert "Yaw from east" in page
    again = verify(tmp_path / "out")
    assert again.ok, again.difference


RUNWAY = """
name = "runway"
planner = "sweep"
duration = 45.0

[area]
cell_m = 200.0
columns = 6
rows = 6
west_m = -600.0
south_m = -600.0

[fleet]
kind = "plane"
starts = [[0.0, 0.0]]
altitude_m = 80.0

[safety]
fence_margin_m = 300.0
altitude_min_m = 40.0
speed_m_s = 45.0
climb_m_s = 6.0
sink_m_s = 5.0
"""


def test_one_takes_off_searches_comes_home_and_lands(tmp_path):
    path = write(tmp_path, RUNWAY)
    result = uavbridge.run(path, out=tmp_path / "out")
    assert result.failures == ()
    assert [agent.state for agent in result.agents] == ["landed"]
    track = result.tracks[1]
    assert track[:, 2].max() == pytest.approx(80.0, abs=25.0)
    assert track[-1, 2] < 1.0
    assert np.abs(track[:, :2]).max() < 950.0


@pytest.mark.soak
@pytest.mark.parametrize("name", ["chen2023-twelve", "chen2023-twenty"])
def test_flocks_cross_the_hills_in_lockstep(name, tmp_path):
    mission = load(name, {"clock": "stepped"})
    result = uavbridge.run(mission, out=tmp_path / "out")
    assert result.failures == ()
    flown = Flown.read(tmp_path / "out")
    flown.check(mission)
    assert flown.position[-1, :, 0].min() > 5500.0


@pytest.mark.soak
@pytest.mark.parametrize("name", ["chen2023-twelve", "chen2023-twenty"])
def test_flocks_cross_the_hills_in_real_time(name, tmp_path):
    done = launch(name, "--json", "--out", tmp_path / "out", timeout=600)
    summary = document(done)
    assert done.returncode == 0, summary["failures"]
    Flown.read(tmp_path / "out").check(load(name))
