"""A recorded mission: verified, changed and caught, played to a monitor, reported."""

import json
import shutil
from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner

import uavbridge
from tests.integration.missions import write
from uavbridge.bus.api import Sample
from uavbridge.bus.local import LocalHub
from uavbridge.cli import main
from uavbridge.clock import SteppedClock
from uavbridge.monitor.watch import MissionWatch
from uavbridge.recording.parts import Rotation
from uavbridge.recording.reader import Recording
from uavbridge.recording.recorder import BUS, Recorder
from uavbridge.recording.topics import DecisionRecord, MissionRecord, encode
from uavbridge.replay.play import play
from uavbridge.replay.record import Onlooker
from uavbridge.replay.verify import verify
from uavbridge.report.recorded import recorded_result

pytestmark = pytest.mark.integration


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A short mission's folder and result."""
    folder = tmp_path_factory.mktemp("flown")
    overrides = {"duration": 60.0, "planner": "esustpm"}
    result = uavbridge.run(write(folder), out=folder / "out", overrides=overrides)
    return folder / "out", result


def changed(source, folder, agent, tick, **fields):
    """The recording with one decision changed."""
    folder.mkdir()
    with Recorder(folder, mission_name="small", epoch_ns=0) as recorder:
        for message in Recording(source).messages():
            data = message.data
            if message.topic == f"decision/{agent}":
                record = msgspec.json.decode(data, type=DecisionRecord)
                if record.tick == tick:
                    data = encode(msgspec.structs.replace(record, **fields))
            recorder.write(message.topic, message.t_us, data)
    return folder


def test_the_planners_decide_the_same_again(flown):
    folder, _ = flown
    whole = verify(folder)
    assert whole.ok
    assert whole.decisions > 100
    middle = verify(folder, from_s=40.0)
    assert middle.ok
    assert 0 < middle.decisions < whole.decisions


def test_agents_that_flew_apart_are_verified_with_the_frames_that_the_launcher_has(flown, tmp_path):
    known = {"mission": tmp_path}
    for agent in ("1", "2", "3", "4"):
        known[agent] = tmp_path / "agents" / agent
        known[agent].mkdir(parents=True)
    for name, folder in known.items():
        with Recorder(folder, mission_name="small", epoch_ns=0) as recorder:
            for topic, t_us, data in Recording(flown[0]).messages():
                space, _, agent = topic.partition("/")
                # its own of an agent; the launcher has what was on the air
                own = agent == name or (name == "mission" and space == "air")
                if own or topic == "mission":
                    recorder.write(topic, t_us, data)
    result = verify(tmp_path)
    assert result.ok, result.difference
    assert result.decisions == verify(flown[0]).decisions


@pytest.mark.parametrize(
    ("fields", "word"),
    [({"values": [1.0, 2.0, 3.0]}, "values"), ({"note": "elsewhere"}, "note")],
)
def test_a_changed_decision_is_named(flown, tmp_path, fields, word):
    folder = changed(flown[0], tmp_path / "changed", 2, 7, **fields)
    result = verify(folder)
    assert not result.ok
    assert "agent 2, decision 7" in result.difference
    assert word in result.difference
    done = CliRunner().invoke(main, ["replay", str(folder), "--verify"])
    assert done.exit_code == 1
    assert "agent 2, decision 7" in done.output


def test_a_changed_frame_shows_in_the_decisions_that_follow(flown, tmp_path):
    folder = tmp_path / "deaf"
    folder.mkdir()
    with Recorder(folder, mission_name="small", epoch_ns=0) as recorder:
        for message in Recording(flown[0]).messages():
            if message.topic != "heard/3":
                recorder.write(message.topic, message.t_us, message.data)
    result = verify(folder)
    assert "agent 3" in result.difference


def test_a_watch_sees_a_played_mission_as_it_was(flown):
    folder, result = flown
    hub = LocalHub()
    watch = MissionWatch(hub.bus())
    count = play(folder, hub.bus(), SteppedClock())
    watch.poll()
    assert count > 500
    assert watch.ended
    assert watch.facts.name == "small"
    assert len(watch.declared) == len(result.false_targets) + result.found
    _, seen = watch.merged()
    assert seen.mean() == pytest.approx(result.coverage)


def overheard(flown, folder, *, past=()):
    """What a joined recorder writes of a mission that is played to it."""
    hub = LocalHub()
    with Recorder(folder, mission_name="small", epoch_ns=0, source=BUS) as recorder:
        onlooker = Onlooker(recorder)
        mailbox = hub.bus().subscribe("**")
        play(flown, hub.bus(), SteppedClock())
        first, *rest = mailbox.drain()
        for sample in (first, *past, *rest):
            onlooker.take(sample)
        for garbage in ("air/0/0/1", "state/1", "state/1/event", "cmd/all", "world/past"):
            onlooker.take(Sample(garbage, b"\xff garbage"))
    assert onlooker.watch.ended
    return folder


def test_what_a_joined_recorder_writes_can_be_reported_and_played(flown, tmp_path):
    folder, result = flown
    again = recorded_result(overheard(folder, tmp_path))
    assert again.tracks[2].shape == result.tracks[2].shape
    assert again.seen.mean() == pytest.approx(result.coverage)
    assert again.coverage == pytest.approx(result.coverage)
    assert again.entropy == pytest.approx(result.entropy, rel=0.01)
    assert again.min_separation_m == pytest.approx(result.min_separation_m)
    assert again.agents == result.agents
    assert again.targets == result.targets
    assert again.false_targets == result.false_targets
    assert again.failures == ()
    assert "recorded from the bus" in again.notes[0]
    topics = {message.topic.partition("/")[0] for message in Recording(tmp_path).messages()}
    assert topics >= {"mission", "air", "state", "truth", "event", "score", "pose", "grid", "log"}
    done = CliRunner().invoke(main, ["replay", str(tmp_path), "--verify"])
    assert done.exit_code == 2
    assert "recorded from the bus" in done.output


def test_a_recording_without_scores_is_scored_anew(flown, tmp_path):
    folder, result = flown
    with Recorder(tmp_path, mission_name="small", epoch_ns=0) as recorder:
        for message in Recording(folder).messages():
            if message.topic.partition("/")[0] not in ("score", "summary"):
                recorder.write(message.topic, message.t_us, message.data)
    again = recorded_result(tmp_path)
    assert again.coverage == pytest.approx(result.coverage)
    assert again.series.coverage[-20:] == pytest.approx(result.series.coverage[-20:], abs=0.07)
    assert again.targets == result.targets
    assert again.notes == ()


def test_a_report_of_the_recording_equals_the_flights(flown, tmp_path):
    folder, result = flown
    done = CliRunner().invoke(main, ["report", str(folder), "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    ours = json.loads((tmp_path / "summary.json").read_text())
    assert ours["digest"] == result.digest
    assert ours["coverage"] == result.coverage
    assert (tmp_path / "report.html").exists()


def test_a_recording_that_was_cut_off_verifies_as_far_as_it_goes(flown, tmp_path):
    whole = (flown[0] / "mission.mcap").read_bytes()
    shutil.copy(flown[0] / "mission.toml", tmp_path)
    (tmp_path / "mission.mcap").write_bytes(whole[: len(whole) // 2])
    result = verify(tmp_path)
    assert result.ok
    assert result.decisions > 10


@pytest.mark.parametrize("command", [["replay"], ["replay", "--verify"], ["report"]])
def test_what_is_no_recording_is_one_line_and_status_2(tmp_path, command):
    path = tmp_path / "mission.mcap"
    path.write_bytes(b"not a recording")
    done = CliRunner().invoke(main, [command[0], str(path), *command[1:]])
    assert done.exit_code == 2
    assert str(path) in done.output


@pytest.mark.parametrize(
    ("version", "digest", "coverage", "told"),
    [
        (1, "21191ecbb2d09f78ef21b31357d432d65ddf10f7bb33fa467d01bae503704f0e", 9 / 16, [125, 125]),
        (2, "2be7397ab93ce6a697472c944710f9d2737e1ef885fa236168204be9180e4f4f", 8 / 16, [102, 112]),
    ],
)
def test_a_recording_of_an_older_version_opens(version, digest, coverage, told):
    old = Path(__file__).parent / f"recorded_by_wire_format_{version}.mcap"
    assert Recording(old).digest() == digest  # as was printed then
    result = recorded_result(old)
    assert result.coverage == pytest.approx(coverage)
    assert result.seen.mean() == pytest.approx(coverage)
    assert result.found == 1
    assert [agent.frames_heard + agent.frames_sent for agent in result.agents] == told
    done = CliRunner().invoke(main, ["replay", str(old), "--verify"])
    assert done.output == "35 decisions taken again, none differs\n"
    hub = LocalHub()
    watch = MissionWatch(hub.bus())
    play(old, hub.bus(), SteppedClock())
    watch.poll()
    assert watch.rejects == {}
    assert watch.merged()[1].mean() == pytest.approx(coverage)


def test_a_mission_that_is_not_understood_is_said_with_who_wrote_it(tmp_path):
    with Recorder(tmp_path, mission_name="small", epoch_ns=0) as recorder:
        head = MissionRecord("name = 3", 1, "stepped", {"uavbridge": "0.0.9"})
        recorder.record("mission", 0, head)
    for command in (["report"], ["replay", "--verify"]):
        done = CliRunner().invoke(main, [command[0], str(tmp_path), *command[1:]])
        assert done.exit_code == 2
        assert "recorded by uavbridge 0.0.9" in done.output


def test_a_long_mission_in_parts_verifies_and_reports_as_one(flown, tmp_path):
    folder, result = flown
    rotation = Rotation(part_us=20_000_000)
    epoch_ns = Recording(folder).epoch_ns
    with Recorder(tmp_path, mission_name="small", epoch_ns=epoch_ns, rotation=rotation) as recorder:
        for message in Recording(folder).messages():
            recorder.write(message.topic, message.t_us, message.data)
    for path in folder.glob("*.tlog"):
        shutil.copy(path, tmp_path)
    parts = Recording(tmp_path).parts
    assert len(parts) > 2
    assert verify(tmp_path).decisions == verify(folder).decisions
    again = recorded_result(parts[2])
    assert again.digest == result.digest
    assert again.targets == result.targets
    (tmp_path / "alone").mkdir()
    shutil.copy(parts[2], tmp_path / "alone")
    done = CliRunner().invoke(main, ["replay", str(tmp_path / "alone" / parts[2].name), "--verify"])
    assert done.exit_code == 2
    assert "not the first part" in done.output
