"""GeoTIFF as terrain; needs the extra ``geo`` (rasterio)."""

from __future__ import annotations

import importlib
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from planners.terrain import Terrain
from sim_vehicles.geodesy import Geodetic, to_enu

_F64 = npt.NDArray[np.float64]
MISSING_M = -9999.0
_STRETCH = 0.02  # by which metres of a grid may differ from true ones; UTM's do by 0.001
_TURN_RAD = math.radians(5.0)  # by which north of a grid may
_LITTLE_DEG = 0.01


def read(file: Path, origin: Geodetic | None) -> Terrain:
    """The terrain of a file's one band; placed by its coordinates when there is an origin.

    Raises:
        ValueError: it is odd, or has no-data cells.
        OSError: it cannot be read.
    """
    try:
        rasterio: Any = importlib.import_module("rasterio")
    except ImportError as error:
        raise ValueError("GeoTIFF needs the extra: pip install 'uavbridge[geo]'") from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
            with rasterio.open(file) as raster:
                samples = from_north(_heights(rasterio, raster))
                matrix, crs = raster.transform, raster.crs
    except rasterio.errors.RasterioIOError as error:
        raise ValueError(f"not a GeoTIFF: {error}") from error
    _laid_out(matrix)
    west = matrix.c + 0.5 * matrix.a  # of the south-western pixel's centre
    south = matrix.f + matrix.e * (samples.shape[1] - 0.5)
    if crs is not None and crs.is_geographic:
        return _from_degrees(samples, (west, south), (matrix.a, -matrix.e), crs, origin)
    _square_metres(matrix, crs)
    if origin is None or crs is None:
        return Terrain(0.0, 0.0, float(matrix.a), samples)
    home = _home(crs, origin)
    return Terrain(west - home[0], south - home[1], float(matrix.a), samples)


def known(heights: _F64) -> _F64:
    """Heights with NaN for what marks missing ones where a file does not say: -9999 and below."""
    return np.where(heights <= MISSING_M, np.nan, heights)


def from_north(heights: _F64) -> _F64:
    """Rows from north to south, as rasters have them, to (columns, rows)."""
    return np.ascontiguousarray(heights[::-1].T)


def _heights(rasterio: Any, raster: Any) -> _F64:
    """The one band of heights in m; NaN where it has none."""
    alpha = rasterio.enums.ColorInterp.alpha
    kinds = zip(raster.indexes, raster.colorinterp, strict=True)
    bands = [band for band, kind in kinds if kind != alpha]
    if len(bands) != 1:
        raise ValueError(f"has {len(bands)} bands, and heights are one")
    if np.dtype(raster.dtypes[bands[0] - 1]).kind not in "iuf":
        raise ValueError("does not hold numbers")
    read = raster.read(bands[0], masked=True)
    heights = read.astype(np.float64).filled(np.nan)
    place = bands[0] - 1
    scale, offset = float(raster.scales[place]), float(raster.offsets[place])
    return known(heights) * scale + offset


def _laid_out(matrix: Any) -> None:
    if matrix.is_identity:
        raise ValueError("does not say where its cells lie")
    if matrix.b or matrix.d or matrix.a <= 0.0 or matrix.e >= 0.0:
        raise ValueError(
            "rows must run from north to south, columns from west to east: "
            "it is rotated, sheared or mirrored"
        )


def _square_metres(matrix: Any, crs: Any) -> None:
    if crs is not None and not crs.is_projected:
        raise ValueError("its coordinates are neither degrees nor metres of a projection")
    if crs is not None and crs.linear_units_factor[1] != 1.0:
        raise ValueError(f"its coordinates are in {crs.linear_units_factor[0]}, not in metres")
    if abs(matrix.a + matrix.e) > 1e-6 * matrix.a:
        raise ValueError(f"cells are not square ({matrix.a:g} x {-matrix.e:g})")


def _home(crs: Any, origin: Geodetic) -> tuple[float, float]:
    """Where an origin lies in a projection, that has to be true to size and direction there."""
    latitude, longitude = origin.latitude_deg, origin.longitude_deg
    ahead = latitude - math.copysign(_LITTLE_DEG, latitude)
    try:
        x, y = importlib.import_module("rasterio.warp").transform(
            "EPSG:4326", crs, [longitude, longitude], [latitude, ahead]
        )
    except importlib.import_module("rasterio._err").CPLE_BaseError as error:
        raise ValueError("its coordinates do not lead to the mission's home") from error
    true_m = float(to_enu(ahead, longitude, 0.0, Geodetic(latitude, longitude, 0.0))[1])
    way = complex(x[1] - x[0], y[1] - y[0]) / complex(0.0, true_m)
    turn = abs(math.atan2(way.imag, way.real))
    if not abs(abs(way) - 1.0) <= _STRETCH or turn > _TURN_RAD:
        raise ValueError(
            f"its projection is not true at the mission's home (a metre is {abs(way):.2f} m long, "
            f"north is {math.degrees(turn):.1f} degrees off); one that is: UTM"
        )
    return x[0], y[0]


def _from_degrees(
    samples: _F64,
    south_west: tuple[float, float],
    step: tuple[float, float],
    crs: Any,
    home: Geodetic | None,
) -> Terrain:
    """Samples on a lattice of degrees, drawn anew on one of metres."""
    if not math.isclose(crs.units_factor[1], math.radians(1.0), rel_tol=1e-6):
        raise ValueError(f"its coordinates are in {crs.units_factor[0]}, not in degrees")
    columns, rows = samples.shape
    middle = south_west[1] + 0.5 * step[1] * (rows - 1)
    at = home or Geodetic(south_west[1], south_west[0], 0.0)
    size = to_enu(middle + step[1], at.longitude_deg + step[0], 0.0, _sea(middle, at))
    east, north = float(size[0]), float(size[1])
    corner = to_enu(south_west[1], south_west[0], 0.0, _sea(at.latitude_deg, at))
    lattice = Terrain(0.0, 0.0, 1.0, samples)  # refuses holes, and looks between the samples
    cell = min(east, north)
    x = np.arange(int(east * (columns - 1) / cell) + 1) * cell / east
    y = np.arange(int(north * (rows - 1) / cell) + 1) * cell / north
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    return Terrain(float(corner[0]), float(corner[1]), cell, lattice.height_at(points))


def _sea(latitude_deg: float, at: Geodetic) -> Geodetic:
    return Geodetic(latitude_deg, at.longitude_deg, 0.0)
