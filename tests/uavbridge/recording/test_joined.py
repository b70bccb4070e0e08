"""A recorder that joins half way knows what was before, and goes on where another ended."""

from __future__ import annotations

import pytest

from planners.registry import BUILTIN
from uavbridge.config import load
from uavbridge.recording.reader import Recording
from uavbridge.recording.recorder import BUS, Recorder
from uavbridge.replay.record import Joined, Onlooker
from uavbridge.report.recorded import recorded_result
from uavbridge.runner import stepped
from uavbridge.runner.assemble import planner_of

JOIN_US, GAP_US, AGAIN_US = 25_000_000, 32_000_000, 34_000_000


def test_a_mission_joined_half_way_is_told_whole(tmp_path):
    mission = load(None, {"vehicles": 3, "duration": 40.0, "clock": "stepped"})
    at_work: list[tuple[Recorder, Joined, Onlooker]] = []
    killed: list[Recorder] = []

    def join(bus, part):
        recorder = Recorder(tmp_path, mission_name="m", epoch_ns=0, source=BUS, part=part)
        joined, onlooker = Joined(bus), Onlooker(recorder)
        for sample in joined.before:
            onlooker.take(sample)
        at_work.append((recorder, joined, onlooker))

    def progress(t_us, judge, host):
        bus = judge._bus._hub.bus()
        if t_us == JOIN_US:
            join(bus, 1)
        elif t_us == GAP_US:
            killed.append(at_work.pop()[0])  # neither closed nor flushed
        elif t_us == AGAIN_US:
            join(bus, 2)
        for _, joined, onlooker in at_work:
            for sample in joined.drain():
                onlooker.take(sample)

    with Recorder(None, mission_name="m", epoch_ns=0) as nothing:
        flown = stepped.fly_stepped(
            mission,
            planner_of(mission, BUILTIN["esustpm"]),
            recorder=nothing,
            progress=progress,
            stop=lambda: False,
        )
    at_work[0][0].close()
    recording, judge = Recording(tmp_path), flown.judge
    assert list(recording.parts) == [1, 2]
    assert not recording.complete  # the first part has no end
    result = recorded_result(tmp_path)
    assert result.series.t_s[0] == 0.0  # the judge told what was before
    assert {event.text for event in result.events} >= {"takeoff", "search", "landed"}
    assert result.coverage == pytest.approx(judge.seen_share)
    assert result.seen.mean() == pytest.approx(judge.seen_share)
    assert result.entropy == pytest.approx(judge.latest().entropy, rel=0.01)
    assert {a.id: a.frames_sent for a in result.agents} == {
        agent: report.frames_sent for agent, report in judge.reports.items()
    }
    assert result.notes[-1].startswith("it begins 0:2")
    killed[0].close()
