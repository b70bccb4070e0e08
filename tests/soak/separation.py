"""Missions that want to collide: all at one altitude, homes side by side, planners gone mad."""

from dataclasses import dataclass

import numpy as np

import uavbridge
from planners.planner import PlannerKind
from planners.types import FlyVelocity, Goal, GoTo

CROWD = """
name = "crowd"
clock = "stepped"
vehicles = 10
duration = {duration}
coverage_goal = 1.0
planner = "{planner}"

[area]
cell_m = 40.0
columns = 6
rows = 6

[fleet]
spacing_m = {spacing}
altitude_m = 30.0

[sensor]
period_s = 2.0

[safety]
altitude_min_m = 15.0
altitude_max_m = 75.0
separation = {separation}

[wind]
east_m_s = {wind}
gust_m_s = {gust}

[[targets]]
position = [1.0, 239.0]
"""


@dataclass(frozen=True)
class NoParameters:
    """Nothing to set."""


class ToOnePoint:
    """Sends everybody to the middle of the area, at the same height."""

    def __init__(self, scenario):
        west, south, east, north = scenario.grid.bounds
        self._middle = np.array([(west + east) / 2, (south + north) / 2, scenario.starts[0, 2]])

    def init(self, view):
        return None

    def plan(self, view, memory, rng):
        return Goal(GoTo(self._middle)), None


TO_ONE_POINT = PlannerKind(
    "to-one-point",
    "Everybody to the middle.",
    NoParameters,
    lambda scenario, _: ToOnePoint(scenario),
)


class Mad:
    """Anything at all: far away, straight down, faster than sound, at somebody."""

    def __init__(self, scenario):
        pass

    def init(self, view):
        return None

    def plan(self, view, memory, rng):
        wild = rng.normal(size=3) * 10 ** rng.uniform(0, 6)
        choices = [
            FlyVelocity(wild),
            FlyVelocity(np.array([0.0, 0.0, -100.0])),
            FlyVelocity(np.array([0.0, 0.0, 100.0])),
            GoTo(wild),
            *(GoTo(place) for place in view.neighbours.position),
        ]
        return Goal(choices[rng.integers(len(choices))]), None


MAD = PlannerKind("mad", "Anything at all.", NoParameters, lambda scenario, _: Mad(scenario))


def fly(
    folder, seed, *, planner="esustpm", separation=True, duration=120, spacing=40.0, wind=3.0,
    gust=1.5,
):  # fmt: skip
    """Fly one mission and return its result; the planner by name, or one of those here."""
    path = folder / f"crowd-{seed}.toml"
    named = isinstance(planner, str)
    path.write_text(
        CROWD.format(
            planner=planner if named else "esustpm",
            separation=str(separation).lower(),
            duration=duration,
            spacing=spacing,
            wind=wind,
            gust=gust,
        )
    )
    return uavbridge.run(path, planner=None if named else planner, overrides={"seed": seed})


def closest(folder, seed, **how):
    """Fly one mission; the closest any two came in the air, and what failed."""
    result = fly(folder, seed, **how)
    return result.min_separation_m, result.failures, {agent.state for agent in result.agents}
