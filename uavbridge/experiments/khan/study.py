"""What the paper's figures and tables have in common: cases, metrics, gain, other readings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from planners.planner import param
from planners.types import F64, I64
from uavbridge.experiments import printed, rows
from uavbridge.experiments.experiment import READING, Case, Outcome, Samples, Value
from uavbridge.experiments.khan.choices import RULES, KhanParams, Scale
from uavbridge.experiments.khan.teams import team_of
from uavbridge.experiments.khan.world import Fates, search

PAIRED = ("rule", "range")  # the same start cells and draws
BLOCK = 1000
RUNS_FLOWN = {"dynamics": 10, "mavlink": 2}

# What the paper leaves open, one choice away from the defaults.
READINGS = (
    "exchange=whole",
    "exchange=contested",
    "starts=once",
    "sweep=snake-and-back",
    "sweep=snake-and-jump",
    "sweep=closed-tour",
    "phase=random",
    "order=in-turn",
    "observer=merges",
    "counted=all",
    "untouched=overwritten",
    "history=current",
    "relay=true",
)


@dataclass(frozen=True, slots=True)
class StudyParams(KhanParams):
    """The setting, the rules shown, and which other readings are."""

    rules: str = param(",".join(RULES), unit="-", doc="merging rules, by commas; UNC always is")
    readings: str = param(
        "", unit="-", doc='other readings shown too, by commas, such as "exchange=whole"; or "all"'
    )

    def __post_init__(self) -> None:
        KhanParams.__post_init__(self)
        for name in self.shown:
            if name not in RULES:
                raise ValueError(f"unknown rule {name!r} (known: {', '.join(RULES)})")
        for label in self.others:
            if label not in READINGS:
                raise ValueError(f"unknown reading {label!r} (known: {', '.join(READINGS)})")

    @property
    def shown(self) -> tuple[str, ...]:
        """The rules in the paper's order; UNC is what gains are measured against."""
        named = {part.strip() for part in self.rules.split(",") if part.strip()}
        return ("UNC", *sorted(named - {"UNC"}, key=lambda name: (*RULES, name).index(name)))

    @property
    def others(self) -> tuple[str, ...]:
        """Labels of the other readings."""
        if self.readings == "all":
            return READINGS
        return tuple(part.strip() for part in self.readings.split(",") if part.strip())


@dataclass(frozen=True, slots=True)
class FlownParams(StudyParams):
    """The same, and how large the region is for vehicles."""

    cell_m: float = param(20.0, unit="m", doc="flown: a cell", low=15.0, high=1000.0)
    speed_m_s: float = param(10.0, unit="m/s", doc="flown: speed", low=1.0, high=12.0)
    flight_s: float = param(
        1000.0,
        unit="s",
        doc="flown: a search is given up then, for batteries last 18 minutes",
        low=1.0,
        high=1100.0,
    )

    @property
    def scale(self) -> Scale:
        """For vehicles."""
        return Scale(self.cell_m, self.speed_m_s, self.flight_s)


def read_as(params: KhanParams, label: str) -> KhanParams:
    """The setting with one choice made otherwise: one of READINGS."""
    name, _, word = label.partition("=")
    changes: dict[str, bool | str] = {name: word == "true" if word in ("true", "false") else word}
    return replace(params, **changes)  # type: ignore[arg-type]


def cases(
    params: StudyParams,
    uavs: Iterable[int],
    ranges: Iterable[int],
    more: Sequence[Case] = ({},),
) -> list[Case]:
    """Every N, range and rule, with each of the further keys; then the other readings."""
    ranges = tuple(ranges)
    plain: list[Case] = [
        {"N": n, "range": reach, "rule": rule, **extra}
        for n in uavs
        for reach in ranges
        for extra in more
        for rule in params.shown
    ]
    return [*plain, *({**case, READING: label} for label in params.others for case in plain)]


def numbers(name: str, text: str, least: int) -> tuple[int, ...]:
    """Whole numbers by commas. Raises ValueError naming the parameter."""
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isdecimal() and int(part) >= least for part in parts):
        raise ValueError(f"{name} must be whole numbers from {least} on, by commas, not {text!r}")
    return tuple(dict.fromkeys(int(part) for part in parts))


def simulate(case: Case, params: FlownParams, seeds: I64, fidelity: str) -> Samples:
    """Steps until P >= B, and whether another cell than the target's was named."""
    setting = setting_of(case, params)
    uavs, rule, reach = int(case["N"]), str(case["rule"]), float(case["range"])
    if fidelity != "ideal":
        from uavbridge.experiments.khan import missions

        return metrics(missions.fly(setting, params.scale, rule, uavs, reach, seeds, fidelity))
    team = team_of(rule, setting, len(seeds), uavs)
    return metrics(search(team, setting, uavs, reach, seeds))


def alike(case: Case) -> Case:
    """Who merges nothing does the same at every range."""
    return {**case, "range": 0} if case["rule"] == "UNC" else case


def metrics(fates: Fates) -> dict[str, F64]:
    """Steps and errors of runs."""
    return {
        "steps": fates.steps.astype(np.float64),
        "error_percent": np.where(fates.wrong, 100.0, 0.0),
    }


def setting_of(case: Case, params: KhanParams) -> KhanParams:
    """The setting of one case: its reading, and its q."""
    setting = read_as(params, str(case[READING])) if READING in case else params
    return replace(setting, q=float(case["q"])) if "q" in case else setting


def gains(outcome: Outcome, metric: str = "steps") -> list[rows.Row]:
    """Gain over uncoordinated search in the same runs, (T_u - T_c) / T_u in percent."""
    paper = printed.load(outcome.experiment.printed)
    alone = {_without_rule(c): s[metric] for c, s in outcome.samples if c["rule"] == "UNC"}
    found = []
    for case, samples in outcome.samples:
        if case["rule"] == "UNC":
            continue
        apart, together = alone[_without_rule(case)], samples[metric]
        ratio = together.mean() / apart.mean()
        n = len(together)
        # A ratio of means of paired runs, to first order.
        spread = float((together - ratio * apart).std(ddof=1)) if n > 1 else None
        se = None if spread is None else 100.0 * spread / sqrt(n) / float(apart.mean())
        found.append(rows.make(case, "gain_percent", paper, 100.0 * float(1.0 - ratio), se, n))
    return found


def _without_rule(case: Case) -> tuple[tuple[str, Value], ...]:
    return tuple(sorted((key, value) for key, value in case.items() if key != "rule"))
