"""The ground as a rule: no setpoint into it, and for what drives none onto slopes too steep.

In the air a vehicle may go on towards rising ground at a speed from which it stops in
time, or faster as long as it climbs so that it is above the ground by its clearance
wherever it gets to. The filter adds that climb, and where there is not enough takes
speed away. What lies to either side of the way is left to the next control ticks.
"""

from __future__ import annotations

from math import ceil, hypot, inf, sqrt

import numpy as np

from planners.terrain import Terrain
from planners.types import F64
from uavbridge.safety.envelope import Envelope
from uavbridge.safety.half_space import HalfSpace, Vector

LOW_M = 2.0  # clearance on the way up from or down to the ground
MOST_POINTS = 60  # of one look ahead
STILL_M_S = 0.05
CLIMB_SHARE = 0.9  # of the climb limit that is counted on
DRIVEN_M = 0.5  # between two points looked at on the ground
SPARE_M = 2.0  # before ground too steep, where a vehicle that drives stops


def floor(position: Vector, velocity: Vector, e: Envelope, clearance_m: float) -> list[HalfSpace]:
    """The rule of the ground's own plane below a vehicle in the air."""
    assert e.terrain is not None
    room_m = position[2] - float(e.terrain.height_at(position)) - clearance_m
    stop_m = e.braking.stopping(hypot(*velocity) + e.sink_m_s)
    if room_m > stop_m + 50.0:
        return []
    gx, gy = e.terrain.gradient_at(position).tolist()
    size = sqrt(gx * gx + gy * gy + 1.0)
    x, y, z = gx / size, gy / size, -1.0 / size
    closing = x * velocity[0] + y * velocity[1] + z * velocity[2]
    return [HalfSpace(x, y, z, e.braking.approach_speed(room_m / size, closing))]


def ceiling(position: Vector, velocity: Vector, e: Envelope) -> list[HalfSpace]:
    """No climb beyond the band; where the ground falls away below, no sinking is asked for."""
    assert e.terrain is not None
    room_m = float(e.terrain.height_at(position)) + e.altitude_max_m - position[2]
    limit = max(e.braking.approach_speed(room_m, velocity[2]), 0.0)
    return [HalfSpace(0.0, 0.0, 1.0, limit)] if limit < e.climb_m_s else []


def above(
    wanted: Vector, position: Vector, velocity: Vector, e: Envelope, clearance_m: float
) -> Vector:
    """The velocity wanted, slowed down and made to climb so that it leads over the ground."""
    assert e.terrain is not None
    x, y, z = wanted
    speed = hypot(x, y)
    most_climb = CLIMB_SHARE * e.climb_m_s
    needed = -inf  # climb, m/s
    if speed > STILL_M_S:
        along, rise = _ahead(e.terrain, position, (x, y), e.braking.stopping(speed), clearance_m)
        share, needed = _climb(along, rise, speed, most_climb, e)
        x, y = x * share, y * share
    flown = hypot(velocity[0], velocity[1])
    if flown > STILL_M_S:
        reach = e.braking.stopping(flown)
        along, rise = _ahead(e.terrain, position, velocity, reach, clearance_m)
        up = rise > 0.0
        if up.any():
            needed = max(needed, float((rise[up] * flown / along[up]).max()))
    return x, y, max(z, min(needed, e.climb_m_s))


def _climb(
    along: F64, rise: F64, speed: float, most_climb: float, e: Envelope
) -> tuple[float, float]:
    """Share of the speed, and climb (m/s; -inf: none), that lead over the points ahead."""
    up = rise > 0.0
    if not up.any():
        return 1.0, -inf
    along, rise = along[up], rise[up]
    stops = np.array([max(e.braking.approach_speed(far, speed), 0.0) for far in along.tolist()])
    goes = max(min(speed, float(np.maximum(stops, along * most_climb / rise).min())), 0.0)
    fast = stops < goes
    needed = float((rise[fast] * goes / along[fast]).max()) if fast.any() else -inf
    return goes / speed, needed


def drivable(wanted: Vector, position: Vector, velocity: Vector, e: Envelope) -> Vector:
    """The velocity wanted on the ground, stopped in time before slopes above ``steepest_rad``."""
    speed = hypot(wanted[0], wanted[1])
    if e.terrain is None or speed <= STILL_M_S:
        return wanted
    reach = e.braking.stopping(speed) + SPARE_M
    along, points = _line(e.terrain, position, wanted, reach, DRIVEN_M)
    steep = e.terrain.slope_at(points) > e.steepest_rad
    if not steep.any() or float(e.terrain.slope_at(position)) > e.steepest_rad:
        return wanted  # nothing in the way, or it stands on such a slope and may leave
    room_m = float(along[steep.argmax()]) - SPARE_M
    closing = (velocity[0] * wanted[0] + velocity[1] * wanted[1]) / speed
    share = min(max(e.braking.approach_speed(room_m, closing), 0.0) / speed, 1.0)
    return wanted[0] * share, wanted[1] * share, wanted[2]


def _ahead(
    terrain: Terrain,
    position: Vector,
    way: tuple[float, ...],
    reach_m: float,
    clearance_m: float,
) -> tuple[F64, F64]:
    """Distances (k,) ahead, and how much higher (k,) in m a vehicle must be there."""
    along, points = _line(terrain, position, way, reach_m)
    return along, terrain.height_at(points) + clearance_m - position[2]


def _line(
    terrain: Terrain,
    position: Vector,
    way: tuple[float, ...],
    reach_m: float,
    spacing_m: float = inf,
) -> tuple[F64, F64]:
    spacing_m = min(spacing_m, 0.5 * terrain.cell_m)
    count = min(max(ceil(reach_m / spacing_m), 2), MOST_POINTS)
    along = np.arange(1, count + 1, dtype=np.float64) * (reach_m / count)
    x, y = way[0], way[1]
    speed = hypot(x, y)
    points = np.array((position[0], position[1])) + along[:, None] * ((x / speed, y / speed),)
    return along, points
