"""Whether a mission fits its ground: files that read, starts and targets to stand on."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

from planners.terrain import Terrain, check_places
from uavbridge.config.field_error import FieldError, KeyPath
from uavbridge.config.ground import MOST_POINTS, Ground, points
from uavbridge.config.mission import Mission
from uavbridge.config.tables import Point

_OF_FILES = ("west_m", "south_m", "zero_m")
_GENERATED = ("seed", "steepest_deg", "hills")


def check_ground(mission: Mission) -> Terrain | None:
    """Whether ``[terrain]`` makes sense by itself; the terrain.

    Raises:
        FieldError: it does not.
    """
    ground = mission.ground
    if ground is None:
        return None
    _keys(ground)
    if ground.beta_deg > ground.alpha_deg:
        what = f"must be at most alpha_deg = {ground.alpha_deg:g}"
        raise FieldError(("terrain", "beta_deg"), what, ground.beta_deg)
    if ground.file is None and points(ground, mission.grid) > MOST_POINTS:
        what = f"makes more than {MOST_POINTS} heights of this area"
        raise FieldError(("terrain", "cell_m"), what, ground.cell_m)
    try:
        return mission.terrain()
    except ValueError as error:
        path = ("terrain",) if ground.file is None else ("terrain", "file")
        raise FieldError(path, str(error).removeprefix("terrain: ")) from None


def _keys(ground: Ground) -> None:
    others, why = (
        (_OF_FILES, "is for a file, and there is none")
        if ground.file is None
        else (_GENERATED, f"is for generated ground, and there is file = {ground.file!r}")
    )
    for key in others:
        if getattr(ground, key) is not None:
            raise FieldError(("terrain", key), why)
    if ground.cell_m is not None and not (ground.file or ".npy").lower().endswith(".npy"):
        what = f"is for .npy files: {ground.file!r} says its spacing itself"
        raise FieldError(("terrain", "cell_m"), what, ground.cell_m)
    if (ground.west_m is None) is not (ground.south_m is None):
        missing = "west_m" if ground.west_m is None else "south_m"
        raise FieldError(("terrain", missing), "is missing: both west_m and south_m, or neither")


def check_on_ground(
    mission: Mission, terrain: Terrain, starts: Sequence[tuple[KeyPath, Point]]
) -> None:
    """Whether starts, targets and the area lie on the terrain, starts where vehicles can stand.

    Raises:
        FieldError: the first that does not.
    """
    ground = mission.ground
    assert ground is not None
    for path, place in starts:
        _place(terrain, path, place, ground.alpha_rad)
    for index, target in enumerate(mission.targets):
        _place(terrain, ("targets", index, "position"), target.position, pi / 2)
    check_covers(mission, terrain)


def check_covers(mission: Mission, terrain: Terrain) -> None:
    """Whether the area lies on the terrain.

    Raises:
        FieldError: it does not.
    """
    west, south, east, north = mission.grid.bounds
    if not terrain.contains([(west, south), (east, north)]).all():
        reach = ", ".join(f"{part:g}" for part in terrain.bounds)
        area = ", ".join(f"{part:g}" for part in mission.grid.bounds)
        what = f"reaches from {reach} (west, south, east, north), the area from {area}"
        raise FieldError(("terrain", "file"), what)


def _place(terrain: Terrain, path: KeyPath, place: Point, steepest_rad: float) -> None:
    try:
        check_places(terrain, "it", [place], steepest_rad)
    except ValueError as error:
        raise FieldError(path, str(error).partition(") ")[2], place) from None
