"""Who lacks something finds it out with few bytes, and gets it."""

import numpy as np
import pytest

from planners.grid import Grid
from planners.types import Reading
from tests.uavbridge.agent.swarm import SECOND, Swarm
from uavbridge.agent.differences import EMPTY, Differences
from uavbridge.bus.wire import Probe

SHARING = ("belief-update", "counts", "sensed-data", "average", "ogmm", "modified-ogmm")


def everybody(_a, _b):
    return (1,)


def agreeing(merge, frame_bytes=np.inf, cells=36, count=5):
    """Agents that all know of some cells, and are quiet."""
    swarm = Swarm(count, merge, frame_bytes=frame_bytes)
    for cell in range(cells):
        swarm.observe(cell % (count - 1), cell, cell % 3 == 0)
    for _ in range(60):
        swarm.exchange(lambda a, b: (1,) if count - 1 not in (a, b) else ())
    return swarm


@pytest.mark.parametrize("merge", SHARING)
@pytest.mark.parametrize("frame_bytes", [128.0, np.inf])
def test_who_comes_late_asks_and_gets_all(merge, frame_bytes):
    swarm = agreeing(merge, frame_bytes)
    mapping, _ = swarm.minds[-1]
    assert not mapping.belief.seen.any()
    before = swarm.map_bytes_sent
    ticks = 0
    while not swarm.alike(values=False):
        swarm.exchange(everybody)
        ticks += 1
    assert ticks <= (8 if frame_bytes == np.inf else 60)
    record = swarm.plans[0].rule.record.itemsize
    assert swarm.map_bytes_sent - before < 3 * 36 * record + 1000


@pytest.mark.parametrize("merge", SHARING)
def test_who_starts_anew_gets_its_own_looks_back(merge):
    swarm = Swarm(3, merge)
    for agent in range(3):
        swarm.observe(agent, 5 * agent, True)
    for _ in range(20):
        swarm.exchange(everybody)
    swarm.restart(1)
    for _ in range(10):
        swarm.exchange(everybody)
    assert swarm.minds[1][0].belief.seen.sum() == 3
    assert swarm.alike(values=False)


@pytest.mark.parametrize("side", [10, 60, 300])
def test_one_cell_that_got_lost_is_found_in_a_large_map(side):
    swarm = Swarm(2, "belief-update", Grid(0, 0, 1, side, side))
    for cell in range(0, side * side, side * side // 97):
        swarm.observe(0, cell, False)
    for _ in range(20):
        swarm.exchange(everybody)
    assert swarm.alike()
    swarm.observe(0, side * side // 2 + 1, True)
    swarm.exchange(lambda _a, _b: ())  # nobody hears of it
    before, ticks = swarm.map_bytes_sent, 0
    while not swarm.alike():
        swarm.exchange(everybody)
        ticks += 1
    assert ticks < 25
    assert swarm.map_bytes_sent - before < 450


def test_what_is_on_its_way_costs_little():
    swarm, rng = Swarm(10, "counts", Grid(0, 0, 100, 10, 10)), np.random.default_rng(3)
    for tick in range(150):
        swarm.observe(tick % 10, rng.integers(100), False)
        swarm.exchange(lambda a, b: (1,) if abs(a - b) <= 3 else ())
    record = swarm.plans[0].rule.record.itemsize
    probes = swarm.map_bytes_sent / (10 * 150)
    assert probes < 3 * record  # about one record a tick is news to each


def test_probes_that_make_no_sense_are_counted():
    swarm = Swarm(2, "counts")
    swarm.observe(0, 1, True)
    swarm.exchange(everybody)
    frame = swarm._due[1][0][1]
    for probe in (Probe(1, 10**6, (1,)), Probe(1, 0, (1,) * 16), Probe(7, 0, (9,))):
        swarm.minds[1][0].merge([type(frame)(*[
            getattr(frame, name) if name != "probes" else (probe,)
            for name in frame.__struct_fields__
        ])])  # fmt: skip
    assert swarm.minds[1][0].unreadable == 2  # the third is for somebody else


def test_what_just_changed_is_mostly_not_compared():
    tree = Differences(100)
    tree.update(np.array([3]), np.array([7], np.uint64), frame=10)
    assert tree.digests(0, frame=11, salt=1).tolist() == [0, *[EMPTY] * 6]
    assert tree.digests(0, frame=11, salt=4)[0] > EMPTY  # in every fourth it is
    assert tree.digests(0, frame=15, salt=1)[0] > EMPTY
    assert tree.digests(0, 15, 1)[0] != tree.digests(0, 15, 2)[0]
    assert tree.digests(200, 15, 1).tolist() == []


def test_a_look_raises_no_alarm_where_nobody_is():
    swarm = Swarm(1, "counts")
    swarm.minds[0][0].observe(Reading(SECOND, (1, 1), True))
    for _ in range(5):
        swarm.exchange(everybody)
    assert swarm.map_bytes_sent == 18
