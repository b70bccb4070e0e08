"""The ground of a mission, and the signals of targets on it."""

from __future__ import annotations

from functools import lru_cache
from math import radians
from pathlib import Path
from typing import Annotated, TypeAlias

import numpy as np
from msgspec import Meta

from planners.grid import Grid
from planners.terrain import Terrain, mountains
from planners.types import F64, Bools
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.world import elevation
from uavbridge.config.tables import Home, Table

GENERATED_CELL_M = 5.0
STEEPEST_DEG = 30.0
HILLS = 24
MOST_POINTS = 4_000_000  # of a generated lattice

_Spacing: TypeAlias = Annotated[float, Meta(gt=0.0, le=1e4)]
_Place: TypeAlias = Annotated[float, Meta(ge=-1e6, le=1e6)]
_Slope: TypeAlias = Annotated[float, Meta(ge=0.0, lt=90.0)]
_Seed: TypeAlias = Annotated[int, Meta(ge=0, le=2**32 - 1)]
_Hills: TypeAlias = Annotated[int, Meta(ge=1, le=1000)]


class Ground(Table, frozen=True):
    """The ground; without this table it is level. Heights of vehicles then count above it."""

    file: Annotated[
        str | None,
        Meta(description=".tif, .asc or .npy, from the mission file's folder; absent: generated"),
    ] = None
    cell_m: Annotated[
        _Spacing | None,
        Meta(description="spacing of an .npy file; of generated ground, then 5 if absent"),
    ] = None
    west_m: Annotated[
        _Place | None,
        Meta(description="x of a file's south-western sample; absent: by coordinates, or 0"),
    ] = None
    south_m: Annotated[_Place | None, Meta(description="y of it, together with west_m")] = None
    zero_m: Annotated[
        _Place | None,
        Meta(
            description="height in the file that is 0 in the mission; absent: home.altitude_m for "
            "a GeoTIFF, else 0"
        ),
    ] = None
    seed: Annotated[_Seed | None, Meta(description="of generated ground; absent: 1")] = None
    steepest_deg: Annotated[
        _Slope | None, Meta(description="largest slope of generated ground; absent: 30")
    ] = None
    hills: Annotated[_Hills | None, Meta(description="of generated ground; absent: 24")] = None
    alpha_deg: Annotated[
        float, Meta(ge=0.0, lt=90.0, description="steepest slope that vehicles start on")
    ] = 40.0
    beta_deg: Annotated[
        float, Meta(ge=0.0, lt=90.0, description="steepest slope that rovers drive up")
    ] = 30.0
    sensing_m: Annotated[
        float, Meta(gt=0.0, description="how far around its vehicle a planner knows the ground")
    ] = 100.0

    @property
    def alpha_rad(self) -> float:
        """Steepest slope that vehicles start on."""
        return radians(self.alpha_deg)

    @property
    def beta_rad(self) -> float:
        """Steepest slope that rovers drive up."""
        return radians(self.beta_deg)


class Signals(Table, frozen=True):
    """Targets give signals (Zhou 2023, Eq. (1)); with this table no cells are looked at."""

    power: Annotated[float, Meta(gt=0.0, description="Q, of a target")] = 1e5
    attenuation: Annotated[float, Meta(gt=0.0, description="m")] = 0.1
    noise: Annotated[float, Meta(ge=0.0, description="standard deviation of eta")] = 1.0
    range_m: Annotated[
        float, Meta(gt=0.0, description="d_tar, farthest that a signal is heard")
    ] = 100.0
    arrival_m: Annotated[
        float, Meta(gt=0.0, description="d_0, a target so near, along the ground, is found")
    ] = 10.0
    period_s: Annotated[
        float, Meta(ge=0.1, le=3600.0, description="between two signals of a target")
    ] = 1.0
    silent_when_found: Annotated[
        bool, Meta(description="a target that was found gives no more signals")
    ] = True


def terrain(ground: Ground, home: Home, grid: Grid) -> Terrain:
    """The terrain of a mission; the same object for the same mission and file.

    Generated ground covers the area; beyond its edges any ground goes on level.

    Raises:
        ValueError: the file cannot be read or is odd; begins with its name.
    """
    return _terrain(ground, home, grid, _version(ground.file))


def _version(file: str | None) -> tuple[int, int]:
    """What changes when a file does."""
    try:
        state = Path(file or "").stat()
    except OSError:  # the reader says it better
        return 0, 0
    return state.st_mtime_ns, state.st_size


@lru_cache(maxsize=8)
def _terrain(ground: Ground, home: Home, grid: Grid, version: tuple[int, int]) -> Terrain:
    made = _generated(ground, grid) if ground.file is None else _read(ground, home, ground.file)
    made.heights.setflags(write=False)
    return made


def _generated(ground: Ground, grid: Grid) -> Terrain:
    return mountains(
        np.random.default_rng(1 if ground.seed is None else ground.seed),
        grid.bounds,
        radians(STEEPEST_DEG if ground.steepest_deg is None else ground.steepest_deg),
        cell_m=ground.cell_m or GENERATED_CELL_M,
        hills=ground.hills or HILLS,
    )


def _read(ground: Ground, home: Home, file: str) -> Terrain:
    read = elevation.read(
        file,
        cell_m=ground.cell_m,
        south_west=None if ground.west_m is None else (ground.west_m, ground.south_m or 0.0),
        origin=Geodetic(home.latitude_deg, home.longitude_deg, home.altitude_m),
    )
    zero_m = ground.zero_m
    if zero_m is None:
        placed = Path(file).suffix.lower() in (".tif", ".tiff")
        zero_m = home.altitude_m if placed else 0.0
    return Terrain(read.west_m, read.south_m, read.cell_m, read.heights - zero_m)


def points(ground: Ground, grid: Grid) -> float:
    """How many heights generated ground takes."""
    west, south, east, north = grid.bounds
    cell_m = ground.cell_m or GENERATED_CELL_M
    return ((east - west) / cell_m + 1) * ((north - south) / cell_m + 1)


def stands(terrain: Terrain, ground: Ground, places: F64) -> Bools:
    """Which points (k, 2) vehicles may start on: no steeper than alpha."""
    return np.asarray(terrain.contains(places) & (terrain.slope_at(places) <= ground.alpha_rad))
