"""Where a UAV steps next in detection and revisit: Shao 2020, Algorithm 1, Eqs. (9)-(11).

Kernels over leading axes (...): none for one UAV, or runs and UAVs.

| symbol | name |
| --- | --- |
| j, theta | one of eight headings, and the change of heading that it takes |
| tau_j, eps_j, sigma_j | sector means, weighted and summed: ``means`` |
| eta_ijk | ``desirability`` |
| P_ij | the value of ``chances``, not normalised |

DEVIATION: the base of Eq. (9) is negative near obstacles (lambda_Th = -0.3); it is held above
1e-6.

DEVIATION: Eq. (9) is a probability and Algorithm 1 selects its maximum. The information group
does (ties at random); the random group draws from eta, as the maximum of eta is always straight on.

DEVIATION: with five orientations and none backwards a dead end has no legal move: then any free
neighbour will do.

DEVIATION: "go there" (lines 3-5) replaces the choice, holds for targets that are new or due only,
and is one lattice step at a time along the shortest way round the obstacles in sight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.pheromone.sectors import HEADINGS, STEPS
from planners.types import F64, I64, Bools

DRAWS = 2  # uniform numbers of a decision: which group, which direction
STAY = -1
_LEAST = 1e-6
_ALIKE = 1e-9  # shares of the maximum; less is rounding
_TURN = np.array((1 / 4, 5 / 24, 1 / 6, 0.0, 0.0, 0.0, 1 / 6, 5 / 24))  # Eq. (10), by (j - i) mod 8
_LENGTH = np.array((1.4, 1.0) * 4)  # Eq. (11), by heading
_FAR = np.inf


@dataclass(frozen=True, slots=True)
class DetectRule:
    """What Eq. (9) leaves open: the paper gives none of the three."""

    alpha: float = 1.0
    beta: float = 1.0
    random_share: float = 0.2  # chance of a UAV to be in the random group, in each step


def desirability(heading: I64) -> F64:
    """Costs eta (..., 8) of stepping along each heading from the own one (...), Eqs. (10)-(11)."""
    change = (np.arange(HEADINGS) - heading[..., None]) % HEADINGS
    return np.asarray(_TURN[change] * _LENGTH)


def chances(means: F64, heading: I64, free: Bools, rule: DetectRule) -> F64:
    """P (..., 8) of Eq. (9), without its denominator; 0 where a step is not legal.

    Args:
        means: (..., 8) weighted sums of the sector means.
        heading: (...) now.
        free: (..., 8) neighbours that can be entered.
        rule: alpha and beta.
    """
    eta = desirability(heading)
    attraction = np.maximum(means, _LEAST) ** rule.alpha
    return np.where(free, attraction * eta**rule.beta * (eta > 0.0), 0.0)


def decide(means: F64, heading: I64, free: Bools, goal: I64, draws: F64, rule: DetectRule) -> I64:
    """The next heading (...) of each UAV, ``STAY`` where it is walled in.

    Args:
        means: (..., 8) weighted sums of the sector means.
        heading: (...) now.
        free: (..., 8) neighbours that can be entered.
        goal: (...) heading towards a target in sight, or ``STAY``: none.
        draws: (..., 2) uniform in [0, 1).
        rule: the free parameters.
    """
    wandering = draws[..., 0] < rule.random_share
    eta = np.where(free, desirability(heading), 0.0)
    legal: Bools = np.asarray((eta > 0.0).any(axis=-1, keepdims=True))
    eta = np.where(legal, eta, free * 1.0)  # a dead end: turn round
    weighed = np.where(legal, chances(means, heading, free, rule), free * 1.0)
    best = weighed >= weighed.max(axis=-1, keepdims=True) * (1.0 - _ALIKE)
    weight = np.where(wandering[..., None], eta, best & free)
    chosen = _drawn(weight, draws[..., 1])
    return np.asarray(np.where(goal >= 0, goal, chosen))


def stepped(cells: I64, heading: I64) -> I64:
    """Cells (..., 2) after a step along headings (...); ``STAY`` stays."""
    return np.asarray(cells + np.where(heading[..., None] >= 0, STEPS[heading], 0))


def approach(blocked: Bools, target: I64, heading: I64) -> I64:
    """Headings (k,) of the first step of a shortest way to a target in sight.

    Args:
        blocked: (k, w, w) cells around each UAV that it can not enter, itself in the middle;
            w is odd.
        target: (k, 2) offset of its target, inside the window and not (0, 0).
        heading: (k,) now; of equally short ways the one with the least turn.

    Returns:
        Headings, ``STAY`` where no legal step leads there. Steps backwards count as legal only
        where no other step is.
    """
    middle = blocked.shape[-1] // 2
    rows = np.arange(len(blocked))
    way = np.full(blocked.shape, _FAR)
    way[rows, target[:, 0] + middle, target[:, 1] + middle] = 0.0
    for _ in range(3 * middle):
        nearer = _relaxed(way, blocked)
        if np.array_equal(nearer, way):
            break
        way = nearer
    ring = STEPS + middle
    ahead = way[:, ring[:, 0], ring[:, 1]]
    turn = (np.arange(HEADINGS) - heading[:, None]) % HEADINGS
    turn = np.minimum(turn, HEADINGS - turn)
    open_ = np.isfinite(ahead)
    forward = open_ & (turn <= 2)
    legal = np.where(forward.any(axis=1)[:, None], forward, open_)
    cost = np.where(legal, ahead + 1e-3 * turn, _FAR)
    return np.asarray(np.where(legal.any(axis=1), cost.argmin(axis=1), STAY))


def _relaxed(way: F64, blocked: Bools) -> F64:
    """Shortest ways (k, w, w) with one more step."""
    side = way.shape[-1]
    wide = np.full((len(way), side + 2, side + 2), _FAR)
    wide[:, 1:-1, 1:-1] = way
    nearer = way
    for column, row in STEPS.tolist():
        length = np.hypot(column, row)
        shifted = wide[:, 1 + column : 1 + column + side, 1 + row : 1 + row + side]
        nearer = np.minimum(nearer, shifted + length)
    return np.where(blocked, _FAR, nearer)


def _drawn(weight: F64, draw: F64) -> I64:
    """Headings (...) drawn by weights (..., 8); ``STAY`` where all are 0."""
    total = np.cumsum(weight, axis=-1)
    place = (total <= (draw * total[..., -1])[..., None]).sum(axis=-1)
    return np.asarray(np.where(total[..., -1] > 0.0, np.minimum(place, HEADINGS - 1), STAY))
