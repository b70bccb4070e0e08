"""The safety filter: the velocity nearest to the wanted one that breaks no rule.

Every rule is a half-space ``n . v <= c`` of the velocity: towards a fence or the
end of the altitude band no faster than can be stopped in time, towards another
vehicle no faster than one's own share of what both can stop in time, counting
what they fly before a setpoint takes effect. While there is time to stop, every c
is at least 0, standing still satisfies all of them, and so a safe velocity
exists; if each vehicle keeps its share, no pair comes nearer than the separation
distance (a control barrier function).

Plain floats: the sets are tiny, and numpy would cost ten times as much.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import hypot, sqrt
from typing import NamedTuple, TypeAlias

from uavbridge.safety import ground
from uavbridge.safety.envelope import DRIFT_M, Envelope
from uavbridge.safety.half_space import HalfSpace, Vector

__all__ = ["Filtered", "HalfSpace", "Traffic", "Vector", "constrain"]

Wall: TypeAlias = tuple[float, float, float, float, float]  # normal, room to it, speed towards it

ROUNDS = 8  # of cyclic projection; what is left over is scaled away
SIDESTEP = 0.5  # share of a blocked approach that goes to the right instead
TOUCHING_M = 1e-6
ABOVE_M = 5.0  # so much higher than the distance to be kept, a vehicle is none of a rover's
BENT_M_S = 1e-3  # a difference of velocities that counts


class Traffic(NamedTuple):
    """Another vehicle, where it is believed to be now (ENU m, m/s)."""

    agent: int
    position: Vector
    velocity: Vector


class Filtered(NamedTuple):
    """A safe velocity and what bent it."""

    velocity: Vector
    limited_by: tuple[str, ...]  # "speed", "fence", "altitude", "separation", "ground", "obstacle"


def constrain(
    wanted: Vector,
    position: Vector,
    velocity: Vector,
    traffic: Iterable[Traffic],
    envelope: Envelope,
    *,
    keep_band: bool = True,
) -> Filtered:
    """Bend a wanted velocity so that it keeps the envelope.

    Args:
        wanted: ENU m/s.
        position: own, ENU m.
        velocity: own, as flown now, ENU m/s.
        traffic: the others, as last heard and carried forward to now.
        envelope: the rules.
        keep_band: False on the way up from or down to the ground, where the
            lower end of the altitude band does not hold.
    """
    if envelope.drives:
        return _on_ground(wanted, position, velocity, traffic, envelope)
    named = [("fence", rule) for rule in _fence(position, velocity, envelope)]
    named += _heights(position, velocity, envelope, keep_band)
    separation = _separation(position, velocity, traffic, envelope)
    named += [("separation", rule) for rule, _ in separation]
    columns = _columns(position, velocity, envelope)
    named += [("obstacle", rule) for rule, _ in columns]
    limited = [name for name, rule in named if rule.along(wanted) > rule.limit + 1e-9]
    slow = _limit_speed(wanted, envelope)
    if slow != wanted:
        limited.append("speed")
    rules = [rule for _, rule in named]
    aim = _sidestep(slow, separation + columns)
    if envelope.terrain is None:
        safe = _project(aim, rules, envelope)
    else:
        safe, bent = _over_ground(aim, position, velocity, rules, envelope, keep_band)
        limited += ["ground"] if bent else []
    return Filtered(safe, tuple(dict.fromkeys(limited)))


def _on_ground(
    wanted: Vector, position: Vector, velocity: Vector, traffic: Iterable[Traffic], e: Envelope
) -> Filtered:
    """All rules in the plane; who flies above keeps apart by itself."""
    here, going = _level(position), _level(velocity)
    care, above = e.care_m, e.separation_m + ABOVE_M
    x, y, z = position
    others = [
        Traffic(one.agent, _level(one.position), _level(one.velocity))
        for one in traffic
        if abs(one.position[0] - x) <= care
        and abs(one.position[1] - y) <= care
        and abs(one.position[2] - z) < above
    ]
    separation = _separation(here, going, others, e)
    named = [("fence", rule) for rule in _fence(here, going, e)]
    named += [("separation", rule) for rule, _ in separation]
    columns = _columns(here, going, e)
    named += [("obstacle", rule) for rule, _ in columns]
    asked = _level(wanted)
    limited = [name for name, rule in named if rule.along(asked) > rule.limit + 1e-9]
    rules = [rule for _, rule in named]
    free = _project(_sidestep(_limit_speed(asked, e), separation + columns), rules, e)
    safe = ground.drivable(free, position, velocity, e)
    limited += ["speed"] if hypot(asked[0], asked[1]) > e.speed_m_s else []
    limited += ["ground"] if safe != free else []
    return Filtered(_level(safe), tuple(dict.fromkeys(limited)))


def _level(vector: Vector) -> Vector:
    return vector[0], vector[1], 0.0


def _over_ground(
    aim: Vector,
    position: Vector,
    velocity: Vector,
    rules: list[HalfSpace],
    e: Envelope,
    keep_band: bool,
) -> tuple[Vector, bool]:
    """A velocity that keeps the rules and leads over the ground, and whether that bent it."""
    clearance = e.altitude_min_m if keep_band else ground.LOW_M
    first = _project(aim, rules, e)
    safe = ground.above(first, position, velocity, e, clearance)
    if safe == first:
        return safe, False
    again = _project(safe, rules, e)
    over = ground.above(again, position, velocity, e, clearance)
    if hypot(over[0] - again[0], over[1] - again[1]) < BENT_M_S and over[2] <= again[2] + BENT_M_S:
        return again, True
    pushed = _project((0.0, 0.0, max(over[2], 0.0)), rules, e)
    return ground.above(pushed, position, velocity, e, clearance), True  # whoever pushes


def _fence(position: Vector, velocity: Vector, e: Envelope) -> list[HalfSpace]:
    x, y, _ = position
    vx, vy, _ = velocity
    far = _stop_m(e.speed_m_s, e) + e.braking.latency_s * max(abs(vx), abs(vy)) + DRIFT_M
    if e.west_m + far < x < e.east_m - far and e.south_m + far < y < e.north_m - far:
        return []
    walls = (
        (1.0, 0.0, 0.0, e.east_m - DRIFT_M - x, vx),
        (-1.0, 0.0, 0.0, x - e.west_m - DRIFT_M, -vx),
        (0.0, 1.0, 0.0, e.north_m - DRIFT_M - y, vy),
        (0.0, -1.0, 0.0, y - e.south_m - DRIFT_M, -vy),
    )
    return _near(walls, e.speed_m_s, e)


def _heights(
    position: Vector, velocity: Vector, e: Envelope, keep_band: bool
) -> list[tuple[str, HalfSpace]]:
    if e.terrain is None:
        band = _band(position[2], velocity[2], e, keep_band)
        return [("altitude", rule) for rule in band]
    named = [("altitude", rule) for rule in ground.ceiling(position, velocity, e)]
    if keep_band:
        floor = ground.floor(position, velocity, e, e.altitude_min_m)
        named += [("ground", rule) for rule in floor]
    return named


def _band(z: float, vz: float, e: Envelope, keep_band: bool) -> list[HalfSpace]:
    rules = _near([(0.0, 0.0, 1.0, e.altitude_max_m - z, vz)], e.climb_m_s, e)
    if keep_band:
        rules += _near([(0.0, 0.0, -1.0, z - e.altitude_min_m, -vz)], e.sink_m_s, e)
    return rules


def _near(walls: Iterable[Wall], top_m_s: float, e: Envelope) -> list[HalfSpace]:
    """Rules for the walls that matter: from the others any allowed speed can be stopped in time."""
    braking, stop_m = e.braking, _stop_m(top_m_s, e)
    return [
        HalfSpace(x, y, z, braking.approach_speed(room_m, closing_m_s))
        for x, y, z, room_m, closing_m_s in walls
        if room_m - max(closing_m_s, 0.0) * braking.latency_s < stop_m
    ]


def _stop_m(speed_m_s: float, e: Envelope) -> float:
    """Way to a stop from a speed, without what is flown before braking begins."""
    return speed_m_s * speed_m_s / (2 * e.braking.brake_m_s2)


def _separation(
    position: Vector, velocity: Vector, traffic: Iterable[Traffic], e: Envelope
) -> list[tuple[HalfSpace, Vector]]:
    """A rule per vehicle that matters, and the horizontal direction that passes it on the right."""
    care = e.care_m
    px, py, pz = position
    rules = []
    for other in traffic:
        ox, oy, oz = other.position
        dx, dy, dz = ox - px, oy - py, oz - pz
        if abs(dx) > care or abs(dy) > care:  # most of a large fleet
            continue
        distance = sqrt(dx * dx + dy * dy + dz * dz)
        if distance > care:
            continue
        if distance < TOUCHING_M:  # the same point: any direction will do, up is free
            dx, dy, dz, distance = 0.0, 0.0, -1.0, 1.0
        x, y, z = dx / distance, dy / distance, dz / distance
        vx, vy, vz = other.velocity
        closing = (velocity[0] - vx) * x + (velocity[1] - vy) * y + (velocity[2] - vz) * z
        limit = e.braking.share_speed(distance - e.separation_m, closing)
        flat = hypot(x, y)
        right = (y / flat, -x / flat, 0.0) if flat > 0.2 else (0.0, 0.0, 0.0)
        rules.append((HalfSpace(x, y, z, limit), right))
    return rules


def _columns(position: Vector, velocity: Vector, e: Envelope) -> list[tuple[HalfSpace, Vector]]:
    """A rule per column that matters, and the direction that passes it on the right."""
    rules = []
    for x, y, radius_m in e.columns:
        dx, dy = x - position[0], y - position[1]
        distance = hypot(dx, dy)
        if distance < TOUCHING_M:  # on its axis: any way out will do
            dx, dy, distance = 1.0, 0.0, 1.0
        nx, ny = dx / distance, dy / distance
        closing = velocity[0] * nx + velocity[1] * ny
        room_m = hypot(x - position[0], y - position[1]) - radius_m - DRIFT_M
        near = _near([(nx, ny, 0.0, room_m, closing)], e.speed_m_s, e)
        rules += [(rule, (ny, -nx, 0.0)) for rule in near]
    return rules


def _sidestep(wanted: Vector, separation: list[tuple[HalfSpace, Vector]]) -> Vector:
    """Turn part of a blocked approach to the right, so that two head-on do not stand still."""
    x, y, z = wanted
    for rule, right in separation:
        excess = rule.along(wanted) - max(rule.limit, 0.0)
        if excess > 0:
            x += SIDESTEP * excess * right[0]
            y += SIDESTEP * excess * right[1]
    return x, y, z


def _limit_speed(v: Vector, e: Envelope) -> Vector:
    x, y, z = v
    speed = hypot(x, y)
    if speed > e.speed_m_s:
        x, y = x * e.speed_m_s / speed, y * e.speed_m_s / speed
    return x, y, min(max(z, -e.sink_m_s), e.climb_m_s)


def _project(wanted: Vector, rules: list[HalfSpace], e: Envelope) -> Vector:
    vx, vy, vz = _limit_speed(wanted, e)
    for _ in range(ROUNDS):
        moved = False
        for x, y, z, limit in rules:
            excess = x * vx + y * vy + z * vz - limit
            if excess > 1e-9:
                vx, vy, vz = vx - excess * x, vy - excess * y, vz - excess * z
                moved = True
        vx, vy, vz = _limit_speed((vx, vy, vz), e)
        if not moved:
            return vx, vy, vz
    return _scale_down((vx, vy, vz), rules)


def _scale_down(v: Vector, rules: list[HalfSpace]) -> Vector:
    """Towards standing still until every rule with c >= 0 holds: exact, if not the nearest."""
    scale = 1.0
    for rule in rules:
        along = rule.along(v)
        if rule.limit >= 0 and along > rule.limit:
            scale = min(scale, rule.limit / along)
    return v[0] * scale, v[1] * scale, v[2] * scale
