"""Between an autopilot's own local NED frame and the mission's ENU frame.

The autopilot's frame has its origin where its estimator started, metres to
kilometres from the mission's home and at another height. Both frames are
Cartesian, so one turns into the other by a rotation (small: the curve of the
Earth between the two origins) and a shift, computed once.
"""

from __future__ import annotations

from math import pi, tau

import numpy as np

from sim_vehicles.geodesy import Geodetic, enu_from_ned, to_enu, to_geodetic

_ARM_M = 1000.0  # length of the probes that measure the rotation


def heading_to_yaw(heading_rad: float) -> float:
    """Yaw from east, counter-clockwise, from heading from north, clockwise; and back.

    The result is in [-pi, pi).
    """
    return (1.5 * pi - heading_rad) % tau - pi


def shifted(origin: Geodetic, ned: tuple[float, float, float]) -> Geodetic:
    """The place (north, east, down) metres from ``origin``."""
    latitude, longitude, altitude = to_geodetic(enu_from_ned(np.array(ned)), origin)
    return Geodetic(float(latitude), float(longitude), float(altitude))


class LocalFrame:
    """An autopilot's local frame as seen from the mission's.

    Args:
        local: where the autopilot's local coordinates are zero.
        mission: where the mission's are.
    """

    __slots__ = ("_rows", "_shift", "local")

    def __init__(self, local: Geodetic, mission: Geodetic) -> None:
        self.local = local
        # ENU of nothing, north, east, down
        probes = _ARM_M * np.array(
            [[0.0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, -1]]
        )  # ENU of N, E, D
        places = to_enu(*to_geodetic(probes, local), mission)
        columns = (places[1:] - places[0]) / _ARM_M  # of north, east, down
        self._shift: tuple[float, float, float] = tuple(places[0].tolist())
        self._rows: list[list[float]] = columns.T.tolist()

    def velocity_to_mission(self, n: float, e: float, d: float) -> tuple[float, float, float]:
        """ENU m/s of a local NED velocity."""
        x, y, z = self._rows
        return (
            x[0] * n + x[1] * e + x[2] * d,
            y[0] * n + y[1] * e + y[2] * d,
            z[0] * n + z[1] * e + z[2] * d,
        )

    def to_mission(self, n: float, e: float, d: float) -> tuple[float, float, float]:
        """Mission ENU metres of a local NED position."""
        x, y, z = self.velocity_to_mission(n, e, d)
        sx, sy, sz = self._shift
        return x + sx, y + sy, z + sz

    def velocity_to_local(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        """Local NED m/s of an ENU velocity."""
        a, b, c = self._rows
        return (
            a[0] * x + b[0] * y + c[0] * z,
            a[1] * x + b[1] * y + c[1] * z,
            a[2] * x + b[2] * y + c[2] * z,
        )

    def to_local(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        """Local NED metres of a mission ENU position."""
        sx, sy, sz = self._shift
        return self.velocity_to_local(x - sx, y - sy, z - sz)
