"""3D-COTA: first and second tracking of the ground, and the step along it.

Zhou 2023, sections 4.3 and 4.4, Eqs. (10)-(29). All functions take leading
axes: one robot, a team, or the teams of many runs.

    first    V_o: tangent to the plane through the three nearest obstacle points    (12)-(21)
    second   V_t: V_o turned to the nearest heading that does not climb above beta  (22)-(27)
    step     V: V_t with the rise that the ground has                               (28), (29)

| symbol | name |
| --- | --- |
| V_e, V_o, V_t, V | the arguments and values of the functions, in this order |
| a, b, c | ``Plane.a``, ``Plane.b``, ``Plane.c`` |
| Fs | ``Terrain.height_at`` |
| Delta l, n_phi, beta | ``lattice_m``, ``directions``, ``climb_rad`` |

DEVIATION: sign(0) = +1 in Eq. (13), or the three points fall together.
DEVIATION: atan2 for the arctan of Eq. (25), which sends y = 0, x < 0 to 0.
DEVIATION: phi_0 of Eq. (26) is the heading that attains the minimum; as printed
it is the difference of two headings, used as a heading in Eq. (27).

Readings: a heading is in Theta when some point of its ray, every ``lattice_m``
and at the end, lies above the robot by more than beta (uphill only, Eq. (11)),
or when the ray ends outside the bounds. Where every heading is in Theta the
robot stays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from planners.terrain import Terrain
from planners.types import F64, Bools

Bounds = tuple[float, float, float, float]  # west, south, east, north in m

_NEAR = 24  # directions tried first on either side


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Normal of the plane fl through the nearest obstacle points, Eq. (15); c is never 0."""

    a: F64  # (...)
    b: F64
    c: F64

    def rise(self, vx: F64, vy: F64) -> F64:
        """The upward part that makes a horizontal velocity tangent, Eqs. (19) and (27)."""
        return np.asarray(-(self.a * vx + self.b * vy) / self.c)


def ground_plane(position: npt.ArrayLike, terrain: Terrain, lattice_m: float = 1.0) -> Plane:
    """Plane through the obstacle point nearest to each robot and two beside it, Eqs. (12)-(18).

    Args:
        position: (..., 2 or more) ENU m.
        terrain: the ground; obstacle points lie on it, ``lattice_m`` apart.
        lattice_m: Delta l, m.
    """
    xy = np.asarray(position, dtype=np.float64)[..., :2]
    k0 = np.floor(xy / lattice_m + 0.5) * lattice_m  # eq. (12)
    step = -lattice_m * np.where(k0 >= xy, 1.0, -1.0)  # eq. (13)
    x, y, dx, dy = k0[..., 0], k0[..., 1], step[..., 0], step[..., 1]
    places = np.stack((x, x + dx, x, y, y, y + dy), axis=-1)
    points = np.stack((places[..., :3], places[..., 3:]), axis=-1)
    z = terrain.height_at(points)
    p1, p2 = z[..., 1] - z[..., 0], z[..., 2] - z[..., 0]  # eq. (16)
    return Plane(-dy * p1, -dx * p2, dx * dy)  # eq. (18)


def track_surface(
    expected: npt.ArrayLike,
    plane: Plane,
    speed_m: float | F64,
    full_speed: npt.ArrayLike,
) -> F64:
    """First tracking: V_o, tangent to the ground, Eqs. (19)-(21).

    Keeps the heading; what ``expected`` climbs does not count.

    Args:
        expected: (..., 3) V_e, m a step.
        plane: of ``ground_plane`` at the robots, (...).
        speed_m: (...) Vm, m a step.
        full_speed: (...) which robots roam: they move at Vm, Eq. (20); others at most, Eq. (21).

    Returns:
        (..., 3) m a step, of the leading axes of all arguments broadcast. What has no
        horizontal part stays zero.

    On ground that rises to the east by 1 in 2 a robot roams east at 10 m a step:

    >>> from planners.terrain import Terrain
    >>> hillside = Terrain(0.0, 0.0, 100.0, np.array([[0.0, 0.0], [50.0, 50.0]]))
    >>> plane = ground_plane([20.0, 50.0, 10.0], hillside)
    >>> track_surface([3.0, 0.0, 0.0], plane, 10.0, full_speed=True).round(3)
    array([8.944, 0.   , 4.472])
    """
    wished = np.asarray(expected, dtype=np.float64)
    vx, vy, vz = np.broadcast_arrays(
        wished[..., 0], wished[..., 1], plane.rise(wished[..., 0], wished[..., 1])
    )
    speed = np.sqrt(vx * vx + vy * vy + vz * vz)
    scaled = np.asarray(full_speed) | (speed > speed_m)
    factor = np.where(scaled & (speed > 0.0), speed_m / np.where(speed > 0.0, speed, 1.0), 1.0)
    return np.stack((vx, vy, vz), axis=-1) * factor[..., None]


def avoid_steep(
    velocity: npt.ArrayLike,
    position: npt.ArrayLike,
    plane: Plane,
    terrain: Terrain,
    climb_rad: float,
    *,
    bounds: Bounds | None = None,
    directions: int = 360,
    lattice_m: float = 1.0,
) -> F64:
    """Second tracking: V_t, Eqs. (22)-(27).

    Looks one step ahead and no further: a robot goes round what is steep by being turned
    step by step, and may stay in a bay of it.

    Args:
        velocity: (..., 3) V_o, m a step.
        position: (..., 3) ENU m, on the ground.
        plane: of ``ground_plane`` at the robots, (...).
        terrain: the ground.
        climb_rad: beta; slopes down count for nothing.
        bounds: west, south, east, north in ENU m that no step may leave.
        directions: n_phi, how many headings are tried.
        lattice_m: Delta l, m, between the points that are looked at.

    Returns:
        (..., 3) m a step, a new array: V_o itself where its own heading climbs no steeper
        than beta, else turned to the nearest heading that does; zero where none does.

    Raises:
        ValueError: a velocity is not finite, or the shapes do not broadcast.

    A robot before a wall to the east, then one that drives along it:

    >>> from planners.terrain import Terrain
    >>> heights = np.zeros((101, 101))
    >>> heights[56:] = 50.0
    >>> wall = Terrain(0.0, 0.0, 1.0, heights)
    >>> place = np.array([50.0, 50.0, 0.0])
    >>> plane = ground_plane(place, wall)
    >>> ahead = np.array([[10.0, 0.0, 0.0], [0.0, 10.0, 0.0]])
    >>> turned = avoid_steep(ahead, place, plane, wall, climb_rad=np.radians(30.0))
    >>> np.degrees(np.arctan2(turned[:, 1], turned[:, 0])).round(), np.hypot(*turned[:, :2].T)
    (array([-60.,  90.]), array([10., 10.]))
    """
    wished, places = np.broadcast_arrays(
        np.asarray(velocity, dtype=np.float64), np.asarray(position, dtype=np.float64)
    )
    lead = wished.shape[:-1]
    out = wished.reshape(-1, 3).copy()
    if not np.isfinite(out).all():
        raise ValueError("avoid_steep: velocities must be finite")
    here = places.reshape(-1, 3)
    reach = np.hypot(out[:, 0], out[:, 1])
    ground = _Ground(terrain, climb_rad, bounds, lattice_m)
    heading = np.arctan2(out[:, 1], out[:, 0])  # eq. (25)
    blocked = np.flatnonzero(ground.theta(here, heading[:, None], reach)[:, 0] & (reach > 0.0))
    for rank in _ranks(directions) if len(blocked) else ():
        turned, free = _nearest(ground, here, heading, reach, blocked, rank, directions)
        done = blocked[free]
        a, b, c = (np.broadcast_to(part, lead).reshape(-1)[done] for part in _parts(plane))
        vx, vy = reach[done] * np.cos(turned[free]), reach[done] * np.sin(turned[free])  # eq. (27)
        out[done] = np.stack((vx, vy, Plane(a, b, c).rise(vx, vy)), axis=-1)
        blocked = blocked[~free]
        if not len(blocked):
            break
    out[blocked] = 0.0
    return out.reshape(*lead, 3)


def advance(position: npt.ArrayLike, velocity: npt.ArrayLike, terrain: Terrain) -> tuple[F64, F64]:
    """Velocity (..., 3) with the rise of the ground, Eq. (28), and the new position, Eq. (29)."""
    here = np.asarray(position, dtype=np.float64)
    xy = here[..., :2] + np.asarray(velocity, dtype=np.float64)[..., :2]
    there = np.concatenate((xy, terrain.height_at(xy)[..., None]), axis=-1)
    return there - here, there


def reflected(position: F64, velocity: F64, bounds: Bounds, reading: str) -> F64:
    """Expected velocities (..., 3) at the boundary, on which the paper is silent.

    ``"reflect"`` turns the part that would cross; ``"clip"`` cuts it at the boundary.
    """
    low, high = np.array(bounds[:2]), np.array(bounds[2:])
    here, part = position[..., :2], velocity[..., :2]
    there = here + part
    if reading == "clip":
        part = np.clip(there, low, high) - here
    else:
        part = np.where((there < low) | (there > high), -part, part)
    return np.concatenate((part, velocity[..., 2:]), axis=-1)


@dataclass(frozen=True, slots=True)
class _Ground:
    terrain: Terrain
    climb_rad: float
    bounds: Bounds | None
    lattice_m: float

    def theta(self, position: F64, heading: F64, reach: F64) -> Bools:
        """Which headings (n, k) from positions (n, 3) are in Theta, within reach (n,)."""
        longest = float(reach.max(initial=0.0))
        steps = self.lattice_m * np.arange(1, max(int(np.ceil(longest / self.lattice_m)), 1) + 1)
        along = np.minimum(steps, reach[:, None])  # (n, s), the last ones at the end
        ray = along[:, None, :]
        x = position[:, 0, None, None] + np.cos(heading)[..., None] * ray
        y = position[:, 1, None, None] + np.sin(heading)[..., None] * ray
        rise = self.terrain.height_at(np.stack((x, y), axis=-1)) - position[:, 2, None, None]
        steep: Bools = (rise > np.tan(self.climb_rad) * ray + 1e-9).any(axis=-1)  # eq. (11)
        if self.bounds is None:
            return steep
        west, south, east, north = self.bounds
        end_x, end_y = x[..., -1], y[..., -1]
        slack = 1e-9 * (1.0 + max(abs(part) for part in self.bounds))
        out = (end_x < west - slack) | (end_x > east + slack)
        return np.asarray(steep | out | (end_y < south - slack) | (end_y > north + slack))


def _parts(plane: Plane) -> tuple[F64, F64, F64]:
    return plane.a, plane.b, plane.c


def _ranks(directions: int) -> list[F64]:
    """Offsets from the nearest direction of Phi, near ones first, in two lots."""
    order = np.argsort(abs(_signed(directions)), kind="stable")
    offsets = _signed(directions)[order].astype(np.float64)
    return [offsets[: 2 * _NEAR + 1], offsets[2 * _NEAR + 1 :]]


def _signed(directions: int) -> F64:
    return np.asarray(np.arange(directions) - (directions - 1) // 2, dtype=np.float64)


def _nearest(
    ground: _Ground,
    here: F64,
    heading: F64,
    reach: F64,
    rows: np.ndarray[tuple[int], np.dtype[np.int64]],
    offsets: F64,
    directions: int,
) -> tuple[F64, Bools]:
    """The free direction of Phi nearest to the heading (rows,), and whether there is one."""
    if not len(offsets):
        return np.zeros(len(rows)), np.zeros(len(rows), np.bool_)
    unit = 2.0 * np.pi / directions
    number = np.round(heading[rows] / unit)
    phi = (number[:, None] + offsets) * unit
    turn = abs(phi - heading[rows, None])
    turn = np.minimum(turn, 2.0 * np.pi - turn)  # |F(phi - phi_n)|, eqs. (22), (26)
    theta = ground.theta(here[rows], phi, reach[rows])
    pick = np.where(theta, np.inf, turn).argmin(axis=-1)
    best = np.take_along_axis(phi, pick[:, None], axis=-1)[:, 0]
    free = ~np.take_along_axis(theta, pick[:, None], axis=-1)[:, 0]
    return best, free
