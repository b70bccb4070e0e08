"""The point-mass world of the tests merges maps as the rule does."""

import numpy as np

from planners.belief.merge import MERGE_RULES, BeliefMap
from planners.grid import Grid
from tests.planners.ideal import exchange_maps

GRID = Grid(0.0, 0.0, 10.0, 3, 4)
RULE = MERGE_RULES["belief-update"]


def test_exchange_equals_the_belief_update_rule():
    rng = np.random.default_rng(4)
    position = np.array([[0.0, 0.0, 50.0], [30.0, 0.0, 50.0], [70.0, 0.0, 50.0]])
    stamp = rng.integers(-1, 4, (3, GRID.size))
    stamp = np.where(stamp < 0, -1, stamp * 64 + rng.integers(0, 3, (3, GRID.size)))
    told = rng.random(64 * 5 + 1).astype(np.float32).astype(float)  # one value a stamp and origin
    probability = np.where(stamp < 0, 0.5, told[stamp])

    maps = [
        BeliefMap(
            probability[i].reshape(GRID.shape).copy(),
            np.where(stamp[i] < 0, -1, stamp[i] // 64).reshape(GRID.shape),
            np.where(stamp[i] < 0, -1, stamp[i] % 64).astype(np.int32).reshape(GRID.shape),
        )
        for i in range(3)
    ]
    everything = [RULE.records(belief, np.arange(GRID.size)) for belief in maps]
    merged = list(maps)
    for i, j in ((0, 1), (1, 0), (1, 2), (2, 1)):
        merged[i], _ = RULE.merge(merged[i], everything[j])

    exchange_maps(position, probability, stamp, 50.0)
    for i, belief in enumerate(merged):
        assert np.array_equal(belief.probability.reshape(-1), probability[i])
