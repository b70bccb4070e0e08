"""Between the fleet's ENU metres and the world's latitude, longitude, NED and heading.

Geodetic positions are degrees and metres on WGS84. Heights above mean sea level and
above the ellipsoid are taken as equal: nothing here knows the geoid.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Final

import numpy as np
import numpy.typing as npt
import pymap3d

from sim_vehicles.dynamics.model import F64


@dataclass(frozen=True, slots=True)
class Geodetic:
    """A place on Earth: degrees north and east, metres above the ellipsoid.

    Raises:
        ValueError: latitude outside -90..90, longitude outside -180..180, or not finite.
    """

    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0

    def __post_init__(self) -> None:
        if not -90.0 <= self.latitude_deg <= 90.0:
            raise ValueError(f"latitude must be -90..90 degrees, not {self.latitude_deg}")
        if not -180.0 <= self.longitude_deg <= 180.0:
            raise ValueError(f"longitude must be -180..180 degrees, not {self.longitude_deg}")
        if not np.isfinite(self.altitude_m):
            raise ValueError(f"altitude must be finite, not {self.altitude_m}")


def to_enu(
    latitude_deg: npt.ArrayLike,
    longitude_deg: npt.ArrayLike,
    altitude_m: npt.ArrayLike,
    origin: Geodetic,
) -> F64:
    """ENU metres (..., 3) from ``origin`` of places of any one shape; longitude may wrap."""
    east, north, up = pymap3d.geodetic2enu(
        np.asarray(latitude_deg, dtype=np.float64),
        np.asarray(longitude_deg, dtype=np.float64),
        np.asarray(altitude_m, dtype=np.float64),
        origin.latitude_deg,
        origin.longitude_deg,
        origin.altitude_m,
    )
    return np.stack([east, north, up], axis=-1).astype(np.float64)


def to_geodetic(enu: npt.ArrayLike, origin: Geodetic) -> tuple[F64, F64, F64]:
    """Latitude (...), longitude (...) in degrees, -180..180, and altitude (...) in metres.

    Args:
        enu: (..., 3) metres from ``origin``.
        origin: where ENU is zero.
    """
    points = np.asarray(enu, dtype=np.float64)
    latitude, longitude, altitude = pymap3d.enu2geodetic(
        points[..., 0],
        points[..., 1],
        points[..., 2],
        origin.latitude_deg,
        origin.longitude_deg,
        origin.altitude_m,
    )
    return (
        np.asarray(latitude, dtype=np.float64),
        np.asarray(longitude, dtype=np.float64),
        np.asarray(altitude, dtype=np.float64),
    )


def ned_from_enu(enu: npt.ArrayLike) -> F64:
    """Vectors (..., 3) north, east, down from east, north, up."""
    vectors = np.asarray(enu, dtype=np.float64)
    ned = np.empty_like(vectors)
    ned[..., 0] = vectors[..., 1]
    ned[..., 1] = vectors[..., 0]
    np.subtract(0.0, vectors[..., 2], out=ned[..., 2])  # not -0.0
    return ned


def enu_from_ned(ned: npt.ArrayLike) -> F64:
    """Vectors (..., 3) east, north, up from north, east, down."""
    return ned_from_enu(ned)  # swapping twice is no change: it is its own inverse


def yaw_ned_from_enu(yaw_rad: npt.ArrayLike) -> F64:
    """Heading from north, clockwise, in [-pi, pi), from yaw from east, counter-clockwise."""
    heading: F64 = (1.5 * pi - np.asarray(yaw_rad, dtype=np.float64)) % (2 * pi) - pi
    return heading


def yaw_enu_from_ned(heading_rad: npt.ArrayLike) -> F64:
    """Yaw from east, counter-clockwise, in [-pi, pi), from heading from north, clockwise."""
    return yaw_ned_from_enu(heading_rad)  # the same reflection


class LocalGeodesy:
    """``to_geodetic`` for places near an origin, about ten times quicker.

    A polynomial of third order in east, north and up, fitted to pymap3d's answers when made;
    within 1 mm of them up to REACH_M from the origin. Farther places, or origins near a pole,
    go to pymap3d itself.
    """

    REACH_M: Final = 10_000.0
    _POLAR_DEG: Final = 70.0

    def __init__(self, origin: Geodetic) -> None:
        self._origin = origin
        nodes = np.cos(np.pi * (np.arange(8) + 0.5) / 8)  # Chebyshev's
        cube = np.stack(np.meshgrid(nodes, nodes, nodes), axis=-1).reshape(-1, 3)
        values = np.stack(to_geodetic(cube * self.REACH_M, origin), axis=-1)
        self._zero = np.array([origin.latitude_deg, origin.longitude_deg, origin.altitude_m])
        offsets = values - self._zero
        offsets[:, 1] = (offsets[:, 1] + 180.0) % 360.0 - 180.0
        self._weights: F64 = np.linalg.lstsq(_monomials(cube), offsets)[0]  # (20, 3)

    def to_geodetic(self, enu: F64) -> F64:
        """Latitude, longitude (degrees) and altitude (m) as columns (k, 3) of ENU m (k, 3)."""
        scaled = enu / self.REACH_M
        if not np.abs(scaled).max(initial=0.0) <= 1.0 or self._polar:
            return np.stack(to_geodetic(enu, self._origin), axis=-1)
        places: F64 = _monomials(scaled) @ self._weights + self._zero
        if self._near_date_line:
            places[:, 1] = (places[:, 1] + 180.0) % 360.0 - 180.0
        return places

    @property
    def _polar(self) -> bool:
        return abs(self._origin.latitude_deg) > self._POLAR_DEG

    @property
    def _near_date_line(self) -> bool:
        return abs(self._origin.longitude_deg) > 179.0


def _monomials(points: F64) -> F64:
    """All products of up to three of x, y, z: (k, 20) of points (k, 3)."""
    terms = np.empty((len(points), 20))
    terms[:, 0] = 1.0
    terms[:, 1:4] = points
    np.multiply(points[:, :1], points, out=terms[:, 4:7])  # xx xy xz
    np.multiply(points[:, 1:2], points[:, 1:], out=terms[:, 7:9])  # yy yz
    np.multiply(points[:, 2], points[:, 2], out=terms[:, 9])  # zz
    np.multiply(points[:, :1], terms[:, 4:10], out=terms[:, 10:16])
    np.multiply(points[:, 1:2], terms[:, 7:10], out=terms[:, 16:19])
    np.multiply(points[:, 2], terms[:, 9], out=terms[:, 19])
    return terms
