"""Laws that every merge rule keeps, and what each is for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.belief.bayes import bayes
from planners.belief.evidence import posterior
from planners.belief.fusing import Average, ModifiedOgmm, Ogmm
from planners.belief.merge import MERGE_RULES, SensorModel, unpack
from planners.grid import Grid

GRID = Grid(0.0, 0.0, 100.0, 3, 2)
SENSOR = SensorModel(0.9, 0.2)
SECOND = 1_000_000
RULES = list(MERGE_RULES.values())
SHARING = [MERGE_RULES["sensed-data"], MERGE_RULES["counts"]]

looks = st.lists(
    st.tuples(st.integers(0, 2), st.integers(0, 2), st.integers(0, 1), st.booleans()), max_size=12
)


def team(rule, script, n=3):
    """Maps of n agents that look alone: (agent, column, row, detected) a second."""
    maps = [rule.empty(GRID, 0.5, SENSOR) for _ in range(n)]
    for second, (agent, column, row, detected) in enumerate(script):
        maps[agent] = rule.observe(
            maps[agent], (column, row), detected, SENSOR, t_us=second * SECOND, agent=agent
        )
    return maps


def told(rule, belief):
    return rule.records(belief, np.arange(GRID.size))


def same(a, b):
    return (
        np.array_equal(a.probability, b.probability)
        and np.array_equal(a.stamp_us, b.stamp_us)
        and np.array_equal(a.origin, b.origin)
    )


def by_rule(rules):
    return pytest.mark.parametrize("rule", rules, ids=lambda rule: rule.name)


def test_names_and_codes_are_stable():
    assert {name: rule.code for name, rule in MERGE_RULES.items()} == {
        "belief-update": 1,
        "uncoordinated": 2,
        "average": 3,
        "ogmm": 4,
        "modified-ogmm": 5,
        "sensed-data": 6,
        "counts": 7,
    }


@by_rule(RULES)
def test_records_round_trip_as_bytes_and_name_a_cell_first(rule):
    belief = team(rule, [(0, 1, 1, True), (0, 2, 0, False)])[0]
    sent = told(rule, belief)
    assert rule.record.names[0] == "cell"
    assert sent["cell"].tolist() == [3, 4]
    assert np.array_equal(unpack(rule, sent.tobytes()), sent)
    assert rule.valid(belief, sent).all()
    assert len(rule.records(belief, [0])) == 0


@by_rule(RULES)
@given(script=looks)
@settings(max_examples=20)
def test_merging_changes_no_argument_and_says_what_changed(rule, script):
    a, b, _ = team(rule, script)
    before = (a.probability.copy(), a.stamp_us.copy(), told(rule, a))
    after, changed = rule.merge(a, told(rule, b))
    assert np.array_equal(a.probability, before[0])
    assert np.array_equal(a.stamp_us, before[1])
    assert np.array_equal(told(rule, a), before[2])
    quiet = np.ones(GRID.size, bool)
    quiet[changed] = False
    assert np.array_equal(after.probability.reshape(-1)[quiet], before[0].reshape(-1)[quiet])
    assert np.array_equal(changed, np.unique(changed))


@by_rule(RULES)
@given(script=looks)
@settings(max_examples=20)
def test_an_onlooker_sees_all_in_any_order(rule, script):
    maps = team(rule, script)
    unions = []
    for order in ((0, 1, 2), (2, 0, 1)):
        union = rule.onlooker.empty(GRID, 0.5, SENSOR)
        for agent in order:
            union, _ = rule.onlooker.merge(union, told(rule, maps[agent]))
        unions.append(union)
    assert same(*unions)
    assert np.array_equal(unions[0].seen, np.any([belief.seen for belief in maps], axis=0))


@by_rule(RULES)
@given(data=st.binary(max_size=200))
@settings(max_examples=40)
def test_any_bytes_are_survived(rule, data):
    records = unpack(rule, data[: len(data) // rule.record.itemsize * rule.record.itemsize])
    belief, _ = rule.merge(rule.empty(GRID, 0.5, SENSOR), records)
    assert ((belief.probability > 0.0) & (belief.probability < 1.0)).all()
    assert (belief.stamp_us >= -1).all()


@by_rule(SHARING)
@given(script=looks, route=st.lists(st.tuples(st.integers(0, 2), st.integers(0, 2)), max_size=8))
@settings(max_examples=60)
def test_no_reading_counts_twice_by_any_route(rule, script, route):
    maps = team(rule, script)
    for sender, receiver in route:  # any gossip, lossy and with repeats
        maps[receiver], _ = rule.merge(maps[receiver], told(rule, maps[sender]))
    union = rule.empty(GRID, 0.5, SENSOR)
    for belief in maps:
        union, _ = rule.merge(union, told(rule, belief))
    expected = np.full(GRID.shape, 0.5)
    for _, column, row, detected in script:
        expected[column, row] = bayes(expected[column, row], detected, SENSOR.p, SENSOR.q)
    assert np.allclose(union.probability, np.clip(expected, 1e-7, 1 - 1e-7), atol=1e-6)


@by_rule([*SHARING, MERGE_RULES["belief-update"]])
@given(script=looks)
@settings(max_examples=40)
def test_merging_is_idempotent_commutative_and_associative(rule, script):
    a, b, c = team(rule, script)
    twice, changed = rule.merge(a, told(rule, a))
    assert same(twice, a)
    assert not len(changed)
    ab, _ = rule.merge(a, told(rule, b))
    ba, _ = rule.merge(b, told(rule, a))
    bc, _ = rule.merge(b, told(rule, c))
    assert same(ab, ba)
    assert same(rule.merge(ab, told(rule, c))[0], rule.merge(a, told(rule, bc))[0])


@by_rule(SHARING)
def test_an_agent_that_restarts_counts_on(rule):
    first = team(rule, [(0, 1, 1, True), (0, 1, 1, True)])[0]
    peer, _ = rule.merge(rule.empty(GRID, 0.5, SENSOR), told(rule, first))
    reborn = rule.empty(GRID, 0.5, SENSOR)
    reborn = rule.observe(reborn, (1, 1), True, SENSOR, t_us=9 * SECOND, agent=0)
    peer, _ = rule.merge(peer, told(rule, reborn))
    reborn, _ = rule.merge(reborn, told(rule, peer))
    three = posterior(0.5, 3, 0, SENSOR)
    assert peer.probability[1, 1] == three
    assert reborn.probability[1, 1] == three
    reborn = rule.observe(reborn, (1, 1), False, SENSOR, t_us=10 * SECOND, agent=0)
    assert reborn.probability[1, 1] == posterior(0.5, 3, 1, SENSOR)


def test_counts_of_the_same_looks_take_bytes_that_do_not_grow():
    counts, history = MERGE_RULES["counts"], MERGE_RULES["sensed-data"]
    script = [(0, 1, 1, True)] * 20
    assert told(counts, team(counts, script)[0]).nbytes == counts.record.itemsize
    assert told(history, team(history, script)[0]).nbytes == 20 * history.record.itemsize


@by_rule(SHARING)
def test_maps_of_another_rule_are_refused(rule):
    with pytest.raises(TypeError, match="its own map"):
        rule.records(MERGE_RULES["average"].empty(GRID, 0.5), [0])


def test_readings_come_before_any_own_one_are_judged_by_the_team_sensor():
    rule = MERGE_RULES["counts"]
    teller = team(rule, [(1, 0, 0, True)])[1]
    heard, _ = rule.merge(rule.empty(GRID, 0.3, SENSOR), told(rule, teller))
    assert heard.probability[0, 0] == pytest.approx(float(bayes(0.3, True, 0.9, 0.2)), abs=1e-7)


def test_liu_updates_hits_then_misses():
    liu = SensorModel(0.6, 0.2, "liu")
    want = 0.75 * (0.4 / 0.8)
    assert posterior(0.5, 1, 1, liu) == pytest.approx(want, abs=1e-6)


def pair(rule, mine, theirs):
    """Two agents at one cell: their readings, and what the first holds after hearing the second."""
    script = [(0, 1, 1, detected) for detected in mine] + [(1, 1, 1, d) for d in theirs]
    a, b, _ = team(rule, script)
    after, _ = rule.merge(a, told(rule, b))
    return a.probability[1, 1], b.probability[1, 1], after.probability[1, 1]


def test_average_is_the_mean_or_takes_over_the_unknown():
    a, b, after = pair(Average(), [True], [False])
    assert after == pytest.approx((a + b) / 2, abs=1e-7)
    _, b, after = pair(Average(), [], [True])
    assert after == pytest.approx(b, abs=1e-7)


def test_ogmm_multiplies_odds():
    _, _, after = pair(Ogmm(), [True], [True])
    assert after == pytest.approx(0.81 / (0.81 + 0.04), abs=1e-6)


def test_modified_ogmm_weighs_both():
    a, b, after = pair(ModifiedOgmm(), [True], [True])
    assert after == pytest.approx(0.7 * (a + b) / 2 + 0.3 * 0.81 / 0.85, abs=1e-6)
    _, b, after = pair(ModifiedOgmm(), [], [True])
    assert after == pytest.approx(0.7 * (0.5 + b) / 2 + 0.3 * b, abs=1e-6)
    _, b, after = pair(ModifiedOgmm(untouched_counts=False), [], [True])
    assert after == pytest.approx(b, abs=1e-6)


def test_who_merges_and_whose_values_count_are_choices():
    older = told(Average(), team(Average(), [(1, 1, 1, True)])[1])
    mine = Average().empty(GRID, 0.5)
    mine = Average().observe(mine, (1, 1), False, SENSOR, t_us=5 * SECOND, agent=0)
    assert Average().merge(mine, older)[0] is mine
    both, _ = Average(newest_keeps=False).merge(mine, older)
    assert both.probability[1, 1] > mine.probability[1, 1]
    assert both.stamp_us[1, 1] == 5 * SECOND

    newer = told(Average(), Average().observe(mine, (1, 1), True, SENSOR, t_us=9, agent=2))
    twice = np.concatenate([newer, newer])
    start = team(Average(), [(0, 1, 1, False)])[0]
    one, _ = Average().merge(start, twice)
    two, _ = Average(distinct=False).merge(start, twice)
    p, q = start.probability[1, 1], float(newer["probability"][0])
    assert one.probability[1, 1] == pytest.approx((p + q) / 2, abs=1e-6)
    assert two.probability[1, 1] == pytest.approx((p + 2 * q) / 3, abs=1e-6)


def test_uncoordinated_agents_listen_to_nobody():
    rule = MERGE_RULES["uncoordinated"]
    a, b, _ = team(rule, [(1, 1, 1, True)])
    assert rule.merge(a, told(rule, b))[0] is a
