"""From a planner's setpoint to the velocity wanted now."""

from __future__ import annotations

from math import hypot, sqrt

import numpy as np

from planners.terrain import Terrain
from planners.types import FlySegment, FlyVelocity, Goal, GoTo, Setpoint
from uavbridge.safety.envelope import Envelope
from uavbridge.safety.filter import Vector

HEIGHT_GAIN = 0.8  # 1/s
CLOSE_GAIN = 0.7  # 1/s, slope of the approach to a point
APPROACH_M_S2 = 1.5  # deceleration planned into a point
LOOKAHEAD_S = 2.0  # how far ahead of a vehicle the point runs along a segment
GROUND_S = (1.0, 2.0)  # how far ahead the ground is looked at that a vehicle follows
SLOWEST = 0.1  # share of a speed that is kept on slopes steeper than a vehicle climbs


def sound(goal: Goal) -> Goal:
    """The goal, if it can be flown.

    Raises:
        TypeError: it is no Goal, or its setpoint is none.
        ValueError: the setpoint is not three finite numbers.
    """
    setpoint = goal.setpoint
    if isinstance(setpoint, GoTo):
        vectors = [setpoint.position]
    elif isinstance(setpoint, FlyVelocity):
        vectors = [setpoint.velocity]
    elif isinstance(setpoint, FlySegment):
        vectors = [setpoint.start, setpoint.end]
    else:
        raise TypeError(f"a setpoint is GoTo, FlyVelocity or FlySegment, not {setpoint!r}")
    for vector in vectors:
        if np.shape(vector) != (3,) or not np.isfinite(vector).all():
            raise ValueError(f"a setpoint needs three finite numbers, not {vector}")
    return goal


def climb_to(height_m: float, z_m: float) -> float:
    """Vertical speed (m/s) towards a height; the envelope bounds it."""
    return HEIGHT_GAIN * (height_m - z_m)


def towards(target: Vector, position: Vector, speed_m_s: float) -> Vector:
    """Velocity (m/s) that flies to a point and stops there."""
    dx, dy = target[0] - position[0], target[1] - position[1]
    distance = hypot(dx, dy)
    if distance < 1e-9:
        return 0.0, 0.0, climb_to(target[2], position[2])
    speed = min(speed_m_s, CLOSE_GAIN * distance, sqrt(2 * APPROACH_M_S2 * distance))
    return dx / distance * speed, dy / distance * speed, climb_to(target[2], position[2])


def over_ground(
    velocity: Vector, height_m: float, position: Vector, terrain: Terrain, envelope: Envelope
) -> Vector:
    """A velocity (m/s) that follows the ground at a height, slower where that is steep.

    Args:
        velocity: wanted, of which the horizontal part counts.
        height_m: above the ground.
        position: own, ENU m.
        terrain: the ground.
        envelope: gives the limits of climb and sink.
    """
    x, y, z = position
    vx, vy, _ = velocity
    near_s, far_s = GROUND_S
    points = [(x, y), (x + vx * near_s, y + vy * near_s), (x + vx * far_s, y + vy * far_s)]
    here, near, far = terrain.height_at(points).tolist()
    rise = max((near - here) / near_s, (far - here) / far_s)  # m/s, at full speed
    share = 1.0
    if rise > envelope.climb_m_s:
        share = envelope.climb_m_s / rise
    elif rise < -envelope.sink_m_s:
        share = envelope.sink_m_s / -rise
    share = max(share, SLOWEST)
    return vx * share, vy * share, rise * share + climb_to(here + height_m, z)


def wanted(setpoint: Setpoint, position: Vector, height_m: float, envelope: Envelope) -> Vector:
    """The velocity (ENU m/s) that a setpoint asks for at a position.

    Args:
        setpoint: of the planner.
        position: own, ENU m.
        height_m: kept by a FlyVelocity whose vertical part is 0.
        envelope: gives the cruise speed where the setpoint is silent.
    """
    if isinstance(setpoint, FlyVelocity):
        x, y, z = setpoint.velocity.tolist()
        return x, y, z if z else climb_to(height_m, position[2])
    speed = envelope.speed_m_s if setpoint.speed_m_s is None else setpoint.speed_m_s
    if isinstance(setpoint, GoTo):
        x, y, z = setpoint.position.tolist()
        return towards((x, y, z), position, speed)
    return towards(_along(setpoint, position, speed), position, speed)


def _along(segment: FlySegment, position: Vector, speed_m_s: float) -> Vector:
    """The point of the segment a little ahead of the vehicle."""
    x0, y0, z0 = segment.start.tolist()
    x1, y1, z1 = segment.end.tolist()
    dx, dy = x1 - x0, y1 - y0
    length = hypot(dx, dy)
    if length < 1e-9:
        return x1, y1, z1
    done = ((position[0] - x0) * dx + (position[1] - y0) * dy) / length
    share = min(max(done + LOOKAHEAD_S * speed_m_s, 0.0) / length, 1.0)
    return x0 + share * dx, y0 + share * dy, z0 + share * (z1 - z0)
