"""What an agent holds of the area, and what it believes of its sensor.

Khan, Yanmaz and Rinner 2014, "Information merging in multi-UAV cooperative
search", sections III and IV.

| symbol | name |
| --- | --- |
| P_{i,c} | ``BeliefMap.probability[c]`` of agent i |
| time stamp | ``BeliefMap.stamp_us`` |
| p, q | ``SensorModel.p``, ``SensorModel.q`` |

DEVIATION: stored probabilities are rounded to single precision, as they travel,
and kept within [1e-7, 1 - 1e-7]: at exactly 0 or 1 Eq. (1) cannot move any more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from planners.belief.bayes import UPDATES
from planners.grid import Grid
from planners.types import F64, I64, Bools

FLOOR = 1e-7  # probabilities stay this far from 0 and 1


@dataclass(frozen=True, slots=True)
class SensorModel:
    """What the agents believe of their payload sensor.

    Raises:
        ValueError: p or q is not strictly between 0 and 1, the update is not known,
            or p < q with Liu's update (probabilities would leave [0, 1]).
    """

    p: float = 0.9  # P(positive reading, target in the cell)
    q: float = 0.05  # P(positive reading, no target in the cell)
    update: str = "bayes"  # a key of planners.belief.bayes.UPDATES

    def __post_init__(self) -> None:
        for name, value in (("p", self.p), ("q", self.q)):
            if not 0.0 < value < 1.0:
                raise ValueError(f"{name} must lie strictly between 0 and 1, not {value}")
        if self.update not in UPDATES:
            raise ValueError(f"update must be one of {', '.join(UPDATES)}, not {self.update!r}")
        if self.update == "liu" and self.p < self.q:
            raise ValueError(f"update 'liu' needs p >= q, not p = {self.p}, q = {self.q}")

    def after(self, prior: npt.ArrayLike, detected: npt.ArrayLike) -> F64:
        """Probabilities (...) after one reading each."""
        return UPDATES[self.update](prior, detected, self.p, self.q)


@dataclass(frozen=True, slots=True, eq=False)
class BeliefMap:
    """One agent's map; arrays of shape (columns, rows).

    A rule that needs to remember more holds it in a subclass of its own.
    """

    probability: F64  # P(target in the cell)
    stamp_us: I64  # when it was last observed, as far as known; -1: never
    origin: npt.NDArray[np.int32]  # who observed it then; -1: nobody

    @property
    def seen(self) -> Bools:
        """(columns, rows) observed by somebody."""
        return np.asarray(self.stamp_us >= 0)

    @property
    def size(self) -> int:
        """Number of cells."""
        return int(self.probability.size)


def blank(grid: Grid, prior: npt.ArrayLike) -> BeliefMap:
    """A map of which nothing is seen; ``prior`` (columns, rows) or one number.

    Raises:
        ValueError: the prior leaves [0, 1].
    """
    value = np.broadcast_to(np.asarray(prior, dtype=np.float64), grid.shape)
    if not ((value >= 0.0) & (value <= 1.0)).all():
        raise ValueError("prior probabilities must lie in [0, 1]")
    return BeliefMap(
        stored(value), np.full(grid.shape, -1, np.int64), np.full(grid.shape, -1, np.int32)
    )


def stored(value: npt.ArrayLike) -> F64:
    """Probabilities (...) as a map holds them."""
    held = np.minimum(np.maximum(np.asarray(value, dtype=np.float64), FLOOR), 1.0 - FLOOR)
    return np.asarray(held.astype(np.float32).astype(np.float64))
