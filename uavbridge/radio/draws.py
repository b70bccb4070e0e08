"""Random numbers that depend on who sends what to whom, and on nothing else.

A draw is a hash of (seed, purpose, sender, receiver, tick). So a decision is the same in
whichever order, process or experiment it is asked for, and however often.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
import numpy.typing as npt

from planners.hashing import mixed
from planners.types import F64, I64, Bools

_BLOCK = 32  # ticks of a chain drawn at once


class Purpose(IntEnum):
    """What a draw decides; draws of different purposes are independent."""

    LOSS = 1
    STATE = 2  # of the Gilbert-Elliott chain
    BURST_LOSS = 3
    JITTER = 4


def draw(
    seed: npt.ArrayLike,
    purpose: Purpose,
    sender: npt.ArrayLike,
    receiver: npt.ArrayLike,
    tick: npt.ArrayLike,
) -> F64:
    """Uniform in [0, 1), of seed, sender, receiver and tick (...), broadcast against each other."""
    key = mixed(seed)
    for part in (np.array([purpose.value]), sender, receiver, tick):
        key = mixed(key ^ np.asarray(part).astype(np.uint64))
    return np.asarray((key >> np.uint64(11)) * 2.0**-53)


def in_burst(seed: int, sender: I64, receiver: I64, tick: I64, enter: F64, leave: F64) -> Bools:
    """Whether links are in their bad state: Gilbert 1960, Elliott 1963.

    A link is good or bad from tick to tick; good turns bad with probability ``enter``, bad
    turns good with ``leave``, and at tick 0 it is bad with enter / (enter + leave), as in the
    long run. Both turns are read off one draw u a tick: bad if u < enter, good if
    u >= 1 - leave, else as before. So the state of any tick follows from the last draw that
    decided, and no chain has to be followed from the start.

    Args:
        seed: of the mission.
        sender: (m,) ids.
        receiver: (m,) ids.
        tick: (m,), not negative.
        enter: (m,) probabilities; enter + leave <= 1.
        leave: (m,) probabilities.

    Returns:
        (m,) bools.
    """
    bad = np.zeros(len(tick), np.bool_)
    open_ = np.flatnonzero(enter > 0.0)
    last = tick[open_]
    while len(open_):
        steps = last[:, None] - np.arange(_BLOCK)
        known = np.maximum(steps, 0)
        u = draw(seed, Purpose.STATE, sender[open_, None], receiver[open_, None], known)
        worse, better = enter[open_, None], leave[open_, None]
        falls = u < np.where(steps <= 0, worse / (worse + better), worse)
        decided = falls | (u >= 1.0 - better) | (steps <= 0)
        first = decided.argmax(axis=1)
        done = decided.any(axis=1)
        rows = np.arange(len(open_))
        bad[open_[done]] = falls[rows, first][done]
        open_, last = open_[~done], last[~done] - _BLOCK
    return bad
