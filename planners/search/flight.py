"""From a kernel's planar velocity to a setpoint that a vehicle may fly.

Kernels broadcast over leading axes; the functions over a ``View`` are what the
adapters share.
"""

from __future__ import annotations

import numpy as np

from planners.grid import Grid
from planners.types import F64, Bools, FlyVelocity, GoTo, Scenario, View

_LEVEL_M = 1.0  # height errors below this are the autopilot's business


def limit(velocity: F64, speed_m_s: float, reading: str) -> F64:
    """Velocities (..., 2) held to a speed.

    Args:
        velocity: (..., 2) m/s.
        speed_m_s: the limit.
        reading: of the paper's "maximum velocity": "norm", "component" (each of the
            two, so up to sqrt 2 times the speed), or "none".
    """
    if reading == "none":
        return velocity
    if reading == "component":
        return np.clip(velocity, -speed_m_s, speed_m_s)
    speed = np.hypot(velocity[..., 0], velocity[..., 1])
    factor = speed_m_s / np.maximum(speed, speed_m_s)
    return np.asarray(velocity * factor[..., None])


def turned(velocity: F64, angle: F64) -> F64:
    """Velocities (..., 2) turned counter-clockwise by angles (...) rad."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = velocity[..., 0], velocity[..., 1]
    return np.stack((x * cos - y * sin, x * sin + y * cos), axis=-1)


def turn_back(
    position: F64, velocity: F64, grid: Grid, step_s: float, margin_m: float, reading: str
) -> F64:
    """Velocities (..., 2) that stay inside the area for the next ``step_s``.

    One that would cross the boundary is reversed (Liu 2022, section 2.2), as a
    whole ("vector") or in the component that crosses ("component"). Where that
    crosses too, or the agent is outside already, it flies towards the inside.

    Args:
        position: (..., 2) m.
        velocity: (..., 2) m/s.
        grid: the area.
        step_s: time looked ahead.
        margin_m: how far from the edges the boundary lies.
        reading: "vector" or "component".
    """
    low, high = _box(grid, margin_m)
    ahead = position + velocity * step_s
    out = ((ahead < low) & (velocity < 0.0)) | ((ahead > high) & (velocity > 0.0))
    crosses = out if reading == "component" else out.any(axis=-1, keepdims=True)
    back = np.where(crosses, -velocity, velocity)
    ahead = position + back * step_s
    out = ((ahead < low) & (back < 0.0)) | ((ahead > high) & (back > 0.0))
    inward = (np.clip(position, low, high) - position) / step_s
    return np.where(out, inward, back)


def neighbours(view: View, forget_s: float) -> tuple[F64, F64]:
    """Positions and velocities (k, 2) of those heard lately, ascending id.

    Positions are carried forward by the age of what was heard.
    """
    heard = view.neighbours
    order = np.argsort(heard.ids, kind="stable")
    position = heard.position[order, :2] + heard.velocity[order, :2] * heard.age_s[order, None]
    velocity = heard.velocity[order, :2]
    usable = heard.age_s[order] <= forget_s
    usable &= np.isfinite(position).all(axis=-1) & np.isfinite(velocity).all(axis=-1)
    return position[usable], velocity[usable]


def altitude(scenario: Scenario, agent: int) -> float:
    """Search height of an agent: that of its start, within the limits."""
    limits = scenario.limits
    height = float(scenario.starts[scenario.index(agent), 2])
    return min(max(height, limits.altitude_min_m), limits.altitude_max_m)


def level_velocity(scenario: Scenario, view: View, velocity: F64) -> FlyVelocity:
    """Setpoint that flies ``velocity`` (2,) at the search height, inside the limits."""
    limits = scenario.limits
    planar = limit(velocity, limits.speed_m_s, "norm")
    error = altitude(scenario, view.agent) - float(view.position[2])
    climb = max(-limits.climb_m_s, min(limits.climb_m_s, error)) if abs(error) > _LEVEL_M else 0.0
    return FlyVelocity(np.array((planar[0], planar[1], climb)))


def level_point(scenario: Scenario, view: View, point: F64, speed_m_s: float) -> GoTo:
    """Setpoint that flies to ``point`` (2,) at the search height, inside the area."""
    x, y = scenario.grid.clip(point)
    position = np.array((x, y, altitude(scenario, view.agent)))
    return GoTo(position, speed_m_s=min(speed_m_s, scenario.limits.speed_m_s))


def everyone(others: F64) -> Bools:
    """All rows of ``others`` (..., k, 2) count."""
    return np.ones(others.shape[:-1], np.bool_)


def _box(grid: Grid, margin_m: float) -> tuple[F64, F64]:
    west, south, east, north = grid.bounds
    low, high = np.array((west, south)) + margin_m, np.array((east, north)) - margin_m
    middle = (low + high) / 2.0
    return np.minimum(low, middle), np.maximum(high, middle)
