"""The setting of Zhou 2023, section 5: Table 2, and every reading of it that is open."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from planners.planner import param
from planners.registry import described, filled
from planners.search.mountain import MountainParams
from planners.search.mountain.params import BETA_RAD
from planners.terrain import Terrain, mountains
from planners.types import F64, I64
from uavbridge.experiments.experiment import READING, Case, Experiment, Outcome, Samples, generators
from uavbridge.experiments.printed import load
from uavbridge.experiments.rows import Row, make
from uavbridge.experiments.zhou import plots
from uavbridge.experiments.zhou.world import State, World, simulate

ALPHA_RAD = math.radians(40.0)
CORNER_M = 100.0  # robots start in a square of this side in the south-west
TARGETS = 10
SLOPES = {3: BETA_RAD, 4: ALPHA_RAD}  # largest slope of the terrain, by table
BLOCK = 10

# Other readings of what the paper leaves open, each against the default.
READINGS = (
    "boundary=clip",
    "repel=near",
    "escape=current",
    "escape=none",
    "domain_m=1200",
    "domain_m=1400",
    "terrain=each",
)


@dataclass(frozen=True, slots=True)
class ZhouParams:
    """What the tables' runs depend on, beside n_u and Table 2."""

    robots: str = param("30,40,50,60", unit="-", doc="numbers of robots n_u, by commas")
    domain_m: float = param(
        1000.0, unit="m", doc="side of the square domain, which the paper does not give",
        low=300.0, high=20_000.0,
    )  # fmt: skip
    boundary: str = param(
        "reflect",
        unit="-",
        doc="at the boundary the part of a velocity that crosses is turned, or cut",
        choices=("reflect", "clip"),
    )
    repel: str = param(
        "far",
        unit="-",
        doc="range of virtual forces: min(d_com, d_tar), or min(d_com, 2 d_tar)",
        choices=("near", "far"),
    )
    escape: str = param(
        "roam",
        unit="-",
        doc="against the stall of Eq. (9): roam anew, best of this step only, or none (literal)",
        choices=("roam", "current", "none"),
    )
    terrain: str = param(
        "one", unit="-", doc="one terrain for all runs, or one each", choices=("one", "each")
    )
    terrain_seed: int = param(7, unit="1", doc="of the one terrain", low=0)
    radio_m: float = param(300.0, unit="m", doc="d_com, communication range", low=0.0)
    loss: float = param(
        0.0, unit="1", doc="share of messages lost, receiver by receiver", low=0.0, high=1.0
    )
    delay: int = param(0, unit="1", doc="steps that messages take, beyond one", low=0, high=50)
    energy_limit_m: float = param(
        0.0, unit="m", doc="a robot that has driven so far stands; 0: no limit", low=0.0
    )
    steps: int = param(2000, unit="1", doc="a run is unfinished after as many", low=1)
    readings: str = param(
        "none", unit="-", doc="show other readings of what is open, too", choices=("none", "all")
    )

    @property
    def numbers(self) -> tuple[int, ...]:
        """n_u. Raises ValueError when they are no whole numbers of at least 1."""
        try:
            numbers = tuple(int(word) for word in self.robots.split(","))
        except ValueError as error:
            raise ValueError(
                f"robots must be whole numbers by commas, not {self.robots!r}"
            ) from error
        if min(numbers) < 1:
            raise ValueError(f"robots must be at least 1, not {min(numbers)}")
        return numbers

    @property
    def planner(self) -> MountainParams:
        """Table 2, and the readings chosen."""
        return MountainParams(boundary=self.boundary, repel=self.repel, escape=self.escape)

    @property
    def world(self) -> World:
        """Table 2's other half, and what is beyond the paper."""
        return World(
            radio_m=self.radio_m,
            loss=self.loss,
            delay=self.delay,
            energy_m=self.energy_limit_m or math.inf,
            steps=self.steps,
        )


def read(params: ZhouParams, case: Case) -> ZhouParams:
    """The parameters with the case's reading, and the keys of it that are parameters."""
    known = {part.name: part.kind for part in described(ZhouParams)}
    values = {key: value for key, value in case.items() if key in known}
    label = case.get(READING)
    if label is not None:
        key, _, text = str(label).partition("=")
        values[key] = known[key](text)
    checked = filled("reading", ZhouParams, values)
    return replace(params, **{key: getattr(checked, key) for key in values})


def ground(params: ZhouParams, steepest_rad: float, draw: np.random.Generator) -> Terrain:
    """Mountains over the domain."""
    return mountains(draw, (0.0, 0.0, params.domain_m, params.domain_m), steepest_rad)


def places(params: ZhouParams, n: int, draw: np.random.Generator) -> tuple[F64, F64]:
    """Starts (n, 2) in the corner, targets (10, 2) at least 100 m inside the edges."""
    starts = draw.uniform(0.0, CORNER_M, (n, 2))
    targets = draw.uniform(CORNER_M, params.domain_m - CORNER_M, (TARGETS, 2))
    return starts, targets


def course(
    case: Case, params: ZhouParams, seeds: I64
) -> tuple[Terrain, Sequence[np.random.Generator], F64, F64]:
    """Terrain, generators, starts (runs, n, 2) and targets (runs, 10, 2) of some runs."""
    draws = generators(seeds)
    drawn = [places(params, int(case["n_u"]), draw) for draw in draws]
    seed = params.terrain_seed if params.terrain == "one" else int(seeds[0])
    terrain = ground(params, SLOPES[int(case["table"])], np.random.default_rng(seed))
    starts, targets = (np.stack(part) for part in zip(*drawn, strict=True))
    return terrain, draws, starts, targets


def measure(case: Case, params: ZhouParams, seeds: I64, fidelity: str) -> Samples:
    """Steps, energy and whether a run is unfinished; the first two NaN where it is."""
    read_ = read(params, case)
    lots = [seeds] if read_.terrain == "one" else [seeds[i : i + 1] for i in range(len(seeds))]
    parts = [_measure(case, read_, lot) for lot in lots]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _measure(case: Case, params: ZhouParams, seeds: I64) -> Samples:
    terrain, draws, starts, targets = course(case, params, seeds)
    steps, energy = np.full(len(seeds), np.nan), np.full(len(seeds), np.nan)
    found = np.zeros(len(seeds))
    for state in simulate(terrain, starts, targets, draws, params.planner, params.world):
        done = state.reached.all(axis=1)
        found[state.run] = state.reached.sum(axis=1)
        steps[state.run[done]] = state.t
        energy[state.run[done]] = state.driven[done].sum(axis=1)
        if params.energy_limit_m and _spent(state, params):
            break
    return {
        "steps": steps,
        "energy": energy,
        "unfinished": np.isnan(steps).astype(np.float64),
        "found": found,
    }


def _spent(state: State, params: ZhouParams) -> bool:
    """Whether no robot of any run can go on."""
    return bool((state.driven >= params.energy_limit_m).all())


def cases(table: int, params: ZhouParams) -> list[Case]:
    """A case an n_u, then the other readings."""
    plain: list[Case] = [{"table": table, "n_u": number} for number in params.numbers]
    if params.readings == "none":
        return plain
    others: list[Case] = [{**case, READING: label} for label in READINGS for case in plain]
    return [*plain, *(case for case in others if read(params, case) != params)]


def deviations(outcome: Outcome) -> list[Row]:
    """Standard deviations over the runs, beside those of the printed rows."""
    paper = load(outcome.experiment.printed)
    rows = []
    for case, samples in outcome.samples:
        for metric in ("steps", "energy"):
            values = samples[metric][np.isfinite(samples[metric])]
            spread = float(values.std(ddof=1)) if len(values) > 1 else None
            rows.append(make(case, f"{metric}_sd", paper, spread, None, len(values)))
    return rows


def table(number: int, name: str, summary: str, file: str) -> Experiment:
    """Table 3 or 4 as an experiment."""
    return Experiment(
        name=name,
        summary=summary,
        source=f"Zhou 2023, Table {number}",
        params=ZhouParams,
        cases=partial(cases, number),
        simulate=measure,
        file=file,
        runs=30,
        block=BLOCK,
        derive=deviations,
        plot=plots.against_paper,
    )
