"""The terminal monitor: what is on the screen, and what the keys do."""

import time

import numpy as np
import pytest

from planners.belief.merge import BeliefUpdate, SensorModel
from uavbridge import config
from uavbridge.agent.orders import Verb
from uavbridge.agent.report import AgentReport, encode
from uavbridge.bus import keys
from uavbridge.bus.api import Sample
from uavbridge.bus.wire import DELTA, Frame
from uavbridge.bus.wire import encode as encode_frame
from uavbridge.config import to_toml
from uavbridge.monitor.choice import Choice, press
from uavbridge.monitor.picture import picture
from uavbridge.monitor.watch import MissionWatch
from uavbridge.recording.topics import MissionRecord
from uavbridge.recording.topics import encode as encode_record

SECOND = 1_000_000
RULE = BeliefUpdate()


def watched(agents=10, note="to cell 4,5", seen=True):
    """A watch that was fed a mission a few seconds old."""
    mission = config.load(None, {"vehicles": agents})
    watch = MissionWatch()
    record = MissionRecord(to_toml(mission), 1, "paced")
    watch.apply(Sample(keys.MISSION, encode_record(record)))
    for agent in range(1, agents + 1):
        at = (50.0 + 100 * ((agent - 1) % 10), 150.0, 40.0)
        report = AgentReport(
            agent=agent, t_us=5 * SECOND, phase="search", mode="OFFBOARD", position=at,
            velocity=(0.0, 0.0, 0.0), heading=0.0, armed=True, in_air=True, battery=0.5,
            neighbours=1, note=note, distance_m=5.0,
            declared=[(4, 5, 4 * SECOND)] if agent == 2 else [],
            dropped={"loss": 2, "out of range": agent},
        )  # fmt: skip
        watch.apply(Sample(keys.state(agent), encode(report)))
    if seen:
        belief = RULE.empty(mission.grid, np.full((10, 10), 0.5))
        for hit in (False, True, True, True):
            belief = RULE.observe(belief, (9, 9), hit, SensorModel(), t_us=SECOND, agent=1)
        cells = RULE.records(belief, [99]).tobytes()
        frame = Frame(DELTA, 1, 1, 5 * SECOND, (50.0, 150.0, 40.0), (0.0, 0.0, 0.0), b"", 1, cells)
        watch.apply(Sample(keys.air((0, 0), 1), encode_frame(frame)))
    watch.apply(Sample(keys.cmd(), b'{"order":"pause"}'), 7 * SECOND)
    return watch


@pytest.mark.parametrize(("width", "height"), [(80, 24), (200, 60), (40, 10), (120, 30)])
@pytest.mark.parametrize("agents", [1, 10, 60])
def test_the_screen_fits(width, height, agents):
    lines = picture(watched(agents), Choice(), width, height)
    assert len(lines) <= height
    assert all(line.cell_len <= width for line in lines)


def test_eighty_by_twenty_four_shows_everything_of_ten_agents():
    text = "\n".join(line.plain for line in picture(watched(), Choice(), 80, 24))
    for word in (
        "liu2022",
        "esustpm",
        "0:07",
        "not heard 55 out of range, 20 loss",
        "targets 1 declared",
        "pause to all",
        "q quit",
    ):
        assert word in text
    for agent in range(1, 11):
        assert f"{agent:3d} search   OFFBOARD" in text
    assert text.count("to cell 4,5") == 10
    assert "()" in text  # the declared cell
    assert "██" in text  # a cell that surely holds a target
    assert text.splitlines()[5].rstrip().endswith("██│")  # north-east corner of the map


def test_an_emulated_radio_is_told():
    watch = watched()
    plain = "\n".join(line.plain for line in picture(watch, Choice(), 80, 24))
    assert "radio emulated: range 400 m" in plain


def test_who_hears_whom_is_told():
    watch = watched(3)
    for agent in (1, 3):
        at = (50.0 + 100 * (agent - 1), 150.0, 40.0)
        frame = Frame(DELTA, agent, 2, 6 * SECOND, at, (0.0, 0.0, 0.0))
        watch.apply(Sample(keys.air((0, 0), agent), encode_frame(frame)))
    wide = [line.plain for line in picture(watch, Choice(), 200, 40)]
    assert "heard by" in wide[5]
    assert [line[40:62].split() for line in wide[6:9]] == [["2", "2", "3"], ["0"], ["2", "1", "2"]]
    *_, detail, links, _ = picture(watch, Choice(chosen=2), 80, 24)
    assert "agent 2: to cell 4,5" in detail.plain
    assert links.plain.startswith("hears 1 3, heard by -; sent 0 B")


def test_a_hundred_agents_are_drawn_at_once():
    watch = watched(100)
    began = time.process_time()
    for _ in range(5):
        picture(watch, Choice(), 200, 120)
    assert time.process_time() - began < 2.0  # of the 5 a second that it is drawn


def test_more_agents_than_lines_are_counted():
    text = "\n".join(line.plain for line in picture(watched(60), Choice(), 80, 24))
    assert "more" in text


def test_what_comes_over_the_bus_cannot_move_the_cursor():
    watch = watched(note="\x1b[2J\x07evil\n")
    text = "".join(line.plain for line in picture(watch, Choice(), 100, 24))
    assert "\x1b" not in text
    assert "\x07" not in text


def test_before_anything_is_heard():
    lines = picture(MissionWatch(), Choice(), 80, 24)
    assert "waiting" in lines[0].plain


def test_harmless_orders_go_at_once_dangerous_ones_are_asked_for():
    sent = []

    def send(verb, agent):
        sent.append((verb, agent))
        return f"{verb.value}: done"

    choice, agents = Choice(), [1, 2, 3]
    press(choice, "p", agents, send)
    assert sent.pop() == (Verb.PAUSE, None)
    press(choice, "down", agents, send)
    press(choice, "down", agents, send)
    press(choice, "l", agents, send)
    assert sent == []
    assert "land agent 2? y/n" in picture(watched(), choice, 80, 24)[-1].plain
    press(choice, "n", agents, send)
    assert (sent, choice.asked) == ([], None)
    press(choice, "l", agents, send)
    press(choice, "y", agents, send)
    assert sent.pop() == (Verb.LAND, 2)
    assert "land: done" in picture(watched(), choice, 80, 24)[-1].plain
    press(choice, "up", agents, send)
    press(choice, "up", agents, send)
    press(choice, "a", agents, send)
    assert "abort ALL agents?" in picture(watched(), choice, 80, 24)[-1].plain
    press(choice, "q", agents, send)
    assert not choice.done  # an answer to the question, not a quit
    press(choice, "q", agents, send)
    assert choice.done
