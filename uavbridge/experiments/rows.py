"""Rows of results: one metric of one case, over its runs, beside the paper's number."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from planners.types import F64
from uavbridge.experiments.cases import READING, Axis, Case, Samples, Value
from uavbridge.experiments.printed import Printed


@dataclass(frozen=True, slots=True)
class Row:
    """One metric of one case.

    ``n`` counts the runs that have a value: a run that never reached what the metric tells
    is left out of all the figures. None where a figure cannot be told.
    """

    case: dict[str, Value]  # exactly the keys of the experiment's cases
    metric: str
    paper: float | None
    mean: float | None
    se: float | None
    median: float | None
    q25: float | None
    q75: float | None
    n: int
    reading: str | None = None

    def as_data(self) -> dict[str, Any]:
        """Plain values; ``reading`` only where there is one."""
        data: dict[str, Any] = {
            "case": dict(self.case),
            "metric": self.metric,
            "paper": self.paper,
            "mean": self.mean,
            "se": self.se,
            "median": self.median,
            "q25": self.q25,
            "q75": self.q75,
            "n": self.n,
        }
        return data if self.reading is None else {**data, READING: self.reading}


def of_samples(case: Case, samples: Samples, printed: Printed, axis: Axis | None) -> Iterator[Row]:
    """Rows of one case; of a curve, one a point, with the axis among the case's keys.

    A curve's metric may end in "@" and the axis' name, to stand beside a number of that name.
    """
    for metric, values in samples.items():
        if values.ndim == 1:
            yield of_values(case, metric, values, printed)
            continue
        if axis is None or values.shape[1] != len(axis.values):
            raise ValueError(f"metric {metric}: the experiment has no axis of its length")
        for place, value in enumerate(axis.values):
            name = metric.removesuffix(f"@{axis.name}")
            yield of_values({**case, axis.name: value}, name, values[:, place], printed)


def of_values(case: Case, metric: str, values: F64, printed: Printed) -> Row:
    """The row of one metric from its runs (k,), NaN for those without a value."""
    known = np.asarray(values, dtype=np.float64)
    known = known[np.isfinite(known)]
    n = int(known.size)
    if not n:
        return make(case, metric, printed, None, None, 0)
    q25, median, q75 = (float(part) for part in np.quantile(known, (0.25, 0.5, 0.75)))
    alike = bool((known == known[0]).all())  # rounding would leave a deviation of 1e-15
    se = None if n == 1 else 0.0 if alike else float(known.std(ddof=1) / np.sqrt(n))
    return make(case, metric, printed, float(known.mean()), se, n, (median, q25, q75))


def make(
    case: Case,
    metric: str,
    printed: Printed,
    mean: float | None,
    se: float | None,
    n: int,
    quartiles: tuple[float | None, float | None, float | None] = (None, None, None),
) -> Row:
    """A row from its figures; ``quartiles`` are median, q25, q75."""
    plain = {key: value for key, value in case.items() if key != READING}
    reading = case.get(READING)
    paper = printed.value(plain, metric)
    return Row(
        plain, metric, paper, mean, se, *quartiles, n, None if reading is None else str(reading)
    )
