from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planners.belief.merge import MERGE_RULES
from uavbridge.agent.report import AgentReport
from uavbridge.bus.wire import DELTA, Frame, encode
from uavbridge.config import load, to_toml
from uavbridge.errors import ConfigError
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import EventRecord, MissionRecord, ScoreRecord
from uavbridge.report.drawn import drawings
from uavbridge.report.page import report_page
from uavbridge.report.recorded import recorded_result
from uavbridge.report.result import AgentResult, MissionResult, TargetResult
from uavbridge.report.summary import summarise, summary_json

SECONDS = 20


def record(folder: Path, result: MissionResult | None) -> Recorder:
    """Two agents fly east and see one cell each; ``result`` ends the recording."""
    mission = load()
    rule = MERGE_RULES[mission.belief.merge]
    cells = np.zeros(1, dtype=rule.record)
    recorder = Recorder(folder, mission_name=mission.name, epoch_ns=10**18)
    recorder.record("mission", 0, MissionRecord(to_toml(mission), 7, "stepped", {"numpy": "2"}))
    for second in range(SECONDS):
        t_us = second * 1_000_000
        for agent in (1, 2):
            at = (5.0 * second, 100.0 * agent, 30.0)
            state = AgentReport(
                agent=agent, t_us=t_us, phase="search", mode="OFFBOARD", position=at,
                velocity=(5.0, 0.0, 0.0), heading=0.0, armed=True, in_air=True, battery=None,
                neighbours=1, note="", distance_m=0.0, declared=[],
            )  # fmt: skip
            recorder.record(f"state/{agent}", t_us, state)
            cells["cell"], cells["probability"], cells["stamp_us"] = agent, 0.9, t_us
            frame = Frame(
                DELTA, agent, second, t_us, np.array(at), np.zeros(3), b"", rule.code,
                cells.tobytes(),
            )  # fmt: skip
            recorder.write(f"air/{agent}", t_us, encode(frame))
        recorder.record("score", t_us, ScoreRecord(second / 20, 90.0 - second, 40.0, 1, 100.0))
    recorder.record("event", t_us, EventRecord("said", "battery low", 2))
    if result is not None:
        recorder.write("summary", t_us, summary_json(result))
    return recorder


@pytest.fixture
def ended(flown: MissionResult) -> MissionResult:
    (first, *others) = load().target_cells()
    return replace(
        flown,
        targets=(TargetResult(first, 12.0, 2), *map(TargetResult, others)),
        agents=tuple(AgentResult(agent, "landed", 95.0, 20, 19, 900, 800) for agent in (1, 2)),
    )


def test_a_whole_recording_gives_the_result_again(tmp_path: Path, ended: MissionResult) -> None:
    recorder = record(tmp_path, ended)
    recorder.close()
    result = recorded_result(tmp_path)
    summary = summarise(result)
    assert summary.targets == summarise(ended).targets
    assert summary.agents == summarise(ended).agents
    assert summary.digest == recorder.digest()
    assert (summary.seed, summary.clock, summary.duration_s) == (7, "stepped", SECONDS - 1)
    assert summary.coverage == pytest.approx(0.95)
    assert summary.min_separation_m == 100.0
    assert not result.reached_goal
    assert result.events[0].agent == 2
    assert result.tracks[2][-1].tolist() == [95.0, 200.0, 30.0]
    assert result.seen is not None
    assert np.argwhere(result.seen).tolist() == [[0, 1], [0, 2]]
    assert "battery low" in report_page(result, drawings(result))


def test_a_killed_mission_gives_what_there_is(tmp_path: Path) -> None:
    recorder = record(tmp_path, None)
    result = recorded_result(tmp_path)
    recorder.close()
    assert result.failures == ("the recording ends before the mission does",)
    assert [target.found_at_s for target in result.targets] == [None] * len(result.targets)
    assert [(agent.id, agent.state) for agent in result.agents] == [(1, "search"), (2, "search")]
    assert all(agent.frames_sent >= SECONDS - 2 for agent in result.agents)
    assert result.agents[0].distance_m == pytest.approx(5.0 * (len(result.tracks[1]) - 1))


def test_other_recordings_are_refused_in_one_line(tmp_path: Path) -> None:
    with Recorder(tmp_path, mission_name="x", epoch_ns=0) as recorder:
        recorder.write("air/1", 0, b"")
    with pytest.raises(ConfigError, match="does not begin with its mission"):
        recorded_result(tmp_path)
    with Recorder(tmp_path, mission_name="x", epoch_ns=0) as recorder:
        recorder.write("mission", 0, b"{}")
    with pytest.raises(ConfigError, match="a message does not read"):
        recorded_result(tmp_path)
