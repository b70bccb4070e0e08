"""Whether what a planner wants lies inside the area and the limits of its mission."""

from __future__ import annotations

from typing import Any

import numpy as np

from planners.types import FlySegment, FlyVelocity, Goal, GoTo, Scenario, View

_SLACK = 1e-6
_HELD = "the safety filter will change the setpoint, and the planner no longer knows what is flown"


def goal_faults(goal: Goal, view: View, case: Scenario) -> list[str]:
    """What is wrong with one goal; empty when nothing is.

    Args:
        goal: what the planner wants.
        view: what it knew.
        case: the search, with its area and limits.

    Returns:
        Messages that tell what is wrong and why it matters.
    """
    setpoint: object = goal.setpoint
    if isinstance(setpoint, FlyVelocity):
        return _yaw_faults(setpoint.yaw_rad) + _velocity_faults(setpoint, view, case)
    if isinstance(setpoint, GoTo):
        faults = _yaw_faults(setpoint.yaw_rad) + _point_faults(setpoint.position, case)
        return faults + _speed_faults(setpoint.speed_m_s, case)
    if isinstance(setpoint, FlySegment):
        faults = _point_faults(setpoint.start, case) + _point_faults(setpoint.end, case)
        return faults + _speed_faults(setpoint.speed_m_s, case)
    return [f"the setpoint is a {type(setpoint).__name__}: not GoTo, FlyVelocity or FlySegment"]


def _velocity_faults(setpoint: FlyVelocity, view: View, case: Scenario) -> list[str]:
    velocity = np.asarray(setpoint.velocity)
    if velocity.shape != (3,) or not np.isfinite(velocity).all():
        return [f"velocity {velocity} is not three finite numbers: no vehicle can fly it"]
    speed, limits = float(np.hypot(velocity[0], velocity[1])), case.limits
    faults = []
    if speed > limits.speed_m_s + _SLACK:
        faults.append(f"speed {speed:.2f} m/s is over the limit of {limits.speed_m_s:g}: {_HELD}")
    if abs(velocity[2]) > limits.climb_m_s + _SLACK:
        climb = f"climb {velocity[2]:.2f} m/s is over the limit of {limits.climb_m_s:g}"
        faults.append(f"{climb}: {_HELD}")
    ahead = view.position + velocity * case.tick_s
    if case.grid.contains(view.position) and not case.grid.contains(ahead):
        faults.append(f"leaves the area within a tick, at {_text(ahead)}: {_HELD}")
    low, high = limits.altitude_min_m, limits.altitude_max_m
    if low <= view.position[2] <= high and not low - _SLACK <= ahead[2] <= high + _SLACK:
        faults.append(f"leaves the altitude band within a tick, at {_text(ahead)}: {_HELD}")
    return faults


def _point_faults(point: Any, case: Scenario) -> list[str]:
    place = np.asarray(point)
    if place.shape != (3,) or not np.isfinite(place).all():
        return [f"point {place} is not three finite numbers: no vehicle can fly there"]
    faults = []
    if not case.grid.contains(case.grid.clip(place[:2]) if _close(place, case) else place):
        faults.append(f"point {_text(place)} lies outside the area: {_HELD}")
    low, high = case.limits.altitude_min_m, case.limits.altitude_max_m
    if not low - _SLACK <= place[2] <= high + _SLACK:
        faults.append(f"height {place[2]:.1f} m is outside {low:g} to {high:g}: {_HELD}")
    return faults


def _close(place: Any, case: Scenario) -> bool:
    """Whether a point is in the area but for rounding."""
    return bool(np.abs(case.grid.clip(place[:2]) - place[:2]).max() <= _SLACK)


def _speed_faults(speed: float | None, case: Scenario) -> list[str]:
    if speed is None or 0.0 < speed <= case.limits.speed_m_s + _SLACK:
        return []
    return [f"speed {speed} m/s is not above 0 and up to {case.limits.speed_m_s:g}: {_HELD}"]


def _yaw_faults(yaw: float | None) -> list[str]:
    if yaw is None or np.isfinite(yaw):
        return []
    return [f"yaw {yaw} is not finite: None leaves it to the autopilot"]


def _text(point: Any) -> str:
    return ", ".join(f"{part:.1f}" for part in point)
