"""What sharing maps costs in the built-in mission, all bytes of all frames counted."""

import numpy as np
import pytest
from msgspec.structs import replace

from uavbridge.bus.wire import KEYFRAME, decode, encode
from uavbridge.config import load
from uavbridge.recording.recorder import Recorder
from uavbridge.runner import stepped
from uavbridge.runner.assemble import planner_of

pytestmark = pytest.mark.integration


def test_changes_cost_a_twentieth_of_whole_maps(tmp_path):
    mission = load(None, {"clock": "stepped"})
    told = whole = frames = 0
    air = None

    def count(_t_us, judge, host):
        """Each frame as it was, and with all that its sender knew, and no probes, in it."""
        nonlocal air, told, whole, frames
        if air is None:
            air = judge._bus._hub.bus().subscribe("air/**")
        knows = {seat.agent.plan.agent: seat.agent for seat in host.seats}
        for sample in air.drain():
            frame, agent = decode(sample.data), knows[int(sample.key.rpartition("/")[2])]
            belief, rule = agent.mapping.belief, agent.plan.rule
            cells = rule.records(belief, np.flatnonzero(belief.seen)).tobytes()
            told += len(sample.data)
            whole += len(encode(replace(frame, kind=KEYFRAME, cells=cells, probes=())))
            frames += 1

    with Recorder(tmp_path, mission_name="m", epoch_ns=0, mcap=False) as recorder:
        flown = stepped.fly_stepped(
            mission,
            planner_of(mission),
            recorder=recorder,
            progress=count,
            stop=lambda: False,
        )
    assert flown.judge.union.seen.mean() >= 0.9
    assert len(flown.judge.declared) >= 2
    assert frames > 3000
    assert 20 * told < whole
