"""After any loss, delay, doubling, disorder, partition and restart: one map, cell by cell."""

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule

from tests.uavbridge.agent.swarm import Swarm
from uavbridge.rng import stream

TEAM = 20
CONVERGE = ("belief-update", "counts", "sensed-data")  # in values; the others in stamps alone
MOST_TICKS = 250

seeds = st.integers(0, 2**32 - 1)


class History(RuleBasedStateMachine):
    """Twenty agents and whatever a radio may do to them; in the end it lets them talk."""

    @initialize(
        merge=st.sampled_from((*CONVERGE, *CONVERGE, "average", "ogmm", "modified-ogmm")),
        frame_bytes=st.sampled_from((128.0, 300.0, 1200.0, np.inf)),
        seed=seeds,
    )
    def begin(self, merge, frame_bytes, seed):
        self.values = merge in CONVERGE
        self.swarm = Swarm(TEAM, merge, frame_bytes=frame_bytes)
        self.side = np.zeros(TEAM, int)
        self.rng = stream(seed, "history")

    @rule(agents=st.lists(st.integers(0, TEAM - 1), max_size=6), seed=seeds)
    def look(self, agents, seed):
        rng = stream(seed, "looks")
        for agent in agents:
            self.swarm.observe(agent, rng.integers(36), rng.random() < 0.4)

    @rule(
        ticks=st.integers(1, 3),
        loss=st.sampled_from((0.0, 0.3, 0.9)),
        doubled=st.sampled_from((0.0, 0.3)),
        delay=st.sampled_from((1, 2, 6)),
    )
    def talk(self, ticks, loss, doubled, delay):
        def fate(sender, receiver):
            if self.side[sender] != self.side[receiver] or self.rng.random() < loss:
                return ()
            copies = 1 + int(self.rng.random() < doubled)
            return tuple(self.rng.integers(1, delay + 1, copies).tolist())

        for _ in range(ticks):
            self.swarm.exchange(fate)

    @rule(parts=st.integers(1, 4))
    def divide(self, parts):
        self.side = self.rng.integers(0, parts, TEAM)

    @rule(agent=st.integers(0, TEAM - 1))
    def restart(self, agent):
        self.swarm.restart(agent)

    def teardown(self):
        if not hasattr(self, "swarm"):
            return
        # who hears whom in the end: a ring, with a few links across
        across = {tuple(pair) for pair in self.rng.integers(0, TEAM, (6, 2)).tolist()}

        def linked(a, b):
            return (a - b) % TEAM in (1, TEAM - 1) or (a, b) in across or (b, a) in across

        assert self.swarm.settle(linked, MOST_TICKS, self.values) is not None
        assert all(mapping.unreadable == 0 for mapping, _ in self.swarm.minds)


CALM = {
    "deadline": None,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large],
    "stateful_step_count": 12,
}
TestHistories = History.TestCase
TestHistories.settings = settings(max_examples=200, **CALM)


@pytest.mark.soak
class TestManyHistories(History.TestCase):
    settings = settings(max_examples=3000, **CALM)


@pytest.mark.parametrize("merge", CONVERGE)
def test_all_fall_silent_once_they_agree(merge):
    swarm = Swarm(6, merge)
    for agent in range(6):
        swarm.observe(agent, 7 * agent, True)
    assert swarm.settle(lambda a, b: abs(a - b) == 1, 100) is not None
    for _ in range(10):
        swarm.exchange(lambda _a, _b: (1,))
    before = swarm.map_bytes_sent
    for _ in range(50):
        swarm.exchange(lambda _a, _b: (1,))
    assert swarm.map_bytes_sent == before


def test_without_merging_nobody_learns_and_nobody_asks():
    swarm = Swarm(4, "uncoordinated")
    swarm.observe(0, 3, True)
    assert swarm.settle(lambda _a, _b: True, 20) is None
    assert swarm.map_bytes_sent == 18
