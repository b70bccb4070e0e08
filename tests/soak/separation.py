"""Missions that want to collide: ten vehicles at one altitude, or all sent to one point."""

from dataclasses import dataclass

import numpy as np

import uavbridge
from planners.planner import PlannerKind
from planners.types import Goal, GoTo

CROWD = """
name = "crowd"
clock = "stepped"
vehicles = 10
duration = {duration}
coverage_goal = 1.0
planner = "esustpm"

[area]
cell_m = 40.0
columns = 6
rows = 6

[fleet]
spacing_m = 40.0
altitude_m = 30.0

[sensor]
period_s = 2.0

[safety]
altitude_min_m = 15.0
altitude_max_m = 75.0
separation = {separation}

[wind]
east_m_s = 3.0
gust_m_s = 1.5

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


def closest(folder, seed, *, planner=None, separation=True, duration=120):
    """Fly one mission; the closest any two came in the air, and what failed."""
    path = folder / f"crowd-{seed}.toml"
    path.write_text(CROWD.format(separation=str(separation).lower(), duration=duration))
    result = uavbridge.run(path, planner=planner, overrides={"seed": seed})
    return result.min_separation_m, result.failures, {agent.state for agent in result.agents}
