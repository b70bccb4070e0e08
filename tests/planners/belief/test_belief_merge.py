"""Laws of the belief-update rule."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.belief.merge import MERGE_RULES, SensorModel, unpack
from planners.grid import Grid

GRID = Grid(0.0, 0.0, 100.0, 3, 2)
RULE = MERGE_RULES["belief-update"]
SENSOR = SensorModel()

record = st.tuples(
    st.integers(0, GRID.size - 1),
    st.integers(0, 3),
    st.floats(0.0, 1.0, width=32),
    st.integers(0, 4),
)
batches = st.lists(record, max_size=8)


def rows(items):
    return np.array(items, RULE.record)


def empty():
    return RULE.empty(GRID, 0.5)


def same(a, b):
    return (
        np.array_equal(a.probability, b.probability)
        and np.array_equal(a.stamp_us, b.stamp_us)
        and np.array_equal(a.origin, b.origin)
    )


def merged(*parts):
    belief = empty()
    for part in parts:
        belief, _ = RULE.merge(belief, rows(part))
    return belief


@given(batches, batches)
def test_merging_is_commutative(a, b):
    assert same(merged(a, b), merged(b, a))


@given(batches, batches, batches)
def test_merging_is_associative(a, b, c):
    halves, _ = RULE.merge(merged(a), RULE.records(merged(b, c), np.arange(GRID.size)))
    assert same(halves, merged(a, b, c))


@given(batches)
def test_merging_is_idempotent_and_says_what_changed(a):
    once = merged(a)
    twice, changed = RULE.merge(once, rows(a))
    assert twice is once
    assert len(changed) == 0
    _, changed = RULE.merge(empty(), rows(a))
    assert changed.tolist() == sorted({cell for cell, *_ in a})


@given(batches, st.randoms())
def test_order_within_a_batch_does_not_matter(a, shuffler):
    b = list(a)
    shuffler.shuffle(b)
    assert same(merged(a), merged(b))


def test_nonsense_is_ignored_and_can_be_counted():
    bad = rows(
        [
            (GRID.size, 0, 0.5, 1),
            (2**32 - 1, 0, 0.5, 1),
            (0, 0, np.nan, 1),
            (0, 0, -0.1, 1),
            (0, 0, 1.1, 1),
            (0, 0, 0.5, -1),
            (0, 0, 0.5, 2**63 - 1),
        ]
    )
    assert not RULE.valid(empty(), bad).any()
    _, changed = RULE.merge(empty(), bad)
    assert len(changed) == 0


def test_stamps_from_the_future_can_be_refused():
    stamps = (10, 1_010, 1_011)
    records = rows([(0, 0, 0.5, stamp) for stamp in stamps])
    assert RULE.valid(empty(), records, 10).tolist() == [True, True, False]


def test_own_reading_after_a_merged_one_builds_on_it_and_wins():
    theirs = RULE.observe(empty(), (1, 1), True, SENSOR, t_us=100, agent=2)
    mine, _ = RULE.merge(empty(), RULE.records(theirs, [3]))
    late = RULE.observe(mine, (1, 1), True, SENSOR, t_us=50, agent=1)
    assert late.stamp_us[1, 1] == 101
    back, changed = RULE.merge(theirs, RULE.records(late, [3]))
    assert changed.tolist() == [3]
    assert back.probability[1, 1] == pytest.approx(0.9**2 / (0.9**2 + 0.05**2), abs=1e-7)


def test_observe_leaves_its_argument_alone():
    before = empty()
    after = RULE.observe(before, (0, 1), True, SENSOR, t_us=7, agent=4)
    assert same(before, empty())
    assert after.seen.sum() == 1
    assert after.origin[0, 1] == 4


def test_belief_can_always_turn_round():
    belief = empty()
    for t in range(40):
        belief = RULE.observe(belief, (0, 0), True, SENSOR, t_us=t, agent=0)
    for t in range(40, 60):
        belief = RULE.observe(belief, (0, 0), False, SENSOR, t_us=t, agent=0)
    assert belief.probability[0, 0] < 0.01


def test_records_of_unseen_cells_are_not_sent_and_bytes_round_trip():
    belief = RULE.observe(empty(), (2, 0), False, SENSOR, t_us=7, agent=4)
    sent = RULE.records(belief, np.arange(GRID.size))
    assert sent["cell"].tolist() == [4]
    assert unpack(RULE, sent.tobytes()) == sent
    assert unpack(RULE, sent.tobytes()[:-1]) is None


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"p": 1.0}, "p must"),
        ({"q": 0.0}, "q must"),
        ({"update": "x"}, "bayes, liu"),
        ({"p": 0.1, "q": 0.2, "update": "liu"}, "p >= q"),
    ],
)
def test_a_sensor_model_must_make_sense(values, word):
    with pytest.raises(ValueError, match=word):
        SensorModel(**values)


def test_the_map_starts_at_the_prior():
    prior = np.linspace(0.1, 0.6, 6).reshape(3, 2)
    assert np.allclose(RULE.empty(GRID, prior).probability, prior)
    with pytest.raises(ValueError, match="prior"):
        RULE.empty(GRID, 1.5)
