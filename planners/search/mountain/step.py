"""One step of the whole method: decide, then track the ground (Zhou 2023, Fig. 4)."""

from __future__ import annotations

from dataclasses import replace

from planners.search.mountain import surface
from planners.search.mountain.decide import Rules, decide
from planners.search.mountain.state import Draws, Heard, Robots, Sensed
from planners.search.mountain.surface import Bounds
from planners.terrain import Terrain
from planners.types import F64, I64


def step(
    ids: I64,
    robots: Robots,
    sensed: Sensed,
    heard: Heard,
    draws: Draws,
    terrain: Terrain,
    bounds: Bounds,
    rules: Rules,
) -> tuple[F64, Robots]:
    """Velocities V (..., 3) of the next step, in m a step, and the memory.

    Args:
        ids: (...) of the robots that decide.
        robots: what they kept.
        sensed: their own sensors, now.
        heard: messages of the last step, their own included.
        draws: random numbers.
        terrain: the ground, at least one step around each robot.
        bounds: of the search, west, south, east, north.
        rules: parameters.
    """
    params, position = rules.params, sensed.position
    expected, after = decide(ids, robots, sensed, heard, draws, rules)
    expected = surface.reflected(position, expected, bounds, params.boundary)
    plane = surface.ground_plane(position, terrain, params.lattice_m)
    tangent = surface.track_surface(expected, plane, rules.speed_m, ~after.member)
    turned = surface.avoid_steep(
        tangent,
        position,
        plane,
        terrain,
        params.climb_rad,
        bounds=bounds,
        directions=params.directions,
        lattice_m=params.lattice_m,
    )
    velocity, _ = surface.advance(position, turned, terrain)
    return velocity, replace(after, velocity=velocity)
