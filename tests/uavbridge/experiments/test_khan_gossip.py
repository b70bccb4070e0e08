"""Merging by a few bytes a step, over a radio that loses and delays."""

import numpy as np
import pytest

from uavbridge.experiments.khan.choices import RULES, KhanParams
from uavbridge.experiments.khan.gossip import COUNTS, gossip_of, record_bytes
from uavbridge.experiments.khan.teams import team_of
from uavbridge.experiments.khan.world import (
    STEP_US,
    Luck,
    entries,
    loop_of,
    reach_of,
    search,
    within,
)
from uavbridge.radio.draws import Purpose, draw

SMALL = KhanParams(columns=5, rows=4, target_column=2, target_row=1, steps_most=300)
RUNS, UAVS, STEPS = 5, 4, 80


def play(teams, range_cells=1.5, loss=0.0, steps=STEPS, talk_until=STEPS):
    """The same readings and contacts for all teams; yields after each step."""
    luck, loop = Luck(np.arange(RUNS), UAVS, SMALL), loop_of(SMALL)
    entry = entries(loop, luck.start, SMALL)
    near = within(range_cells, SMALL)
    who = np.arange(UAVS)
    for step in range(steps):
        cells, draws = loop[(entry + step) % len(loop)], luck.of(step)
        chance = np.where(cells == SMALL.target, SMALL.p, SMALL.q)
        reach = reach_of(cells, near, False)
        lucky = draw(np.arange(RUNS)[:, None, None], Purpose.LOSS, who, who[:, None], step)
        reach &= (lucky >= loss) & (step < talk_until)
        for team in teams:
            team.observe(cells, draws[:, :UAVS] < chance, who, step * STEP_US)
            team.exchange(reach, cells, who)
        yield step


@pytest.mark.parametrize("rule", [COUNTS, "SDS"])
def test_with_bytes_enough_it_is_sensed_data_sharing(rule):
    plain = team_of("SDS", SMALL, RUNS, UAVS)
    gossip = gossip_of(rule, SMALL, RUNS, UAVS, budget_bytes=1e6)
    for step in play([plain, gossip]):
        assert np.array_equal(plain.probability, gossip.probability), step


def test_with_bytes_enough_belief_update_sends_whole_maps():
    whole = KhanParams(**{**{f: getattr(SMALL, f) for f in SMALL.__slots__}, "exchange": "whole"})
    plain = team_of("BU", whole, RUNS, UAVS)
    gossip = gossip_of("BU", SMALL, RUNS, UAVS, budget_bytes=1e6)
    for step in play([plain, gossip]):
        assert np.array_equal(plain.probability, gossip.probability), step


@pytest.mark.parametrize("rule", [COUNTS, "SDS"])
def test_whatever_is_lost_or_late_evidence_is_never_doubled(rule):
    """Nobody is ever surer than the one who knows every reading, and in the end all are as sure."""
    knows_all = team_of("SDS", SMALL, RUNS, UAVS)
    lossy = gossip_of(rule, SMALL, RUNS, UAVS, budget_bytes=200, delay=3)
    for _ in play([lossy], range_cells=99, loss=0.5, steps=60):
        pass
    for _ in play([knows_all], range_cells=99, steps=60):
        pass
    full, part = knows_all._hits + knows_all._misses, lossy._store._hits + lossy._store._misses
    assert (part <= full).all()
    assert (part < full).any()
    reach = np.broadcast_to(~np.eye(UAVS, dtype=bool), (RUNS, UAVS, UAVS))
    for _ in range(200):
        lossy.exchange(reach, None, None)
    assert np.array_equal(lossy._store._hits, knows_all._hits)
    assert np.array_equal(lossy.probability, knows_all.probability)


@pytest.mark.parametrize("rule", [*RULES[1:], COUNTS])
def test_the_budget_is_kept(rule):
    team = gossip_of(rule, SMALL, RUNS, UAVS, budget_bytes=25.0)
    for step in play([team]):
        assert (team.bytes_sent <= 25.0 * (step + 1) * UAVS).all()
    assert (team.bytes_sent > 0.8 * 25.0 * STEPS * UAVS).all()
    assert (team.bytes_sent % record_bytes(rule, SMALL) == 0).all()


@pytest.mark.parametrize("rule", [*RULES, COUNTS])
def test_runs_do_not_depend_on_their_company(rule):
    def steps(seeds):
        team = gossip_of(rule, SMALL, len(seeds), 3, budget_bytes=30.0, delay=2)
        fates = search(team, SMALL, 3, 2.0, seeds, loss=0.3)
        return list(zip(fates.steps, fates.cell, fates.bytes_sent, strict=True))

    together = steps(np.arange(8))
    assert steps(np.arange(3)) + steps(np.arange(3, 8)) == together
