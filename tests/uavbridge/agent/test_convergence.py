"""After any loss, delay, doubling, disorder, partition and restart: one map, cell by cell."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.uavbridge.agent.swarm import Swarm
from uavbridge.rng import stream

TEAM = 20
CONVERGE = ("belief-update", "counts", "sensed-data")  # in values; the others in stamps alone
MOST_TICKS = 250

seeds = st.integers(0, 2**32 - 1)


@dataclass(frozen=True)
class Look:
    """Some agents look somewhere."""

    agents: list[int]
    seed: int


@dataclass(frozen=True)
class Talk:
    """All send, and a radio does this to it."""

    ticks: int
    loss: float
    doubled: float
    delay: int


@dataclass(frozen=True)
class Divide:
    """From now on they are in so many parts that do not hear each other."""

    parts: int


@dataclass(frozen=True)
class Restart:
    """One forgets all but what it told."""

    agent: int


@dataclass(frozen=True)
class Team:
    """Who they are."""

    merge: str
    frame_bytes: float
    seed: int


# A history is drawn as a whole before any of it happens: what is drawn can not depend on what an
# agent does, nor on how long that takes.
teams = st.builds(
    Team,
    merge=st.sampled_from((*CONVERGE, *CONVERGE, "average", "ogmm", "modified-ogmm")),
    frame_bytes=st.sampled_from((128.0, 300.0, 1200.0, np.inf)),
    seed=seeds,
)
members = st.integers(0, TEAM - 1)
histories = st.lists(
    st.one_of(
        st.builds(Look, agents=st.lists(members, max_size=6), seed=seeds),
        st.builds(
            Talk,
            ticks=st.integers(1, 3),
            loss=st.sampled_from((0.0, 0.3, 0.9)),
            doubled=st.sampled_from((0.0, 0.3)),
            delay=st.sampled_from((1, 2, 6)),
        ),
        st.builds(Divide, parts=st.integers(1, 4)),
        st.builds(Restart, agent=members),
    ),
    min_size=3,
    max_size=15,
)


class History:
    """Twenty agents and whatever a radio may do to them."""

    def __init__(self, team):
        self.values = team.merge in CONVERGE
        self.swarm = Swarm(TEAM, team.merge, frame_bytes=team.frame_bytes)
        self.side = np.zeros(TEAM, int)
        self.rng = stream(team.seed, "history")

    def happen(self, step):
        match step:
            case Look(agents, seed):
                rng = stream(seed, "looks")
                for agent in agents:
                    self.swarm.observe(agent, rng.integers(36), rng.random() < 0.4)
            case Talk(ticks, loss, doubled, delay):
                for _ in range(ticks):
                    self.swarm.exchange(self.fates(loss, doubled, delay))
            case Divide(parts):
                self.side = self.rng.integers(0, parts, TEAM)
            case Restart(agent):
                self.swarm.restart(agent)

    def fates(self, loss, doubled, delay):
        def fate(sender, receiver):
            if self.side[sender] != self.side[receiver] or self.rng.random() < loss:
                return ()
            copies = 1 + int(self.rng.random() < doubled)
            return tuple(self.rng.integers(1, delay + 1, copies).tolist())

        return fate

    def end(self):
        """The radio lets them talk: a ring, with a few links across; all maps agree."""
        across = {tuple(pair) for pair in self.rng.integers(0, TEAM, (6, 2)).tolist()}

        def linked(a, b):
            return (a - b) % TEAM in (1, TEAM - 1) or (a, b) in across or (b, a) in across

        assert self.swarm.settle(linked, MOST_TICKS, self.values) is not None
        assert all(mapping.unreadable == 0 for mapping, _ in self.swarm.minds)


def live_through(team, steps):
    history = History(team)
    for step in steps:
        history.happen(step)
    history.end()


CALM = [HealthCheck.too_slow, HealthCheck.data_too_large]


@settings(max_examples=200, suppress_health_check=CALM)
@given(teams, histories)
def test_all_maps_agree_in_the_end(team, steps):
    live_through(team, steps)


@pytest.mark.soak
@settings(max_examples=3000, suppress_health_check=CALM)
@given(teams, histories)
def test_all_maps_agree_after_thousands_of_histories(team, steps):
    live_through(team, steps)


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
