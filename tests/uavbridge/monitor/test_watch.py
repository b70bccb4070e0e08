"""What an onlooker makes of a mission: the same as its judge, and the same as each agent."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from planners.grid import Grid
from planners.registry import BUILTIN
from tests.uavbridge.agent.swarm import Swarm
from uavbridge.agent.report import AgentReport
from uavbridge.bus import keys
from uavbridge.bus.api import Sample
from uavbridge.bus.messages import Truth, encode_truth
from uavbridge.config import load, to_toml
from uavbridge.monitor.maps import Maps
from uavbridge.monitor.watch import MissionWatch
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import MissionRecord, encode
from uavbridge.runner import stepped
from uavbridge.runner.assemble import planner_of

REPORT = AgentReport(
    agent=1, t_us=5_000_000, phase="search", mode="OFFBOARD", position=(1.0, 2.0, 40.0),
    velocity=(0.0, 0.0, 0.0), heading=0.0, armed=True, in_air=True, battery=0.5, neighbours=1,
    note="", distance_m=5.0, declared=[],
)  # fmt: skip
JOIN_US = 25_000_000


def _fly(tmp_path, watches, **changes):
    """A short stepped mission with watches: {name: join time}; the flown, the watches."""
    mission = load(None, {"vehicles": 3, "duration": 40.0, "clock": "stepped", **changes})
    made = {}

    def progress(t_us, judge, host):
        for name, join_us in watches.items():
            if t_us >= join_us and name not in made:
                made[name] = MissionWatch(judge._bus._hub.bus())
            if name in made:
                made[name].poll()

    with Recorder(tmp_path, mission_name="m", epoch_ns=0, mcap=False) as recorder:
        flown = stepped.fly_stepped(
            mission,
            planner_of(mission, BUILTIN["esustpm"]),
            recorder=recorder,
            progress=progress,
            stop=lambda: False,
        )
    return flown, made


@pytest.mark.parametrize("rule", ["belief-update", "counts"])
def test_an_agents_map_is_shown_as_it_is_by_whom_it_heard(rule):
    """Between two whole maps, and though agents do not repeat what all in reach heard."""
    swarm = Swarm(4, rule, Grid(0, 0, 100, 10, 10))
    maps = Maps()
    maps.take_mission(load(None, {"vehicles": 4, "belief.merge": rule, "sensor.q": 0.2}))
    maps._team = (0, 1, 2, 3)
    for tick in range(12):
        swarm.observe(tick % 4, 7 * tick, tick % 3 == 0)
        swarm.exchange(lambda a, b: (1,) if abs(a - b) < 3 else ())
        for frame in {frame.sender: frame for _, frame in swarm._due[swarm.tick]}.values():
            assert maps.take_frame(frame)
        if tick < 4:
            continue  # links are not known yet
        for agent, (mapping, _) in enumerate(swarm.minds):
            shown = maps.agents[agent].seen
            assert not (shown & ~mapping.belief.seen).any()
            assert (mapping.belief.seen & ~shown).sum() == 0
    for agent, (mapping, _) in enumerate(swarm.minds):
        known = mapping.belief.seen
        np.testing.assert_allclose(
            maps.agents[agent].probability[known], mapping.belief.probability[known], atol=0.01
        )


@pytest.mark.parametrize("rule", ["belief-update", "counts"])
def test_a_watch_knows_what_the_judge_and_the_agents_know(tmp_path, rule):
    watches = {"first": 0, "late": JOIN_US}
    flown, made = _fly(tmp_path, watches, **{"belief.merge": rule, "radio.range_m": 120.0})
    judge = flown.judge
    for name, watch in made.items():
        probability, seen = watch.merged()
        np.testing.assert_array_equal(seen, judge.union.seen, err_msg=name)
        np.testing.assert_allclose(probability, judge.union.probability, atol=1e-6)
        assert {c: (d.t_us, d.by) for c, d in watch.declared.items()} == {
            c: (d.t_us, d.by) for c, d in judge.declared.items()
        }
        assert watch.found == judge.found
        assert watch.facts.targets == judge.mission.targets
        assert watch.rejects == {}
        for seat in flown.host.seats:
            agent = watch.agents[seat.agent.plan.agent]
            shown = watch.maps.agents[agent.id]
            belief = seat.agent.mapping.belief
            np.testing.assert_array_equal(shown.seen, belief.seen)
            np.testing.assert_allclose(shown.probability, belief.probability, atol=1e-6)
            assert agent.report.phase == seat.agent.phase.value
            assert agent.alive
    early, late = made["first"], made["late"]
    # All of the past, and then one point a second but for the one in which reports came in.
    missed = {s.t_us for s in judge.samples[: len(late.series)]} - {p.t_us for p in late.series}
    assert len(missed) <= 1
    assert {e.text for e in late.events} >= {"arm", "takeoff", "search", "landed"}
    assert {i: len(a.track) for i, a in late.agents.items()} == pytest.approx(
        {i: len(track) for i, track in judge.tracks.items()}, abs=2
    )
    assert early.separation.closest == judge.separation.closest
    assert late.separation.closest == pytest.approx(judge.separation.closest)
    assert [p.coverage for p in early.series[1:-1]] == pytest.approx(
        [s.coverage for s in judge.samples[1:-1]][: len(early.series) - 2], abs=0.05
    )


@pytest.mark.parametrize("data", [b"\xff\xfe", b'{"a":"\xff"}', b"[" * 100_000, b"null", b""])
def test_what_does_not_read_is_counted_and_left_out(data):
    watch = MissionWatch()
    spaces = ("state/1", "state/1/event", "state/1/ack", "state/1/map", "cmd/all", "air/0/0/1")
    for key in (*spaces, "safety/0/0/1", keys.TRUTH, keys.MISSION, keys.PAST):
        watch.apply(Sample(key, data))
    assert sum(watch.rejects.values()) == 10
    assert not watch.agents
    assert not watch.events


def test_targets_reached_by_their_signals_count_as_found():
    watch = MissionWatch()
    mission = load(None, {"vehicles": 2, "planner": "mountain", "signals.range_m": 100.0})
    record = MissionRecord(to_toml(mission), 1, "paced")
    watch.apply(Sample(keys.MISSION, encode(record)))
    assert watch.found == 0
    values = msgspec.structs.asdict(REPORT) | {"found": [(1, 4_000_000), (7, 4_000_000)]}
    watch.apply(Sample(keys.state(1), encode(AgentReport(**values))))
    assert watch.found == 1  # there is no target 7
    (find,) = watch.finds.all()
    assert (find.cell, find.by) == (mission.target_cells()[1], 1)
    assert watch.events[-1].text == "target 1 reached"


def test_vehicles_on_a_hill_are_not_in_the_air():
    watch = MissionWatch()
    mission = load(None, {"vehicles": 2, "terrain.steepest_deg": 20.0})
    watch.apply(Sample(keys.MISSION, encode(MissionRecord(to_toml(mission), 1, "paced"))))
    places = np.array([[100.0, 100.0, 0.0], [103.0, 100.0, 0.0]])
    places[:, 2] = mission.terrain().height_at(places)
    for t_us, above_m in ((0, 0.0), (100_000, 30.0)):
        truth = Truth(t_us, (1, 2), places + np.array([0.0, 0.0, above_m]))
        watch.apply(Sample(keys.TRUTH, encode_truth(truth)))
        assert np.isnan(watch.separation.closest) == (above_m == 0.0)
