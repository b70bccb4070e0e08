"""The safety filter of aircraft that cannot stop: turns, climbs and speeds instead of braking.

What is wanted is flown in thought, with the aircraft's limits of bank, climb and acceleration. If
that comes too near to another vehicle, to the ground, the fence or the ceiling, so are some
hundred other courses, climbs and speeds, and the nearest one that keeps clear is taken; if none
does, the one that keeps clearest. Others are taken to fly on straight, for no longer than a flock
does.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sin, tan
from typing import Final

import numpy as np

from planners.types import F64
from uavbridge.safety.envelope import Envelope
from uavbridge.safety.filter import Filtered, Traffic, Vector
from uavbridge.safety.ground import LOW_M

STEP_S: Final = 0.5
AHEAD_S: Final = 10.0  # of ground, fence and ceiling: a half circle at 50 m/s takes as long
MEETING_S: Final = 2.5  # of other vehicles
SPARE_M: Final = 2.0  # beyond the separation, for what others do meanwhile
LEVEL_S: Final = 2.0  # after which a sinking, or a climb to the ceiling, can end
LAG_S: Final = 0.3  # of the bank
BANK_RAD: Final = 0.8
FASTER_M_S2: Final = 4.0
LIFT_M_S2: Final = 4.0
CIRCLE_RAD: Final = 1.2  # a turn that goes on, when asked to stand still
_GRAVITY: Final = 9.80665
_STILL: Final = 0.25  # share of the least speed
_BENDS: Final = np.array(
    (0.0, 0.15, -0.15, 0.35, -0.35, 0.7, -0.7, 1.1, -1.1, 1.6, -1.6, 2.4, -2.4)
)
_PACES: Final = np.array((0.0, -8.0, 8.0))
_TIMES: Final[F64] = np.arange(1.0, AHEAD_S / STEP_S + 1.0) * STEP_S
_MEETINGS: Final = round(MEETING_S / STEP_S)
_LEVELLED: Final = round(LEVEL_S / STEP_S)
_NAMES: Final = ("separation", "ground", "fence", "altitude")
_WEIGHTS: Final = np.array((1e4, 1e3, 1e2, 1e2))  # of a metre too near
_CLEAR_M: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Choices:
    """What could be flown, (k,) each."""

    course: F64  # rad
    climb: F64  # m/s
    speed: F64  # m/s, level


def constrain(
    wanted: Vector,
    position: Vector,
    velocity: Vector,
    traffic: Iterable[Traffic],
    envelope: Envelope,
    *,
    keep_band: bool = True,
) -> Filtered:
    """The velocity nearest to the wanted one that keeps clear.

    A velocity that is hardly one asks for a circle. Arguments as of ``filter.constrain``.
    """
    here = atan2(velocity[1], velocity[0])
    level = hypot(wanted[0], wanted[1])
    still = level < _STILL * envelope.slowest_m_s
    course = here - CIRCLE_RAD if still else atan2(wanted[1], wanted[0])
    speed = min(max(level, envelope.slowest_m_s), envelope.speed_m_s)
    climb = min(max(wanted[2], -envelope.sink_m_s), envelope.climb_m_s)
    bent = ("speed",) if not still and abs(speed - level) > 1e-6 else ()
    others = _near(position, traffic, envelope)
    plain = Choices(*(np.array([value]) for value in (course, climb, speed)))
    floor = envelope.altitude_min_m if keep_band else LOW_M
    lacks = _lacks(plain, position, velocity, others, envelope, floor)[0]
    if not (lacks > _CLEAR_M).any():
        return Filtered(_vector(course, climb, speed), bent)
    choices = _choices(course, climb, speed, envelope)
    worse = _lacks(choices, position, velocity, others, envelope, floor) @ _WEIGHTS
    away = np.abs((choices.course - course + pi) % (2 * pi) - pi)
    change = away + 0.15 * np.abs(choices.climb - climb) + 0.05 * np.abs(choices.speed - speed)
    change += 1e-3 * (np.sin(choices.course - course) > 0.0)  # of two alike, to the right
    best = int(np.argmin(worse + change))
    names = tuple(name for name, lack in zip(_NAMES, lacks, strict=True) if lack > _CLEAR_M)
    chosen = (float(part[best]) for part in (choices.course, choices.climb, choices.speed))
    return Filtered(_vector(*chosen), bent + names)


def _choices(course: float, climb: float, speed: float, e: Envelope) -> Choices:
    climbs = np.array((climb, e.climb_m_s, 0.5 * e.climb_m_s, 0.0, -0.3 * e.sink_m_s, -e.sink_m_s))
    paces = np.clip(speed + _PACES, e.slowest_m_s, e.speed_m_s)
    grid = np.meshgrid(course + _BENDS, climbs, paces, indexing="ij")
    return Choices(*(part.ravel() for part in grid))


def _near(position: Vector, traffic: Iterable[Traffic], e: Envelope) -> tuple[F64, F64]:
    """Positions and velocities (m, 3) of those that could be met."""
    if e.separation_m <= 0.0:
        return np.zeros((0, 3)), np.zeros((0, 3))
    reach = e.separation_m + SPARE_M + 2.0 * (e.speed_m_s + e.climb_m_s) * MEETING_S
    x, y, z = position
    near = [
        other
        for other in traffic
        if hypot(other.position[0] - x, other.position[1] - y, other.position[2] - z) < reach
    ]
    places = np.array([other.position for other in near]).reshape(-1, 3)
    return places, np.array([other.velocity for other in near]).reshape(-1, 3)


def _lacks(
    choices: Choices,
    position: Vector,
    velocity: Vector,
    others: tuple[F64, F64],
    e: Envelope,
    floor_m: float,
) -> F64:
    """Metres (k, 4) that each choice comes too near, as in ``_NAMES``."""
    track = _flown(choices, position, velocity)
    out = np.zeros((len(track), 4))
    places, paces = others
    if len(places):
        meant = places[:, None] + paces[:, None] * _TIMES[:_MEETINGS, None]  # (m, t, 3)
        gap = np.linalg.norm(track[:, None, :_MEETINGS] - meant, axis=-1).min(axis=(1, 2))
        out[:, 0] = np.maximum(e.separation_m + SPARE_M - gap, 0.0)
    ground = np.zeros(1)
    if e.terrain is not None:
        ground = e.terrain.height_at(track)
    above = track[..., 2] - ground
    out[:, 1] = np.maximum(floor_m - above, 0.0).max(axis=1)
    out[:, 3] = np.maximum(above - e.altitude_max_m, 0.0)[:, :_LEVELLED].max(axis=1)
    low, high = np.array((e.west_m, e.south_m)), np.array((e.east_m, e.north_m))
    beyond = np.maximum(low - track[..., :2], track[..., :2] - high)
    out[:, 2] = np.maximum(beyond, 0.0).max(axis=(1, 2))
    return out


def _flown(choices: Choices, position: Vector, velocity: Vector) -> F64:
    """Places (k, t, 3) at ``_TIMES``."""
    here, pace = atan2(velocity[1], velocity[0]), max(hypot(velocity[0], velocity[1]), 1.0)
    off = (choices.course - here + pi) % (2 * pi) - pi
    fastest = _GRAVITY * tan(BANK_RAD) / pace * np.maximum(_TIMES - LAG_S, 0.0)
    turned = off[:, None] * -np.expm1(-np.maximum(_TIMES - LAG_S, 0.0))
    course = here + np.clip(turned, -fastest, fastest)
    most = FASTER_M_S2 * _TIMES
    speed = pace + np.clip(choices.speed[:, None] - pace, -most, most)
    lift = LIFT_M_S2 * _TIMES
    asked = choices.climb[:, None]
    climb = velocity[2] + np.clip(asked - velocity[2], -lift, lift)
    later = LIFT_M_S2 * np.maximum(_TIMES - LEVEL_S, 0.0)  # who sinks can level off
    climb = np.where(asked < 0.0, np.minimum(climb + later, np.maximum(climb, 0.0)), climb)
    steps = np.stack((speed * np.cos(course), speed * np.sin(course), climb), axis=-1)
    first = np.broadcast_to(np.array(velocity), (len(steps), 1, 3))
    before = np.concatenate((first, steps[:, :-1]), axis=1)
    return np.array(position) + np.cumsum((before + steps) * (0.5 * STEP_S), axis=1)


def _vector(course: float, climb: float, speed: float) -> Vector:
    return speed * cos(course), speed * sin(course), climb
