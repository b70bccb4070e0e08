"""Runs an experiment: blocks of runs, here, in processes, or on a Dask cluster.

The runs of a case are cut into blocks of a fixed size, and every run has a seed
of its own that follows from (seed, case, run) alone. So the numbers are the
same whatever the workers, and whoever does which block first.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planners.registry import filled
from planners.types import I64
from uavbridge.errors import ConfigError
from uavbridge.experiments import printed, rows
from uavbridge.experiments.experiment import (
    READING,
    Case,
    Experiment,
    Outcome,
    Samples,
)
from uavbridge.experiments.spread import Spread


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Some runs of one case: what travels to a worker."""

    experiment: Experiment
    case: Case
    params: Any
    seeds: I64  # (runs,)
    fidelity: str

    def simulate(self) -> Samples:
        """Metrics of these runs."""
        samples = self.experiment.simulate(self.case, self.params, self.seeds, self.fidelity)
        for metric, values in samples.items():
            if len(values) != len(self.seeds):
                raise ValueError(f"metric {metric}: {len(values)} values of {len(self.seeds)} runs")
        return samples


def parameters(experiment: Experiment, values: Mapping[str, Any]) -> Any:
    """The experiment's parameters with some replaced.

    Raises:
        ConfigError: one is not known, of the wrong type or out of range; names it.
    """
    try:
        return filled(f"experiment {experiment.name}", experiment.params, values)
    except ValueError as error:
        raise ConfigError(str(error)) from error


def run(
    experiment: Experiment,
    spread: Spread,
    *,
    runs: int,
    seed: int = 1,
    values: Mapping[str, Any] | None = None,
    fidelity: str = "ideal",
    progress: Callable[[int, int], None] | None = None,
) -> Outcome:
    """All cases of an experiment.

    Args:
        experiment: which.
        spread: who does the work (``uavbridge.experiments.spread``).
        runs: a case.
        seed: of all randomness.
        values: parameters to replace.
        fidelity: one of the experiment's.
        progress: called with (runs done, runs in all).

    Raises:
        ConfigError: a parameter, the fidelity or the number of runs is wrong.
    """
    if fidelity not in experiment.fidelities:
        known = ", ".join(experiment.fidelities)
        raise ConfigError(
            f"experiment {experiment.name}: no fidelity {fidelity!r} (known: {known})"
        )
    if runs < 1:
        raise ConfigError(f"--runs must be at least 1, not {runs}")
    params = parameters(experiment, values or {})
    try:
        cases = list(experiment.cases(params))
    except ValueError as error:
        raise ConfigError(f"experiment {experiment.name}: {error}") from error
    groups = _groups(experiment, cases)
    blocks, owner = _blocks(
        experiment, [cases[same[0]] for same in groups], params, runs, seed, fidelity
    )
    parts: list[Samples | None] = [None] * len(blocks)
    done = 0
    for place, samples in spread(Block.simulate, blocks):
        parts[place] = samples
        done += len(blocks[place].seeds) * len(groups[owner[place]])
        if progress is not None:
            progress(done, runs * len(cases))
    joined = dict(_joined(groups, owner, parts))
    samples_of = [(case, joined[number]) for number, case in enumerate(cases)]
    outcome = Outcome(experiment, params, runs, seed, fidelity, samples_of)
    return replace(outcome, rows=_rows(outcome))


def seeds_of(experiment: Experiment, case: Case, seed: int, runs: int) -> I64:
    """Seeds (runs,) of the runs of a case, in [0, 2^63)."""
    left_out = {READING, *experiment.paired}
    own = sorted((key, value) for key, value in case.items() if key not in left_out)
    keys = (repr((int(seed), own, run)).encode() for run in range(runs))
    drawn = [int.from_bytes(hashlib.sha256(key).digest()[:8], "little") >> 1 for key in keys]
    return np.array(drawn, dtype=np.int64)


def _blocks(
    experiment: Experiment, cases: Sequence[Case], params: Any, runs: int, seed: int, fidelity: str
) -> tuple[list[Block], list[int]]:
    """Blocks of all cases, and the case's number of each."""
    size = experiment.block if fidelity in experiment.batched else 1
    blocks, owner = [], []
    for number, case in enumerate(cases):
        seeds = seeds_of(experiment, case, seed, runs)
        for first in range(0, runs, size):
            blocks.append(Block(experiment, case, params, seeds[first : first + size], fidelity))
            owner.append(number)
    return blocks, owner


def _groups(experiment: Experiment, cases: Sequence[Case]) -> list[list[int]]:
    """Numbers of cases that have the same samples, each group in its order."""
    if experiment.alike is None:
        return [[number] for number in range(len(cases))]
    groups: dict[tuple[tuple[str, object], ...], list[int]] = {}
    for number, case in enumerate(cases):
        key = tuple(sorted(experiment.alike(case).items()))
        groups.setdefault(key, []).append(number)
    return list(groups.values())


def _joined(
    groups: Sequence[Sequence[int]], owner: Sequence[int], parts: Sequence[Samples | None]
) -> Iterator[tuple[int, Samples]]:
    """The samples of each case, by its number."""
    for place, numbers in enumerate(groups):
        mine = [part for who, part in zip(owner, parts, strict=True) if who == place]
        whole = [part for part in mine if part is not None]
        if len(whole) != len(mine):
            raise ValueError("a block of runs is missing")
        metrics = {name: np.concatenate([part[name] for part in whole]) for name in whole[0]}
        yield from ((number, metrics) for number in numbers)


def _rows(outcome: Outcome) -> list[rows.Row]:
    experiment = outcome.experiment
    paper = printed.load(experiment.printed)
    out = [
        row
        for case, samples in outcome.samples
        for row in rows.of_samples(case, samples, paper, experiment.axis)
    ]
    if experiment.derive is not None:
        out.extend(experiment.derive(outcome))
    return out
