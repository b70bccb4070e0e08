"""Chen 2023, Figs 9-13: Dubins airplane paths with a car's path of 185 m."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.paths.dubins import AirplanePath, airplane, shortest_car
from planners.planner import param
from planners.types import I64
from uavbridge.experiments.experiment import Case, Experiment, Outcome, Samples

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CASES = ("low", "medium", "high")
_CODES = {name: place for place, name in enumerate(CASES)}


@dataclass(frozen=True, slots=True)
class DubinsParams:
    """Parameters of chen-dubins: the paper prints the car's length and the heights."""

    car_m: float = param(185.0, unit="m", doc="length of the car's path", low=1.0)
    radius_m: float = param(40.0, unit="m", doc="least turning radius", low=0.1)
    climb_deg: float = param(30.0, unit="deg", doc="largest climb angle", low=1.0, high=89.0)
    bearing_deg: float = param(20.0, unit="deg", doc="direction of the end, seen from the start")
    heading_deg: float = param(80.0, unit="deg", doc="heading at the end")


def cases(params: DubinsParams) -> list[Case]:
    """The three heights, climbing and descending."""
    return [{"height_m": sign * height} for height in (75, 175, 400) for sign in (1, -1)]


def path_of(case: Case, params: DubinsParams) -> AirplanePath:
    """The path of a case. Raises ValueError when no end has a car's path of that length."""
    bearing, heading = math.radians(params.bearing_deg), math.radians(params.heading_deg)

    def end(away: float) -> tuple[float, float, float]:
        return away * math.cos(bearing), away * math.sin(bearing), heading

    low, high = 0.0, params.car_m
    for _ in range(60):
        middle = (low + high) / 2.0
        shorter = shortest_car((0, 0, 0), end(middle), params.radius_m).length < params.car_m
        low, high = (middle, high) if shorter else (low, middle)
    length = shortest_car((0, 0, 0), end(high), params.radius_m).length
    if abs(length - params.car_m) > 1e-6:
        raise ValueError(f"no end in that direction has a car's path of {params.car_m:g} m")
    x, y, psi = end(high)
    climb = math.radians(params.climb_deg)
    return airplane((0, 0, 0, 0), (x, y, float(case["height_m"]), psi), params.radius_m, climb)


def simulate(case: Case, params: DubinsParams, seeds: I64, fidelity: str) -> Samples:
    """Figures of the path; nothing is random."""
    path = path_of(case, params)
    points = path.points(0.5)
    figures = {
        "car_m": params.car_m,
        "case": float(_CODES[path.case]),
        "length_m": path.length,
        "climb_rad": path.gamma,
        "radius_m": path.radius,
        "turns": float(path.turns),
        "height_error_m": abs(float(points[-1, 2]) - float(case["height_m"])),
        "length_printed_form_m": params.car_m / math.cos(path.gamma),
    }
    return {name: np.full(len(seeds), value) for name, value in figures.items()}


def plot(figure: Figure, outcome: Outcome) -> None:
    """Figs 9, 12, 13: in space and from above."""
    from uavbridge.experiments.chen import plots

    climbs = [case for case, _ in outcome.samples if float(case["height_m"]) > 0.0]
    plots.airplanes(figure, [path_of(case, outcome.params) for case in climbs])


EXPERIMENT = Experiment(
    name="chen-dubins",
    summary="Dubins airplane paths: low, medium and high climbs",
    source="Chen 2023, Figs 9-13",
    params=DubinsParams,
    cases=cases,
    simulate=simulate,
    file=__file__,
    runs=1,
    plot=plot,
)
