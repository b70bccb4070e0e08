"""What an experiment is: cases, a simulation of a block of runs, and how to show them.

An experiment is one module with one ``Experiment``, and one TOML file beside
it with the numbers that the paper prints (``printed.py``). It is listed in
``registry.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planners.types import I64
from uavbridge.experiments.cases import READING, Axis, Case, Samples, Value
from uavbridge.experiments.rows import Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "FIDELITIES",
    "READING",
    "Axis",
    "Case",
    "Experiment",
    "Outcome",
    "Samples",
    "Value",
    "generators",
]

FIDELITIES = ("ideal", "dynamics", "mavlink")


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """All that an experiment came to."""

    experiment: Experiment
    params: Any
    runs: int
    seed: int
    fidelity: str
    samples: Sequence[tuple[Case, Samples]]  # in the order of the cases, runs in their order
    rows: Sequence[Row] = ()

    def of(self, **case: Value) -> Samples:
        """Samples of one case, by exactly its keys. Raises KeyError when there is none."""
        for known, samples in self.samples:
            if dict(known) == case:
                return samples
        raise KeyError(f"no case {case}")


@dataclass(frozen=True, slots=True)
class Experiment:
    """A table or a figure of a paper, or one of ours.

    Attributes:
        name: as the command line spells it.
        summary: one line.
        source: such as "Liu 2022, Table 2".
        params: frozen dataclass, its fields made with ``planners.planner.param``.
        cases: the cases to run. Raises ValueError when the parameters make no sense together.
        simulate: (case, params, seeds (k,), fidelity) to metrics; one seed a run; arrays (k,), or
            (k, len(axis.values)); NaN where a run did not reach what the metric tells.
        file: the module's ``__file__``; the printed numbers are in the TOML beside it.
        runs: a case, when the command line is silent.
        runs_flown: the same in fidelities where a run takes long.
        block: runs simulated by one call, in the fidelities that are ``batched``; else one.
        fidelities: those that ``simulate`` knows.
        batched: those of them that are worth simulating in blocks.
        paired: case keys that do not enter the seeds: cases that differ only in them get equal
            seeds, run by run. Readings always do.
        alike: cases for which it is the same have the same samples, and are simulated once.
        axis: of the metrics that are curves.
        medians: metrics that the paper shows as boxplots.
        intervals: the table shows 95 % intervals of the means instead of standard errors.
        derive: further rows from the samples, for what is no mean over runs.
        remarks: what the rows show, in a line each; printed below the table.
        plot: draws on an empty figure.
    """

    name: str
    summary: str
    source: str
    params: type[Any]
    cases: Callable[[Any], Sequence[Case]]
    simulate: Callable[[Case, Any, I64, str], Samples]
    file: str
    runs: int = 100
    runs_flown: Mapping[str, int] = field(default_factory=dict)
    block: int = 100
    fidelities: tuple[str, ...] = ("ideal",)
    batched: tuple[str, ...] = ("ideal",)
    paired: tuple[str, ...] = ()
    alike: Callable[[Case], Case] | None = None
    axis: Axis | None = None
    medians: tuple[str, ...] = ()
    intervals: bool = False
    derive: Callable[[Outcome], Sequence[Row]] | None = None
    remarks: Callable[[Outcome], Sequence[str]] | None = None
    plot: Callable[[Figure, Outcome], None] | None = None

    @property
    def printed(self) -> Path:
        """The file of the paper's numbers."""
        return Path(self.file).with_suffix(".toml")

    def usual_runs(self, fidelity: str) -> int:
        """Runs of a case when the command line is silent."""
        return self.runs_flown.get(fidelity, self.runs)


def generators(seeds: I64) -> list[np.random.Generator]:
    """A generator a run, from the seeds (k,) that ``simulate`` is given."""
    return [np.random.Generator(np.random.PCG64(int(seed))) for seed in seeds]
