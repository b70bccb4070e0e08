"""A recording in the terminal: its time line, and the keys that move it."""

import os
import pty
import select
import subprocess
import sys
import termios
import time

import pytest

from uavbridge.agent.report import AgentReport, encode
from uavbridge.config import load, to_toml
from uavbridge.monitor import timeline
from uavbridge.monitor.choice import Choice
from uavbridge.monitor.picture import picture
from uavbridge.monitor.replayed import Player
from uavbridge.monitor.terminal import named
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import MissionRecord

SECOND = 1_000_000


@pytest.fixture
def folder(tmp_path):
    """Two agents fly east for five minutes."""
    with Recorder(tmp_path, mission_name="demo", epoch_ns=10**18) as recorder:
        text = to_toml(load(None, {"vehicles": 2}))
        recorder.record("mission", 0, MissionRecord(text, 1, "stepped"))
        for second in range(301):
            for agent in (1, 2):
                report = AgentReport(
                    agent=agent, t_us=second * SECOND, phase="search", mode="OFFBOARD",
                    position=(2.0 * second, 10.0 * agent, 20.0), velocity=(2.0, 0.0, 0.0),
                    heading=0.0, armed=True, in_air=True, battery=0.5, neighbours=1, note="east",
                    distance_m=5.0, declared=[],
                )  # fmt: skip
                recorder.write(f"state/{agent}", report.t_us, encode(report))
    return tmp_path


def settle(player):
    while True:
        player.step()
        if not player.seeking:
            return


def test_keys_pause_seek_and_set_the_speed(folder):
    player = Player(folder)
    timeline.turn(player, " ")
    assert not player.playing
    for keys, second in (
        (["pgdn"], 60),
        (["right", "right"], 80),
        (["left"], 70),
        (["pgup", "pgup"], 0),
        (["end"], 300),
        (["right"], 300),
        (["home"], 0),
    ):
        for key in keys:
            timeline.turn(player, key)
        settle(player)
        assert (player.watch.t_us, player.playing) == (second * SECOND, False)
    speeds = []
    for key in "+++-------+":
        timeline.turn(player, key)
        speeds.append(player.speed)
    assert speeds == [2.0, 5.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.1, 0.2]
    timeline.turn(player, "x")
    timeline.turn(player, " ")
    assert player.playing


def test_at_the_end_it_stands_still_and_begins_anew(folder):
    player = Player(folder)
    timeline.turn(player, "end")
    settle(player)
    player.step()
    assert not player.playing
    assert player.watch.agents[1].position == (600.0, 10.0, 20.0)
    timeline.turn(player, " ")
    settle(player)
    assert player.playing
    assert player.watch.t_us < 5 * SECOND


@pytest.mark.parametrize(("width", "height"), [(80, 24), (200, 60), (30, 8)])
def test_the_screen_of_a_recording_fits_and_tells_where_it_is(folder, width, height):
    player = Player(folder)
    timeline.turn(player, " ")
    player.seek(150 * SECOND)
    settle(player)
    lines = picture(player.watch, Choice(), width, height, player)
    assert len(lines) <= height
    assert all(line.cell_len <= width for line in lines)
    assert lines[-2].plain.startswith("paused  1x  2:30 ━")
    assert lines[-1].plain.startswith("space play")
    if width >= 80:
        assert lines[-2].plain.endswith("5:00")
        assert abs(lines[-2].plain.index("●") - (17 + (width - 22) / 2)) < 2


def test_keys_are_read_from_what_terminals_send():
    assert named("p\x1b[A\x1bOB\x1b[5~q") == ["p", "up", "down", "pgup", "q"]
    assert named("\x1b[15~\x1b[1;5C\x1b") == []  # keys that mean nothing are no letters
    assert named("\x1b[H\x1b[4~ ") == ["home", "end", " "]


@pytest.mark.integration
@pytest.mark.parametrize("stop", [b"q", b"\x03", None])
def test_a_recording_is_shown_and_the_terminal_left_as_it_was(folder, stop):
    ours, theirs = pty.openpty()
    termios.tcsetwinsize(theirs, (24, 80))
    before = termios.tcgetattr(theirs)
    process = subprocess.Popen(
        [sys.executable, "-m", "uavbridge", "monitor", str(folder)],
        stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
    )  # fmt: skip
    try:
        read(ours, "search   OFFBOARD")
        if stop == b"\x03":
            process.send_signal(2)
        elif stop is None:
            process.terminate()
        else:
            os.write(ours, stop)
        left = read(ours, "\x1b[?1049l")
        assert process.wait(20) == 0
        assert "Traceback" not in left
        assert termios.tcgetattr(theirs) == before
    finally:
        process.kill()
        process.wait()
        os.close(ours)
        os.close(theirs)


def read(stream, until, timeout_s=30.0):
    """What is written to a terminal until a text comes."""
    text, end = "", time.monotonic() + timeout_s
    while until not in text:
        assert time.monotonic() < end, text
        if select.select([stream], [], [], 0.1)[0]:
            text += os.read(stream, 65536).decode(errors="ignore")
    return text
