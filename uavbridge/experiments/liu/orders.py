"""Whether the paper's order of the methods holds: in words, pair by pair."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

from uavbridge.experiments.experiment import Outcome
from uavbridge.experiments.rows import Row

_DEFAULT: Mapping[str, str] = {}
_CLEAR = 2.0  # standard errors of a difference, at least, to call it one


def in_words(
    outcome: Outcome, metric: str, targets: bool, readings: Mapping[str, str] = _DEFAULT
) -> str:
    """The printed order of a metric, ours, and the pairs in which they differ.

    Args:
        outcome: with rows of the cases ``{"method": ..., "targets": ...}``.
        metric: which.
        targets: which half of Table 2.
        readings: of a method, where not the default reading.
    """
    rows = [
        row
        for row in outcome.rows
        if row.metric == metric
        and row.case == {"method": row.case.get("method"), "targets": targets}
        and row.reading == readings.get(str(row.case["method"]))
        and row.mean is not None
        and row.paper is not None
    ]
    title = f"{metric}, {'with' if targets else 'without'} targets"
    if readings:
        title += f" ({', '.join(dict.fromkeys(readings.values()))})"
    wrong = [
        f"{first.case['method']} / {second.case['method']}{_doubt(first, second)}"
        for first, second in combinations(sorted(rows, key=_paper), 2)
        if _paper(first) < _paper(second) and _mean(first) >= _mean(second)
    ]
    verdict = "the order holds" if not wrong else "the order fails for " + ", ".join(wrong)
    return (
        f"{title}: printed {_chain(rows, of_paper=True)}; ours {_chain(rows, of_paper=False)}; "
        f"{verdict}."
    )


def _chain(rows: list[Row], of_paper: bool) -> str:
    key = _paper if of_paper else _mean
    text = ""
    before: float | None = None
    for row in sorted(rows, key=key):
        sign = "" if before is None else " = " if key(row) == before else " < "
        text += f"{sign}{row.case['method']}"
        before = key(row)
    return text


def _doubt(first: Row, second: Row) -> str:
    spread = ((first.se or 0.0) ** 2 + (second.se or 0.0) ** 2) ** 0.5
    clear = abs(_mean(first) - _mean(second)) > _CLEAR * spread
    return "" if clear else " (ours within the noise)"


def _mean(row: Row) -> float:
    return row.mean if row.mean is not None else float("nan")


def _paper(row: Row) -> float:
    return row.paper if row.paper is not None else float("nan")
