"""Who passes on what."""

import pytest

from tests.uavbridge.agent.swarm import ZERO, Swarm
from uavbridge.agent.relaying import Relaying, Sources
from uavbridge.bus.wire import DELTA, Frame

TEAM = (3, 5, 8, 13)
A, B, C, D = 1, 2, 4, 8  # bits of the team
RECORD = 18


def said(sender, tick, heard):
    return Frame(DELTA, sender, tick, tick * 1_000_000, ZERO, ZERO, heard=heard)


def among(agent, *heard, tick=7):
    """An agent whose neighbours (id, of whom they heard) spoke one tick before."""
    relaying = Relaying(agent, TEAM)
    relaying.tell(tick - 1)
    relaying.heard([said(sender, tick - 1, of) for sender, of in heard])
    relaying.tell(tick)
    return relaying


def test_what_all_heard_is_not_passed_on():
    relaying = among(5, (3, B | C), (8, A | B))
    assert not relaying.needed(Sources(6, A))
    assert not relaying.needed(Sources(6, A | C))


def test_what_a_neighbour_did_not_hear_is():
    relaying = among(5, (3, B), (8, B))
    assert relaying.needed(Sources(6, A))
    assert relaying.needed(Sources(6, C))
    assert not relaying.needed(Sources(6, A | C))


def test_the_first_of_those_who_can_does_it():
    # 13 hears 5 and 8, who both hear 3; 3 does not reach it
    assert among(5, (3, B | C), (8, A | B | D), (13, B | C)).needed(Sources(6, A))
    assert not among(8, (3, B | C), (5, A | C | D), (13, B | C)).needed(Sources(6, A))
    # 13 does not hear 5
    assert among(8, (3, B | C), (5, A | C), (13, C)).needed(Sources(6, A))


def test_who_is_heard_but_does_not_hear_can_not_know_whom_to_tell():
    # 13 hears 5, who does not hear 13
    assert among(8, (3, B | C), (5, A | C), (13, B | C)).needed(Sources(6, A))


def test_a_one_way_link_costs_two_ticks():
    swarm = Swarm(4, "belief-update")

    def fate(a, b):
        return () if (a, b) in ((0, 3), (3, 0), (3, 1)) else (1,)

    for _ in range(5):
        swarm.exchange(fate)
    swarm.observe(0, 5, True)
    for _ in range(3):
        swarm.exchange(fate)
    assert swarm.alike()


def test_what_nobody_knows_the_way_of_is_passed_on():
    relaying = among(5, (3, B | C), (8, A | B))
    assert relaying.needed(Sources(-1, 0))
    assert relaying.needed(Sources(6, 0))
    assert relaying.needed(Sources(4, A))  # late


def test_who_has_not_been_heard_for_three_frames_is_no_neighbour():
    relaying = among(5, (3, B | C), (8, B))
    for tick in (8, 9):
        relaying.heard([said(3, tick - 1, B | C)])
        relaying.tell(tick)
        assert relaying.needed(Sources(tick - 1, A))  # 8 did not hear 3
    relaying.heard([said(3, 9, B | C)])
    relaying.tell(10)
    relaying.heard([said(3, 10, B | C)])
    relaying.tell(11)
    assert not relaying.needed(Sources(10, A))


def test_a_frame_says_whom_its_sender_heard_a_tick_before():
    relaying = Relaying(5, TEAM)
    relaying.tell(6)
    relaying.heard([said(3, 6, 0), said(8, 5, 0), said(99, 6, 0), said(5, 6, 0)])
    assert relaying.tell(7) == A
    relaying.heard([said(8, 7, 0)])
    relaying.heard([said(13, 8, 0)])  # early
    assert relaying.tell(8) == C
    assert relaying.tell(9) == D
    assert relaying.tell(10) == 0


@pytest.mark.parametrize("merge", ["belief-update", "counts"])
def test_where_all_hear_all_a_look_goes_out_once(merge):
    swarm = Swarm(8, merge)
    for _ in range(5):
        swarm.exchange(lambda _a, _b: (1,))
    before = swarm.map_bytes_sent
    swarm.observe(2, 5, True)
    swarm.exchange(lambda _a, _b: (1,))
    swarm.exchange(lambda _a, _b: (1,))
    assert swarm.alike()
    for _ in range(20):
        swarm.exchange(lambda _a, _b: (1,))
    assert swarm.map_bytes_sent - before == RECORD


def test_who_missed_a_look_is_told_two_frames_later_without_asking():
    swarm = Swarm(8, "belief-update")
    for _ in range(5):
        swarm.exchange(lambda _a, _b: (1,))
    before = swarm.map_bytes_sent
    swarm.observe(2, 5, True)
    swarm.exchange(lambda a, b: () if (a, b) == (2, 7) else (1,))
    for _ in range(2):
        swarm.exchange(lambda _a, _b: (1,))
        assert not swarm.alike()
    swarm.exchange(lambda _a, _b: (1,))
    assert swarm.alike()
    assert swarm.map_bytes_sent - before <= 4 * RECORD


def test_along_a_chain_a_look_takes_a_tick_a_link():
    swarm = Swarm(6, "belief-update")
    for _ in range(5):
        swarm.exchange(lambda a, b: (1,) if abs(a - b) == 1 else ())
    before = swarm.map_bytes_sent
    swarm.observe(0, 5, True)
    assert swarm.settle(lambda a, b: abs(a - b) == 1, 20) == 6
    assert swarm.map_bytes_sent - before <= 5 * RECORD + 100
