"""Between the fleet's ENU metres and the world's latitude, longitude, NED and heading.

Geodetic positions are degrees and metres on WGS84. Heights above mean sea level and
above the ellipsoid are taken as equal: nothing here knows the geoid.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

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
    swapped: F64 = vectors[..., [1, 0, 2]] * np.array([1.0, 1.0, -1.0])
    return swapped


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
