"""What goes first when a frame has not room for everything."""

import numpy as np
import pytest

from planners.belief.merge import MERGE_RULES, SensorModel
from planners.grid import Grid
from tests.uavbridge.agent.swarm import plan_of
from uavbridge.agent.mapping import Mapping
from uavbridge.agent.outbox import COPIES, Outbox
from uavbridge.agent.telling import Telling
from uavbridge.bus.wire import encode

GRID = Grid(0, 0, 10, 20, 20)
SIZE = 18


def looked(merge="belief-update", cells=range(40), agent=1, looks=1):
    """A map with looks at some cells."""
    rule = MERGE_RULES[merge]
    belief = rule.empty(GRID, 0.5)
    for look in range(looks):
        for cell in cells:
            place = divmod(cell, GRID.rows)
            belief = rule.observe(
                belief, place, True, SensorModel(), t_us=look * 1000 + cell, agent=agent
            )
    return rule, belief


def sent(outbox, belief, records, record_size=SIZE):
    data = outbox.take(belief, records * record_size + 5)
    assert len(data) <= records * record_size
    return np.frombuffer(data, outbox._rule.record)["cell"].tolist()


def filled(own=(), heard=(), change=lambda cell: 0.1):
    rule, belief = looked()
    outbox = Outbox(rule)
    for cells, mine in ((heard, False), (own, True)):
        for cell in cells:
            outbox.changed(rule.records(belief, [cell]), np.array([change(cell)]), own=mine)
    return outbox, belief


def test_with_room_for_all_all_go_once_by_cell():
    outbox, belief = filled(own=(5, 3), heard=(4, 1))
    assert sent(outbox, belief, 10) == [1, 3, 4, 5]
    assert outbox.take(belief, 1000) == b""


def test_own_observations_go_first_then_what_changed_most():
    outbox, belief = filled(own=(0, 1, 2), heard=range(3, 30), change=lambda cell: cell / 100)
    assert sent(outbox, belief, 3) == [0, 1, 2]
    # a quarter for those that wait longest
    assert sent(outbox, belief, 4) == [3, 27, 28, 29]


@pytest.mark.parametrize("records", [1, 2, 3, 7])
def test_nothing_waits_for_ever(records):
    outbox, belief = filled(heard=[0])
    rule = outbox._rule
    for tick in range(200):
        if tick < 100:
            cells = [1 + (tick * records + k) % 39 for k in range(records)]
            for cell in cells:
                outbox.changed(rule.records(belief, [cell]), np.array([0.9]), own=True)
        if 0 in sent(outbox, belief, records):
            break
    assert tick < 6


@pytest.mark.parametrize("records", [1, 2, 8])
def test_who_asks_gets_a_share_while_much_changes(records):
    outbox, belief = filled(own=range(20))
    rule = outbox._rule
    outbox.asked_for([30, 31])
    told = []
    for _ in range(30):
        for cell in range(20):
            outbox.changed(rule.records(belief, [cell]), np.array([0.9]), own=True)
        told += sent(outbox, belief, records)
    assert {30, 31} <= set(told)
    assert outbox.asked == 0


def test_a_later_change_takes_the_place_of_an_earlier_one():
    rule, before = looked(cells=[7])
    _, after = looked(cells=[7], looks=2)
    outbox = Outbox(rule)
    outbox.changed(rule.records(before, [7]), np.array([0.1]), own=True)
    outbox.changed(rule.records(after, [7]), np.array([0.1]), own=True)
    assert outbox.waiting == 1
    assert outbox.take(after, 1000) == rule.records(after, [7]).tobytes()


def test_what_others_told_often_enough_is_not_passed_on():
    outbox, belief = filled(own=[1], heard=[2, 3])
    rule = outbox._rule
    for _ in range(COPIES):
        outbox.heard(rule.records(belief, [1, 2]))
    assert sent(outbox, belief, 10) == [1, 3]


def test_what_somebody_told_need_not_be_answered():
    rule, belief = looked()
    outbox = Outbox(rule)
    outbox.asked_for([1, 2])
    outbox.heard(rule.records(belief, [2]))
    assert sent(outbox, belief, 10) == [1]


def test_a_long_history_goes_in_parts():
    rule, belief = looked("sensed-data", cells=[4, 5], looks=7)
    outbox, size = Outbox(rule), rule.record.itemsize
    outbox.asked_for([4, 5])
    told = b"".join(outbox.take(belief, 3 * size) for _ in range(5))
    assert sorted(np.frombuffer(told, rule.record).tolist()) == sorted(
        rule.records(belief, [4, 5]).tolist()
    )
    assert outbox.take(belief, 3 * size) == b""


def test_no_limit_sends_everything():
    outbox, belief = filled(own=range(10), heard=range(10, 20))
    outbox.asked_for(range(15, 40))
    cells = np.frombuffer(outbox.take(belief, np.inf), outbox._rule.record)["cell"]
    assert cells.tolist() == list(range(40))


def test_a_payload_that_leaves_no_room_is_told_once(caplog):
    plan = plan_of(3, "counts", GRID, frame_bytes=200.0)
    telling = Telling(plan, Mapping(plan))
    sizes = [
        len(encode(telling.frame(tick * 1_000_000, (0, 0, 0), (0, 0, 0), bytes(size))))
        for tick, size in enumerate((10, 150, 150))
    ]
    assert sizes == [54, 194, 194]
    (warning,) = [record.getMessage() for record in caplog.records]
    assert "agent 3: a payload of 150 bytes leaves no room for the map" in warning
