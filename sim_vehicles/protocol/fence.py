"""Geofences as uploaded: polygons and circles, to be kept in or out of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import hypot, isfinite
from typing import Final

from sim_vehicles.codec import mav
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.protocol.items import Item, place

_INCLUSIONS: Final = (
    mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    mav.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
)
_CIRCLES: Final = (
    mav.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
    mav.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
)


@dataclass(frozen=True, slots=True)
class _Area:
    """A polygon, or a circle about its one corner."""

    keep_in: bool
    corners: tuple[tuple[float, float], ...]  # ENU m
    radius_m: float = 0.0

    def holds(self, x: float, y: float) -> bool:
        if self.radius_m > 0:
            return hypot(x - self.corners[0][0], y - self.corners[0][1]) <= self.radius_m
        inside = False
        for (ax, ay), (bx, by) in zip(
            self.corners, self.corners[1:] + self.corners[:1], strict=True
        ):
            if (ay > y) != (by > y) and x < ax + (bx - ax) * (y - ay) / (by - ay):
                inside = not inside
        return inside


def fence(items: Sequence[Item], origin: Geodetic) -> Callable[[float, float, float], bool] | None:
    """A test whether a place (ENU m) is allowed; None: the items do not make areas.

    A place is allowed in any of the areas to be kept in (if there are some), outside all others.
    """
    areas: list[_Area] = []
    at = 0
    while at < len(items):
        item = items[at]
        circle = item.command in _CIRCLES
        size = 1 if circle else round(item.param1) if 3 <= item.param1 < 1e5 else 0
        corners = items[at : at + size]
        radius = item.param1 if circle and isfinite(item.param1) else 0.0
        if len(corners) < max(size, 1) or any(each.command != item.command for each in corners):
            return None
        if circle and radius <= 0:
            return None
        points = tuple(place(corner, origin, 0.0)[:2] for corner in corners)
        areas.append(_Area(item.command in _INCLUSIONS, points, radius))
        at += size
    keep_in = [area for area in areas if area.keep_in]
    keep_out = [area for area in areas if not area.keep_in]

    def allowed(x: float, y: float, z: float) -> bool:
        if keep_in and not any(area.holds(x, y) for area in keep_in):
            return False
        return not any(area.holds(x, y) for area in keep_out)

    return allowed
