"""Elevation files that people have, as terrain: .npy, ESRI ASCII grids, GeoTIFF.

Samples become lattice points. Heights of -9999 m and below count as missing, whatever a
file says of missing ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from planners.terrain import Terrain
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.world import geotiff
from sim_vehicles.world.geotiff import MISSING_M, from_north, known

_NPY = b"\x93NUMPY"


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
            is given. North of a projected grid counts as true north; one that is far from it,
            or from true to size, is refused.

    Raises:
        ValueError: the file cannot be read, is odd, or has no-data cells; begins with its name.
    """
    file = Path(path)
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        kinds = ", ".join(sorted(_READERS))
        raise ValueError(f"{file.name}: not an elevation file that we know ({kinds})")
    if not file.exists():
        raise ValueError(f"{file.name}: No such file")
    try:
        terrain = reader(file, cell_m, origin if south_west is None else None)
    except OSError as error:
        raise ValueError(f"{file.name}: {error.strerror or error}") from error
    except (ValueError, OverflowError) as error:
        why = str(error).removeprefix("terrain: ")
        raise ValueError(f"{file.name}: {why}") from error
    if south_west is not None:
        terrain = replace(terrain, west_m=float(south_west[0]), south_m=float(south_west[1]))
    return terrain


def _npy(file: Path, cell_m: float | None, origin: Geodetic | None) -> Terrain:
    if cell_m is None:
        raise ValueError("an .npy file does not say its spacing: give cell_m")
    with file.open("rb") as opened:
        if opened.read(len(_NPY)) != _NPY:
            raise ValueError("not an .npy file")
    heights = np.load(file, allow_pickle=False)
    if heights.dtype.kind not in "iuf":
        raise ValueError("does not hold numbers")
    return Terrain(0.0, 0.0, float(cell_m), known(heights.astype(np.float64)))


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
    heights[heights == header.get("nodata_value", MISSING_M)] = np.nan
    return Terrain(0.0, 0.0, spacing, from_north(known(heights)))


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


def _tif(file: Path, cell_m: float | None, origin: Geodetic | None) -> Terrain:
    return geotiff.read(file, origin)


_READERS: Mapping[str, Callable[[Path, float | None, Geodetic | None], Terrain]] = {
    ".npy": _npy,
    ".asc": _ascii,
    ".tif": _tif,
    ".tiff": _tif,
}
