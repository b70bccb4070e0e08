"""Probability from all readings of a cell at once, and maps that rest on readings.

Khan, Yanmaz and Rinner 2014, "Information merging in multi-UAV cooperative
search", section IV-B.4 (sensed data sharing) and Eq. (11): Bayes' rule, Eq. (1),
commutes, so that only the numbers of positive and negative readings matter.

| symbol | name |
| --- | --- |
| P_0 | ``prior`` |
| m, observations 1 and 0 | ``positive``, ``negative`` |
| p, q | ``SensorModel.p``, ``SensorModel.q`` |

DEVIATION: Liu's update does not commute. With it, hits are counted before misses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from planners.belief.maps import FLOOR, BeliefMap, SensorModel, stored
from planners.types import F64


@dataclass(frozen=True, slots=True, eq=False)
class EvidenceMap(BeliefMap):
    """A map whose probabilities follow from readings."""

    prior: F64  # (columns, rows)
    sensor: SensorModel  # that the readings come from


def posterior(
    prior: npt.ArrayLike, positive: npt.ArrayLike, negative: npt.ArrayLike, sensor: SensorModel
) -> F64:
    """Probabilities (...) as a map holds them, after so many readings: Eq. (11) with misses."""
    p, q = sensor.p, sensor.q
    before = np.clip(np.asarray(prior, dtype=np.float64), FLOOR, 1.0 - FLOOR)
    hits, misses = np.asarray(positive, np.float64), np.asarray(negative, np.float64)
    odds = np.log(before / (1.0 - before)) + hits * np.log(p / q)
    if sensor.update == "bayes":
        odds = odds + misses * np.log((1.0 - p) / (1.0 - q))
        return stored(1.0 / (1.0 + np.exp(np.clip(-odds, -700.0, 700.0))))
    after_hits = 1.0 / (1.0 + np.exp(np.clip(-odds, -700.0, 700.0)))
    return stored(after_hits * ((1.0 - p) / (1.0 - q)) ** misses)
