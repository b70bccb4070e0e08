"""The judge: the goal, who found what, the time limit, the lost."""

import math

import numpy as np
import pytest

from planners.belief.merge import MERGE_RULES, SensorModel
from uavbridge import config
from uavbridge.agent.orders import Order, Verb
from uavbridge.agent.orders import decode as decode_order
from uavbridge.agent.orders import encode as encode_order
from uavbridge.agent.report import AgentReport, encode
from uavbridge.bus import keys
from uavbridge.bus.local import LocalHub
from uavbridge.bus.messages import Truth, encode_truth
from uavbridge.bus.wire import DELTA, Frame
from uavbridge.bus.wire import encode as encode_frame
from uavbridge.recording.reader import Recording
from uavbridge.recording.recorder import Recorder
from uavbridge.runner import assemble
from uavbridge.runner.judge import Judge, Verdict

SECOND = 1_000_000


def mission(**changes):
    base = {"vehicles": 2, "duration": 100.0, "radio.frame_bytes": math.inf}
    return config.load(None, {**base, **changes})


class Stage:
    """A judge and the bus it watches."""

    def __init__(self, **changes):
        hub = LocalHub()
        self.bus = hub.bus()
        self.orders = self.bus.subscribe(keys.cmd())
        self.judge = Judge(mission(**changes), hub.bus())

    def report(self, agent, t_us, phase="search", declared=(), failure=""):
        report = AgentReport(
            agent=agent, t_us=t_us, phase=phase, mode="OFFBOARD", position=(1.0, 2.0, 40.0),
            velocity=(0.0, 0.0, 0.0), heading=0.0, armed=True, in_air=True, battery=0.9,
            neighbours=1, note="", distance_m=5.0, declared=list(declared), failure=failure,
        )  # fmt: skip
        self.bus.publish(keys.state(agent), encode(report))

    def seen(self, agent, cells, t_us, detected=False, tick=1):
        rule = MERGE_RULES[self.judge.mission.belief.merge]
        belief = rule.empty(self.judge.mission.grid, np.full((10, 10), 0.5))
        for cell in cells:
            belief = rule.observe(belief, cell, detected, SensorModel(), t_us=t_us, agent=agent)
        data = rule.records(belief, np.flatnonzero(belief.seen.reshape(-1))).tobytes()
        frame = Frame(
            DELTA, agent, tick, t_us, (0.0, 0.0, 40.0), (0.0, 0.0, 0.0), b"", rule.code, data,
            mission=assemble.mission_mark(self.judge.mission),
        )  # fmt: skip
        self.bus.publish(keys.air((0, 0), agent), encode_frame(frame))

    def second(self, number):
        self.judge.step(number * SECOND)
        return [sample.data for sample in self.orders.drain()]


def all_cells():
    return [(c, r) for c in range(10) for r in range(10)]


def test_goal_needs_targets_and_coverage():
    stage = Stage()
    targets = [(4, 5, 3), (4, 7, 4), (7, 5, 5)]
    stage.report(1, SECOND, declared=targets)
    stage.report(2, SECOND)
    assert stage.second(1) == []
    stage.seen(1, all_cells()[:89], SECOND)
    assert stage.second(2) == []
    stage.seen(2, all_cells()[89:90], 2 * SECOND)
    orders = stage.second(3)
    assert stage.judge.verdict is Verdict.GOAL
    assert orders == [b'{"order":"rtl"}']
    assert stage.judge.goal_reached
    assert stage.judge.seen_share == pytest.approx(0.9)


def test_coverage_alone_is_no_goal():
    stage = Stage()
    stage.report(1, SECOND, declared=[(4, 5, 3)])
    stage.seen(1, all_cells(), SECOND)
    stage.second(1)
    assert stage.judge.verdict is Verdict.FLYING
    assert stage.judge.found == 1


def test_the_first_who_declared_a_cell_has_found_it():
    stage = Stage()
    stage.report(2, SECOND, declared=[(4, 5, 700)])
    stage.second(1)
    stage.report(1, SECOND, declared=[(4, 5, 500), (0, 0, 600)])
    stage.second(2)
    found = stage.judge.declared[4, 5]
    assert (found.by, found.t_us) == (1, 500)
    assert stage.judge.found == 1  # (0, 0) is false


def test_time_limit_and_hand_call_home():
    stage = Stage()
    stage.report(1, 99 * SECOND)
    stage.report(2, 99 * SECOND)
    assert stage.second(99) == []
    assert stage.second(100)
    assert stage.judge.verdict is Verdict.TIME
    other = Stage()
    other.judge.stop(SECOND)
    assert other.judge.verdict is Verdict.STOPPED
    assert len(other.orders.drain()) == 1


def test_it_ends_when_all_have_landed_or_are_silent():
    stage = Stage()
    stage.report(1, SECOND, phase="landed")
    stage.report(2, SECOND)
    stage.second(1)
    assert not stage.judge.ended(2 * SECOND)
    assert stage.judge.ended(12 * SECOND)
    assert stage.judge.failures() == ("agent 2: last heard in phase search",)


def test_it_waits_for_the_vehicle_of_a_dead_agent_to_be_down():
    stage = Stage()
    stage.report(1, SECOND, phase="landed")
    stage.report(2, SECOND)
    for second, height_m in ((1, 30.0), (12, 30.0), (40, 30.0), (41, 0.1)):
        places = np.array([[0.0, 0.0, 0.0], [500.0, 0.0, height_m]])
        stage.bus.publish(keys.TRUTH, encode_truth(Truth(second * SECOND, (1, 2), places)))
        stage.second(second)
        assert stage.judge.ended(second * SECOND) == (height_m < 0.5)


def test_nobody_is_lost_while_nothing_can_be_heard():
    stage = Stage()
    stage.report(1, SECOND)
    stage.report(2, SECOND)
    for second in range(1, 31):
        stage.judge.miss(second * SECOND)
        stage.second(second)
    assert not stage.judge.ended(35 * SECOND)
    assert stage.judge.ended(41 * SECOND)


def test_a_failed_agent_is_named_with_its_reason():
    stage = Stage()
    stage.report(1, SECOND, phase="failed", failure="refused to arm: no GPS")
    stage.report(2, SECOND, phase="landed")
    stage.second(1)
    assert stage.judge.failures() == ("agent 1: refused to arm: no GPS",)
    assert stage.judge.verdict is Verdict.LOST


def test_closest_pair_comes_from_the_truth_in_between_too():
    stage = Stage()
    for t, x in ((0, 0.0), (1, 10.0)):
        position = np.array([[x, 0.0, 40.0], [10.0 - x, 3.0, 40.0]])
        stage.bus.publish(keys.TRUTH, encode_truth(Truth(t * 100_000, (1, 2), position)))
        stage.judge.step(t * 100_000)
    assert stage.judge.separation.closest == pytest.approx(3.0)


def test_on_the_ground_nobody_is_too_close():
    stage = Stage()
    position = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 40.0]])
    stage.bus.publish(keys.TRUTH, encode_truth(Truth(0, (1, 2), position)))
    stage.judge.step(0)
    assert np.isnan(stage.judge.separation.closest)


def test_garbage_on_the_bus_is_counted_and_dropped():
    stage = Stage()
    for key in (keys.state(1), keys.TRUTH, keys.air((0, 0), 1)):
        stage.bus.publish(key, b"\x00garbage")
    stage.second(1)
    assert sum(stage.judge.rejects.values()) == 3


@pytest.mark.parametrize("merge", MERGE_RULES)
def test_the_union_is_what_anybody_saw_whatever_the_rule(merge):
    stage = Stage(belief={"merge": merge})
    stage.seen(1, [(0, 0), (1, 1)], SECOND, detected=True)
    stage.seen(2, [(1, 1), (2, 2)], 2 * SECOND, detected=True)
    stage.second(3)
    union = stage.judge.union
    assert stage.judge.seen_share == pytest.approx(0.03)
    one_look, two_looks = union.probability[0, 0], union.probability[1, 1]
    assert union.probability[2, 2] == one_look > 0.5
    if merge in ("sensed-data", "counts"):
        assert two_looks > one_look
    else:
        assert two_looks == one_look  # the newest value, whoever holds others


@pytest.mark.parametrize(
    "report",
    [b'{"agent":1,"phase":"\xd2\xff"}', b'{"x":' + b"[" * 200_000, b"[]", b"", b"\xff" * 40],
)
def test_no_report_whatever_its_bytes_stops_the_judge(report):
    stage = Stage()
    stage.bus.publish(keys.state(1), report)
    stage.second(1)
    assert stage.judge.rejects == {"report": 1}


def test_reports_of_others_of_strangers_and_from_the_future_do_not_count():
    stage = Stage()
    stage.report(1, SECOND)
    (sample,) = stage.judge._states.drain()
    stage.bus.publish(keys.state(2), sample.data)
    stage.report(99, SECOND)
    stage.report(2, 60 * SECOND)
    stage.second(1)
    assert stage.judge.reports == {}
    assert stage.judge.rejects == {"sender": 2, "future": 1}


def test_frames_of_others_and_looks_from_the_future_do_not_count():
    stage = Stage()
    frames = stage.bus.subscribe("air/**")
    stage.seen(1, [(0, 0)], SECOND)
    (sample,) = frames.drain()
    stage.bus.publish(keys.air((0, 0), 2), sample.data)
    stage.bus.publish(keys.air((0, 0), 77), sample.data)
    stage.second(1)
    assert stage.judge.seen_share == pytest.approx(0.01)
    assert stage.judge.rejects == {"sender": 2}
    stage.seen(1, [(1, 1)], 30 * SECOND)
    stage.second(2)
    assert stage.judge.seen_share == pytest.approx(0.01)
    assert stage.judge.rejects == {"sender": 2, "future": 1}


def test_vehicles_that_others_have_do_not_hold_up_the_end():
    stage = Stage(duration=20.0)
    for second in range(100):
        stage.report(1, second * SECOND, phase="landed")
        stage.report(2, second * SECOND, phase="yielded")
        stage.second(second)
        if stage.judge.ended(second * SECOND):
            break
    assert 20 + 60 < second < 20 + 65  # it could have been taken back meanwhile
    assert stage.judge.failures() == ("agent 2: last heard in phase yielded",)


@pytest.mark.parametrize("merge", ["belief-update", "counts"])
def test_what_was_told_in_lost_frames_is_asked_for(merge):
    stage = Stage(**{"belief.merge": merge})
    whole = stage.bus.subscribe("air/**")
    asked = []

    def answer(_key):
        asked.append(1)
        return whole_map

    stage.seen(1, [(0, 0), (1, 1), (2, 2)], 2 * SECOND)  # never reaches the judge
    whole_map = whole.drain()[0].data
    stage.judge._frames.drain()
    stage.bus.serve(keys.state_cells(1), answer)
    stage.seen(1, [(0, 0)], 2 * SECOND, tick=2)
    stage.second(2)
    assert stage.judge.seen_share == pytest.approx(0.01)
    stage.seen(1, [(3, 3)], 4 * SECOND, tick=4)
    stage.second(4)
    assert stage.judge.seen_share == pytest.approx(0.04)
    stage.seen(1, [(4, 4)], 6 * SECOND, tick=6)
    stage.second(6)
    stage.second(14)
    assert len(asked) == 2  # not oftener than every ten seconds


def test_rovers_that_do_not_know_their_place_yet_are_near_nobody():
    stage = Stage(**{"fleet.kind": "rover"})
    for agent in (1, 2):
        stage.report(agent, SECOND, phase="connect")
    stage.second(1)
    assert math.isnan(stage.judge.separation.closest)
    stage.report(1, 2 * SECOND)
    stage.report(2, 2 * SECOND)
    stage.second(2)
    assert stage.judge.separation.closest == 0.0


def test_targets_with_signals_are_found_where_somebody_arrives():
    stage = Stage(**{"signals.range_m": 100.0})
    stage.report(1, SECOND, declared=[(4, 5, 3), (4, 7, 4), (7, 5, 5)])
    stage.second(1)
    assert stage.judge.found == 0
    for agent, found in ((1, [(0, 5), (2, 9)]), (2, [(1, 7), (2, 8), (9, 1)])):
        report = AgentReport(
            agent=agent, t_us=SECOND, phase="search", mode="OFFBOARD", position=(1.0, 2.0, 40.0),
            velocity=(0.0, 0.0, 0.0), heading=0.0, armed=True, in_air=True, battery=0.9,
            neighbours=1, note="", distance_m=5.0, declared=[], found=found,
        )  # fmt: skip
        stage.bus.publish(keys.state(agent), encode(report))
    stage.second(2)
    assert stage.judge.verdict is Verdict.GOAL
    assert {number: (one.by, one.t_us) for number, one in stage.judge.reached.items()} == {
        0: (1, 5),
        1: (2, 7),
        2: (2, 8),
    }
    assert stage.judge.rejects["target"] == 1


def test_orders_are_written_down_and_garbage_is_not(tmp_path):
    hub = LocalHub()
    operator = hub.bus()
    recorder = Recorder(tmp_path, mission_name="liu2022", epoch_ns=0)
    with recorder:
        judge = Judge(mission(), hub.bus(), recorder)
        operator.publish(keys.cmd(2), encode_order(Order(Verb.PAUSE)))
        operator.publish(keys.cmd(2), b"{}")
        judge.step(SECOND)
    assert judge.verdict is Verdict.FLYING
    orders = [m for m in Recording(tmp_path).messages() if m.topic == "cmd/2"]
    assert [decode_order(message.data).verb for message in orders] == [Verb.PAUSE]
