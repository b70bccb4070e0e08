"""Ground heights on a square lattice, bilinear between its points.

The one terrain of the project: planners, the simulator, the safety filter and
experiments ask the same object. Heights are ENU metres, ``heights[column, row]``
over the point ``(west_m + column * cell_m, south_m + row * cell_m)``. All
queries take points (..., 2 or more), of which only x and y count, and answer
for every vehicle at once; outside the lattice the nearest edge counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.random import Generator

_F64 = npt.NDArray[np.float64]
_BLOCK = 1 << 16  # points looked up at once in a line of sight


@dataclass(frozen=True, slots=True, eq=False)
class Terrain:
    """South-western lattice point (ENU m), spacing (m) and heights (columns, rows) in m.

    Raises:
        ValueError: heights or the corner are not finite, heights are fewer than 2 x 2, or the
            spacing is not positive.
    """

    west_m: float
    south_m: float
    cell_m: float
    heights: _F64

    def __post_init__(self) -> None:
        if not (np.isfinite(self.cell_m) and self.cell_m > 0.0):
            raise ValueError(f"terrain: the spacing must be positive, not {self.cell_m}")
        if not (np.isfinite(self.west_m) and np.isfinite(self.south_m)):
            raise ValueError(f"terrain: lies at no place ({self.west_m}, {self.south_m})")
        if self.heights.ndim != 2 or min(self.heights.shape) < 2:
            shape = " x ".join(str(size) for size in self.heights.shape)
            raise ValueError(f"terrain: needs at least 2 x 2 heights, not {shape}")
        holes = np.argwhere(~np.isfinite(self.heights))
        if len(holes):
            column, row = holes[0]
            raise ValueError(
                f"terrain: {len(holes)} of {self.heights.size} heights are missing, "
                f"the first at column {column}, row {row} from the south-west"
            )

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """West, south, east, north of the lattice in ENU m."""
        columns, rows = self.heights.shape
        return (
            self.west_m,
            self.south_m,
            self.west_m + (columns - 1) * self.cell_m,
            self.south_m + (rows - 1) * self.cell_m,
        )

    def contains(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which points (..., 2 or more) lie over the lattice, edges included."""
        west, south, east, north = self.bounds
        xy = np.asarray(points, dtype=np.float64)
        x, y = xy[..., 0], xy[..., 1]
        return np.asarray((x >= west) & (x <= east) & (y >= south) & (y <= north))

    def height_at(self, points: npt.ArrayLike) -> _F64:
        """Ground heights (...) in m under points (..., 2 or more)."""
        south_west, u, v, step = self._cell(points)
        flat = self.heights.reshape(-1)
        low = flat[south_west]
        east = flat[south_west + step] - low
        north = flat[south_west + 1] - low
        twist = flat[south_west + step + 1] - low - east - north
        return np.asarray(low + u * east + v * (north + u * twist))

    def gradient_at(self, points: npt.ArrayLike) -> _F64:
        """Rise (..., 2) per metre east and per metre north, of the cell that holds the point."""
        south_west, u, v, step = self._cell(points)
        flat = self.heights.reshape(-1)
        low = flat[south_west]
        east = flat[south_west + step] - low
        north = flat[south_west + 1] - low
        twist = flat[south_west + step + 1] - low - east - north
        return np.stack((east + v * twist, north + u * twist), axis=-1) / self.cell_m

    def slope_at(self, points: npt.ArrayLike) -> _F64:
        """Steepest slope (...) in rad at points (..., 2 or more)."""
        rise = self.gradient_at(points)
        return np.arctan(np.hypot(rise[..., 0], rise[..., 1]))

    def cell_slopes(self) -> _F64:
        """Largest slope (columns - 1, rows - 1) in rad anywhere in each cell."""
        east = np.diff(self.heights, axis=0)  # along the cells' lower and upper edges
        north = np.diff(self.heights, axis=1)
        along = np.maximum(abs(east[:, :-1]), abs(east[:, 1:]))
        across = np.maximum(abs(north[:-1]), abs(north[1:]))
        corners = [
            np.hypot(e, n) for e in (east[:, :-1], east[:, 1:]) for n in (north[:-1], north[1:])
        ]
        worst = np.maximum.reduce([along, across, *corners])
        return np.asarray(np.arctan(worst / self.cell_m))

    def steepest(self) -> float:
        """Largest slope anywhere, rad."""
        return float(self.cell_slopes().max())

    def sees(self, start: npt.ArrayLike, end: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Lines of sight (...) between points (..., 3); one that only touches the ground is clear.

        Looked at every half cell, so a ridge thinner than that may be missed.
        """
        here, there = np.broadcast_arrays(
            np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
        )
        lead = here.shape[:-1]
        first, last = here.reshape(-1, 3), there.reshape(-1, 3)
        reach = np.hypot(last[:, 0] - first[:, 0], last[:, 1] - first[:, 1]).max(initial=0.0)
        steps = max(int(np.ceil(2.0 * reach / self.cell_m)), 1)
        along = np.linspace(0.0, 1.0, steps + 1)[:, None]
        clear = np.empty(len(first), dtype=np.bool_)
        rows = max(_BLOCK // (steps + 1), 1)
        for at in range(0, len(first), rows):
            part = slice(at, at + rows)
            line = first[part, None] + along * (last[part, None] - first[part, None])
            clear[part] = (line[..., 2] >= self.height_at(line) - 1e-9).all(axis=-1)
        return clear.reshape(lead)

    def around(self, point: npt.ArrayLike, radius_m: float) -> Terrain:
        """The part of the lattice that covers a square of ``radius_m`` about a point."""
        x, y = (float(part) for part in np.asarray(point, dtype=np.float64)[:2])
        columns, rows = self.heights.shape
        first, stop = _span(x - self.west_m, radius_m, self.cell_m, columns)
        low, high = _span(y - self.south_m, radius_m, self.cell_m, rows)
        return Terrain(
            self.west_m + first * self.cell_m,
            self.south_m + low * self.cell_m,
            self.cell_m,
            self.heights[first:stop, low:high],
        )

    def _cell(self, points: npt.ArrayLike) -> tuple[npt.NDArray[np.int64], _F64, _F64, int]:
        """Flat index of the south-western corner, and where (0..1) in the cell."""
        xy = np.asarray(points, dtype=np.float64)
        columns, rows = self.heights.shape
        u = np.clip((xy[..., 0] - self.west_m) / self.cell_m, 0.0, columns - 1)
        v = np.clip((xy[..., 1] - self.south_m) / self.cell_m, 0.0, rows - 1)
        column = np.minimum(u.astype(np.int64), columns - 2)
        row = np.minimum(v.astype(np.int64), rows - 2)
        return column * rows + row, u - column, v - row, rows


def flat(bounds: tuple[float, float, float, float], height_m: float = 0.0) -> Terrain:
    """Level ground over (west, south, east, north), in one lattice that covers it."""
    west, south, east, north = bounds
    cell = max(east - west, north - south)
    return Terrain(west, south, cell, np.full((2, 2), float(height_m)))


def mountains(
    draw: Generator,
    bounds: tuple[float, float, float, float],
    steepest_rad: float,
    cell_m: float = 5.0,
    hills: int = 24,
    width_m: tuple[float, float] = (50.0, 140.0),
) -> Terrain:
    """Random mountains whose largest slope is ``steepest_rad``, exactly; lowest point at 0.

    A sum of Gaussian hills and hollows, scaled: slopes scale with heights.

    Args:
        draw: of the hills.
        bounds: west, south, east, north in ENU m.
        steepest_rad: largest slope anywhere, below 90 degrees; 0 is level ground.
        cell_m: spacing of the lattice; the last points lie on or past the bounds.
        hills: how many.
        width_m: least and largest standard deviation of a hill.

    Raises:
        ValueError: the slope, the number of hills, their widths, the bounds or the spacing make
            no sense.
    """
    if not 0.0 <= steepest_rad < np.pi / 2:
        raise ValueError(f"terrain: the largest slope must be 0 to 90 degrees, not {steepest_rad}")
    if hills < 1 or not 0.0 < width_m[0] <= width_m[1]:
        raise ValueError(f"terrain: no mountains of {hills} hills, {width_m} m wide")
    west, south, east, north = bounds
    if not (np.isfinite(bounds).all() and west < east and south < north):
        raise ValueError(f"terrain: no mountains over {bounds}: west, south, east, north in m")
    if not (np.isfinite(cell_m) and cell_m > 0.0):
        raise ValueError(f"terrain: the spacing must be positive, not {cell_m}")
    columns = int(np.ceil((east - west) / cell_m)) + 1
    rows = int(np.ceil((north - south) / cell_m)) + 1
    x = west + cell_m * np.arange(columns)
    y = south + cell_m * np.arange(rows)
    centre = draw.uniform((west, south), (east, north), (hills, 2))
    width = draw.uniform(*width_m, hills)
    height = width * draw.uniform(0.5, 1.0, hills) * draw.choice((-1.0, 1.0), hills, p=(0.35, 0.65))
    across = np.exp(-0.5 * ((x[:, None] - centre[:, 0]) / width) ** 2)
    along = np.exp(-0.5 * ((y[:, None] - centre[:, 1]) / width) ** 2)
    heights = np.einsum("ik,jk,k->ij", across, along, height)
    rough = Terrain(west, south, cell_m, heights)
    factor = np.tan(steepest_rad) / np.tan(rough.steepest())
    return Terrain(west, south, cell_m, (heights - heights.min()) * factor)


def _span(offset: float, radius_m: float, cell_m: float, size: int) -> tuple[int, int]:
    first = int(np.clip(np.floor((offset - radius_m) / cell_m), 0, size - 2))
    last = int(np.clip(np.ceil((offset + radius_m) / cell_m), first + 1, size - 1))
    return first, last + 1


def check_places(terrain: Terrain, what: str, points: npt.ArrayLike, steepest_rad: float) -> None:
    """Whether points (k, 2 or more) are places to stand on.

    Args:
        terrain: the ground.
        what: they are, such as "start", for the message.
        points: ENU m.
        steepest_rad: slope that things stand on; such as alpha for vehicles, pi / 2 for any.

    Raises:
        ValueError: one lies off the terrain, or on a steeper slope; names the first.
    """
    xy = np.asarray(points, dtype=np.float64)
    on, slope = terrain.contains(xy), terrain.slope_at(xy)
    for number in np.flatnonzero(~on | (slope > steepest_rad)):
        x, y = xy[number, :2]
        where = f"{what} {number + 1} at ({x:g}, {y:g})"
        if not on[number]:
            west, south, east, north = terrain.bounds
            area = f"{west:g} to {east:g} east, {south:g} to {north:g} north"
            raise ValueError(f"{where} is off the terrain ({area})")
        here, most = np.degrees((slope[number], steepest_rad))
        raise ValueError(f"{where} is on a slope of {here:.1f} degrees, above {most:.1f}")


def steep_share(terrain: Terrain, slope_rad: float) -> float:
    """Share of the area with cells steeper than ``slope_rad`` somewhere."""
    steep: Any = terrain.cell_slopes() > slope_rad
    return float(steep.mean())
