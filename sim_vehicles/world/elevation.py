"""Elevation files that people have, as terrain: .npy, ESRI ASCII grids, GeoTIFF.

Samples become lattice points. GeoTIFF needs the extra ``geo`` (rasterio).
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from planners.terrain import Terrain
from sim_vehicles.geodesy import Geodetic, to_enu

_F64 = npt.NDArray[np.float64]


def read(
    path: Path | str,
    *,
    cell_m: float | None = None,
    south_west: tuple[float, float] | None = None,
    origin: Geodetic | None = None,
) -> Terrain:
    """The terrain of an elevation file.

    Args:
        path: ``.npy`` (heights (columns, rows), south-western one first), ``.asc`` (ESRI ASCII
            grid, projected metres) or ``.tif``/``.tiff``.
        cell_m: spacing; only ``.npy`` needs it, the others say it themselves.
        south_west: where the south-western sample lies in ENU m; (0, 0) when nothing says it.
        origin: the mission's home: places a GeoTIFF by its coordinates, unless ``south_west``
            is given. North of a projected grid counts as true north.

    Raises:
        ValueError: the file cannot be read, is odd, or has no-data cells; begins with its name.
    """
    file = Path(path)
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        known = ", ".join(sorted(_READERS))
        raise ValueError(f"{file.name}: not an elevation file that we know ({known})")
    if not file.exists():
        raise ValueError(f"{file.name}: No such file")
    try:
        terrain = reader(file, cell_m, origin)
    except OSError as error:
        raise ValueError(f"{file.name}: {error.strerror or error}") from error
    except (ValueError, EOFError, OverflowError, BadZipFile) as error:
        why = str(error).removeprefix("terrain: ")
        raise ValueError(f"{file.name}: {why}") from error
    if south_west is not None:
        terrain = replace(terrain, west_m=float(south_west[0]), south_m=float(south_west[1]))
    return terrain


def _npy(file: Path, cell_m: float | None, origin: Geodetic | None) -> Terrain:
    if cell_m is None:
        raise ValueError("an .npy file does not say its spacing: give cell_m")
    heights = np.load(file, allow_pickle=False)
    if not isinstance(heights, np.ndarray) or heights.dtype.kind not in "iuf":
        raise ValueError("does not hold numbers")
    return Terrain(0.0, 0.0, float(cell_m), heights.astype(np.float64))


def _ascii(file: Path, cell_m: float | None, origin: Geodetic | None) -> Terrain:
    header, lines = _header(file.read_text(encoding="ascii", errors="replace").splitlines())
    columns, rows = (_whole(header, key) for key in ("ncols", "nrows"))
    spacing = _spacing(header)
    table = [line.split() for line in lines if line.strip()]
    if len(table) != rows:
        raise ValueError(f"says nrows {rows} and has {len(table)} rows")
    for number, line in enumerate(table, 1):
        if len(line) != columns:
            raise ValueError(f"says ncols {columns}, and row {number} has {len(line)} numbers")
    try:
        heights = np.array(table, dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"a height is not a number ({error})") from error
    return Terrain(0.0, 0.0, spacing, _from_north(heights, header.get("nodata_value", -9999.0)))


def _header(lines: list[str]) -> tuple[dict[str, float], list[str]]:
    header: dict[str, float] = {}
    for place, line in enumerate(lines):
        words = line.split()
        if len(words) != 2 or not words[0][0].isalpha() or words[0].lower() == "nan":
            return header, lines[place:]
        try:
            header[words[0].lower()] = float(words[1])
        except ValueError as error:
            raise ValueError(f"header: {words[0]} is {words[1]!r}, not a number") from error
    return header, []


def _whole(header: Mapping[str, float], key: str) -> int:
    value = header.get(key)
    if value is None or not value.is_integer() or value < 2:
        raise ValueError(f"header: {key} must be a whole number of at least 2, not {value}")
    return int(value)


def _spacing(header: Mapping[str, float]) -> float:
    if "dx" in header or "dy" in header:
        if header.get("dx") != header.get("dy"):
            raise ValueError("cells are not square (dx and dy differ)")
        return header["dx"]
    if "cellsize" not in header:
        raise ValueError("header: cellsize is missing")
    return header["cellsize"]


def _from_north(heights: _F64, nodata: float | None) -> _F64:
    """Rows from north to south, as rasters have them, to (columns, rows); no data to NaN."""
    known = heights if nodata is None else np.where(heights == nodata, np.nan, heights)
    return np.ascontiguousarray(known[::-1].T)


def _geotiff(file: Path, cell_m: float | None, origin: Geodetic | None) -> Terrain:
    try:
        rasterio: Any = importlib.import_module("rasterio")
        warp: Any = importlib.import_module("rasterio.warp")
    except ImportError as error:
        raise ValueError("GeoTIFF needs the extra: pip install 'uavbridge[geo]'") from error
    try:
        with rasterio.open(file) as raster:
            heights = raster.read(1).astype(np.float64)
            matrix, crs, nodata = raster.transform, raster.crs, raster.nodata
    except rasterio.errors.RasterioIOError as error:
        raise ValueError(f"not a GeoTIFF: {error}") from error
    if matrix.b or matrix.d or matrix.a <= 0.0 or matrix.e >= 0.0:
        raise ValueError("rows must run from north to south, columns from west to east")
    samples = _from_north(heights, nodata)
    west = matrix.c + 0.5 * matrix.a  # of the south-western pixel's centre
    south = matrix.f + matrix.e * (heights.shape[0] - 0.5)
    if crs is not None and crs.is_geographic:
        return _from_degrees(samples, (west, south), (matrix.a, -matrix.e), origin)
    if abs(matrix.a + matrix.e) > 1e-6 * matrix.a:
        raise ValueError(f"cells are not square ({matrix.a:g} x {-matrix.e:g})")
    if origin is None or crs is None:
        return Terrain(0.0, 0.0, float(matrix.a), samples)
    home = warp.transform("EPSG:4326", crs, [origin.longitude_deg], [origin.latitude_deg])
    return Terrain(west - home[0][0], south - home[1][0], float(matrix.a), samples)


def _from_degrees(
    samples: _F64, south_west: tuple[float, float], step: tuple[float, float], home: Geodetic | None
) -> Terrain:
    """Samples on a lattice of degrees, drawn anew on one of metres."""
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


_READERS: Mapping[str, Callable[[Path, float | None, Geodetic | None], Terrain]] = {
    ".npy": _npy,
    ".asc": _ascii,
    ".tif": _geotiff,
    ".tiff": _geotiff,
}
