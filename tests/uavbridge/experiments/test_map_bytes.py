"""What sharing maps costs in the built-in mission, flown by point masses."""

import math

import pytest

from uavbridge import config
from uavbridge.experiments.comparison.points import Search, run
from uavbridge.runner import assemble


def flown(**radio):
    """Map bytes and frames of the whole team, and the search."""
    changes = {f"radio.{key}": value for key, value in radio.items()}
    mission = config.load(None, {"duration": 150.0, "clock": "stepped", **changes})
    search = Search(mission, assemble.planner_of(mission))
    run([search], flown=False)
    accounts = search._ether.traffic.values()
    return sum(a.map_bytes_sent for a in accounts), sum(a.frames_sent for a in accounts), search


def test_changes_cost_a_twentieth_of_whole_maps():
    told, frames, search = flown()
    whole, as_many, other = flown(keyframe_s=1.0, frame_bytes=math.inf)
    assert frames == as_many
    assert 20 * told < whole
    seen, seen_too = search.union.seen, other.union.seen
    assert seen.mean() == pytest.approx(seen_too.mean(), abs=0.1)
    assert max(len(agent.mapping.declared) for agent in search.agents) >= 2
