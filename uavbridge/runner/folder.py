"""The output folder of a mission: one of its own, without what an earlier flight left there."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np

from planners.terrain import Terrain
from uavbridge.clock import wall_date
from uavbridge.config import Mission, to_toml
from uavbridge.errors import ConfigError
from uavbridge.recording.parts import MCAP_NAME, parts_of
from uavbridge.recording.tlog import TLOG_PATTERN
from uavbridge.report.page import FIGURES, FIGURES_NAME, REPORT_NAME, SUMMARY_NAME

RUNS = Path("runs")
MISSION_NAME, OTHER_NAME = "mission.toml", "mission-as-flown.toml"
GROUND_NAME = "terrain.npy"
_AS_FLOWN = "# The mission as flown, every default spelt out.\n"


def as_flown(mission: Mission) -> Mission:
    """Without where results go and how they are shown, which changes nothing of the flight."""
    return msgspec.structs.replace(mission, out=None, headless=False, json=False)


def with_ground(mission: Mission) -> Mission:
    """With the ground from the output folder, where ``prepare`` copies an elevation file to."""
    terrain, ground = mission.terrain(), mission.ground
    if terrain is None or ground is None or ground.file is None:
        return mission
    copy = msgspec.structs.replace(
        ground,
        file=GROUND_NAME,
        cell_m=terrain.cell_m,
        west_m=terrain.west_m,
        south_m=terrain.south_m,
        zero_m=0.0,
    )
    return msgspec.structs.replace(mission, ground=copy)


def prepare(mission: Mission, folder: Path | None = None) -> Path:
    """Make the output folder and write the mission there.

    Args:
        mission: to be flown.
        folder: the one wanted, there already or not; None: the mission's, else a new one
            under ``runs/`` by name and date.

    Raises:
        ConfigError: it cannot be written to.
    """
    if mission.out == "":
        raise ConfigError("out: is empty")
    terrain = mission.terrain()
    if folder is None and mission.out is not None:
        folder = Path(mission.out)
    try:
        folder = _new(mission.name) if folder is None else folder
        folder.mkdir(parents=True, exist_ok=True)
        for old in _left(folder):
            old.unlink()
        kept = with_ground(as_flown(mission))
        if kept.ground is not None and kept.ground.file is not None:
            _save(folder / kept.ground.file, terrain)
        text = _AS_FLOWN + to_toml(kept)
        _mission_file(folder).write_text(text, encoding="utf-8")
    except (OSError, ValueError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else str(fault)
        raise ConfigError(f"out: cannot write to {folder or RUNS}: {reason}") from None
    return folder


def _save(path: Path, terrain: Terrain | None) -> None:
    if terrain is not None:
        np.save(path, terrain.heights)


def _new(name: str) -> Path:
    """A folder that nobody else has, however many missions start in this second."""
    stem = f"{name}-{wall_date():%Y%m%d-%H%M%S}"
    folder, number = RUNS / stem, 1
    while True:
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            number += 1
            folder = RUNS / f"{stem}-{number}"
        else:
            return folder


def _mission_file(folder: Path) -> Path:
    """Where the mission as flown goes: somebody's own mission of that name stays as it is."""
    path = folder / MISSION_NAME
    own = path.exists() and not path.read_text(encoding="utf-8").startswith(_AS_FLOWN)
    return folder / OTHER_NAME if own else path


def _left(folder: Path) -> Iterator[Path]:
    """What an earlier flight left in the folder."""
    yield from folder.glob(TLOG_PATTERN)
    yield from parts_of(folder / MCAP_NAME).values()
    for name in (SUMMARY_NAME, REPORT_NAME):
        if (folder / name).exists():
            yield folder / name
    for name in FIGURES:
        yield from (folder / FIGURES_NAME).glob(f"{name}.*")
