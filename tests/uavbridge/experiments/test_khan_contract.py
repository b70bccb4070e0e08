"""The batched run equals single maps behind the merge rules' seam, step by step."""

from dataclasses import replace

import numpy as np
import pytest

from planners.belief.counts import Counts
from uavbridge.experiments.khan.choices import RULES, KhanParams, rules
from uavbridge.experiments.khan.teams import team_of
from uavbridge.experiments.khan.world import (
    STEP_US,
    Luck,
    entries,
    loop_of,
    reach_of,
    search,
    turns,
    within,
)

SMALL = KhanParams(columns=4, rows=3, target_column=2, target_row=1, steps_most=400)
RUNS, STEPS = 3, 32


class Alone:
    """One run: a map for each UAV, moved on by the rule's own methods."""

    def __init__(self, rule, choices, uavs):
        self.rule, self.choices = rule, choices
        grid = choices.grid
        self.everything = np.arange(grid.size)
        self.maps = [rule.empty(grid, 0.5, choices.sensor) for _ in range(uavs)]

    def step(self, cells, detected, reach, step):
        for who in turns(len(cells), self.choices):
            for i in who:
                self.maps[i] = self.rule.observe(
                    self.maps[i],
                    divmod(int(cells[i]), self.choices.rows),
                    bool(detected[i]),
                    self.choices.sensor,
                    t_us=step * STEP_US,
                    agent=int(i),
                )
            before = list(self.maps)
            for i in range(len(cells)):
                heard = [
                    self.told(before, i, j, cells, reach, who, step)
                    for j in range(len(cells))
                    if reach[i, j]
                ]
                if heard:
                    self.maps[i], _ = self.rule.merge(before[i], np.concatenate(heard))

    def told(self, before, i, j, cells, reach, who, step):
        """What UAV j sends that i hears."""
        values = "probability" in self.rule.record.names
        if values and self.choices.exchange == "contested":
            spoken = [cells[k] for k in who if k == i or reach[i, k]]
            return self.rule.records(before[j], np.unique(spoken))
        if j not in who:
            return self.rule.records(before[j], [])
        if values and self.choices.exchange == "current":
            return self.rule.records(before[j], [cells[j]])
        sent = self.rule.records(before[j], self.everything)
        if not values and self.choices.history == "current":
            sent = sent[(sent["stamp_us"] == step * STEP_US) & (sent["origin"] == j)]
        return sent

    @property
    def probability(self):
        return np.array([belief.probability.reshape(-1) for belief in self.maps])


def script(choices, uavs, range_cells, seeds):
    """Cells, readings and reach of every step."""
    luck, loop = Luck(seeds, uavs, choices), loop_of(choices)
    entry = entries(loop, luck.start, choices)
    near = within(range_cells, choices)
    for step in range(STEPS):
        cells = loop[(entry + step) % len(loop)]
        chance = np.where(cells == choices.target, choices.p, choices.q)
        yield cells, luck.of(step)[:, :uavs] < chance, reach_of(cells, near, choices.relay)


def check(rule_name, rule, choices, uavs, range_cells):
    seeds = np.arange(RUNS)
    team = team_of(rule_name, choices, RUNS, uavs)
    alone = [Alone(rule, choices, uavs) for _ in range(RUNS)]
    talked = False
    for step, (cells, detected, reach) in enumerate(script(choices, uavs, range_cells, seeds)):
        for who in turns(uavs, choices):
            team.observe(cells, detected, who, step * STEP_US)
            team.exchange(reach, cells, who)
        for run, single in enumerate(alone):
            single.step(cells[run], detected[run], reach[run], step)
            assert np.array_equal(team.probability[run], single.probability), (step, run)
        talked |= reach.any()
    assert talked


VALUES = [
    {},
    {"exchange": "contested"},
    {"exchange": "whole"},
    {"exchange": "whole", "observer": "merges", "counted": "all"},
    {"exchange": "contested", "observer": "merges", "order": "in-turn"},
    {"counted": "all", "relay": True, "sweep": "closed-tour", "untouched": "overwritten"},
    {"order": "in-turn"},
]


def name_of(changes):
    return "-".join(str(value) for value in changes.values()) or "defaults"


@pytest.mark.parametrize("changes", VALUES, ids=name_of)
@pytest.mark.parametrize("rule", [rule for rule in RULES if rule != "SDS"])
def test_values_merge_alike(rule, changes):
    choices = replace(SMALL, **changes)
    check(rule, rules(choices)[rule], choices, 4, 1.5)


@pytest.mark.parametrize(
    "changes",
    [{}, {"history": "current"}, {"relay": True}, {"order": "in-turn", "phase": "random"}],
    ids=name_of,
)
def test_readings_are_shared_alike(changes):
    choices = replace(SMALL, **changes)
    check("SDS", rules(choices)["SDS"], choices, 4, 1.5)


@pytest.mark.parametrize("changes", [{}, {"relay": True, "order": "in-turn"}], ids=name_of)
def test_conflict_free_counts_are_sensed_data_sharing_on_a_perfect_radio(changes):
    choices = replace(SMALL, **changes)
    check("SDS", Counts(), choices, 4, 1.5)


@pytest.mark.parametrize("rule", RULES)
def test_whole_searches_end_alike(rule):
    seeds, uavs = np.arange(6), 3
    fates = search(team_of(rule, SMALL, 6, uavs), SMALL, uavs, 1.5, seeds)
    alone = [Alone(rules(SMALL)[rule], SMALL, uavs) for _ in seeds]
    luck, loop = Luck(seeds, uavs, SMALL), loop_of(SMALL)
    entry = entries(loop, luck.start, SMALL)
    near = within(1.5, SMALL)
    ends = {}
    for step in range(SMALL.steps_most):
        draws = luck.of(step)
        for run in set(range(6)) - set(ends):
            cells = loop[(entry[run] + step) % len(loop)]
            detected = draws[run, :uavs] < np.where(cells == SMALL.target, SMALL.p, SMALL.q)
            alone[run].step(cells, detected, reach_of(cells[None], near, False)[0], step)
            found = np.argwhere(alone[run].probability >= SMALL.threshold)
            if len(found):
                ends[run] = (step + 1, found[0][1])
    for run, (steps, cell) in ends.items():
        assert (fates.steps[run], fates.cell[run]) == (steps, cell)
        assert fates.wrong[run] == (cell != SMALL.target)
    assert len(ends) == 6
