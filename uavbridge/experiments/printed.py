"""The numbers that a paper prints, from the TOML file beside an experiment's module.

::

    [[printed]]
    case = { method = "random", targets = true }
    visited_cells = 26
    uncertainty = 43.92

    [[remark]]                      # optional: shown below the table
    text = "..."
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from uavbridge.experiments.cases import Case, Value


@dataclass(frozen=True, slots=True, eq=False)
class Printed:
    """Numbers by case and metric, and remarks on them."""

    numbers: Sequence[tuple[dict[str, Value], dict[str, float]]] = ()
    remarks: tuple[str, ...] = ()

    def value(self, case: Case, metric: str) -> float | None:
        """What the paper prints, or None."""
        for known, numbers in self.numbers:
            if known == dict(case) and metric in numbers:
                return numbers[metric]
        return None


def load(path: Path) -> Printed:
    """The numbers of a file; none when there is no such file."""
    if not path.exists():
        return Printed()
    document = tomllib.loads(path.read_text())
    numbers = [
        (dict(part["case"]), {key: float(part[key]) for key in part if key != "case"})
        for part in document.get("printed", ())
    ]
    return Printed(numbers, tuple(part["text"] for part in document.get("remark", ())))
