"""Missions on terrain: where the ground comes from, and what does not fit it."""

from __future__ import annotations

from math import radians
from pathlib import Path

import numpy as np
import pytest

from planners.terrain import mountains
from uavbridge import config
from uavbridge.errors import ConfigError

AREA = 'name = "hills"\nvehicles = 1\n[area]\ncell_m = 100\ncolumns = 10\nrows = 10\n'


def missing(tmp_path: Path) -> str:
    heights = np.zeros((11, 11))
    heights[3, 4] = np.nan
    np.save(tmp_path / "holes.npy", heights)
    return 'file = "holes.npy"\ncell_m = 100'


def write(tmp_path: Path, text: str) -> Path:
    np.save(tmp_path / "small.npy", np.full((6, 6), 7.0))
    np.save(tmp_path / "level.npy", np.full((11, 11), 7.0))
    (tmp_path / "empty.npy").touch()
    (tmp_path / "odd.asc").write_text("ncols 2\nnrows 1e400\ncellsize 5\n0 0\n")
    (tmp_path / "m.toml").write_text(AREA + text)
    return tmp_path / "m.toml"


def test_level_without_the_table() -> None:
    mission = config.parse(AREA)
    assert mission.terrain() is None
    assert mission.signals is None
    assert [member.kind for member in mission.team()] == ["multirotor"]


def test_generated_ground_is_that_of_the_experiments() -> None:
    mission = config.parse(AREA + "[terrain]\nseed = 7\nsteepest_deg = 40\n")
    terrain = mission.terrain()
    same = mountains(np.random.default_rng(7), mission.grid.bounds, radians(40))
    assert terrain is not None
    np.testing.assert_array_equal(terrain.heights, same.heights)
    assert terrain.steepest() == pytest.approx(radians(40))
    assert mission.terrain() is terrain
    assert config.parse(config.to_toml(mission)) == mission


def test_a_file_is_found_beside_the_mission(tmp_path: Path) -> None:
    path = write(tmp_path, '[terrain]\nfile = "level.npy"\ncell_m = 100\nzero_m = 5\n')
    mission = config.load(path)
    terrain = mission.terrain()
    assert terrain is not None
    assert terrain.height_at((500.0, 500.0)) == 2.0
    assert config.parse(config.to_toml(mission)).terrain() is terrain
    np.save(tmp_path / "level.npy", np.full((11, 11), 17.0))
    changed = config.load(path).terrain()
    assert changed is not None
    assert changed.height_at((500.0, 500.0)) == 12.0


def test_starts_are_placed_where_vehicles_can_stand() -> None:
    text = AREA + "[fleet]\nspacing_m = 20\n[terrain]\nseed = 7\nsteepest_deg = 85\n"
    mission = config.parse(text, overrides={"vehicles": 30})
    terrain = mission.terrain()
    assert terrain is not None
    starts = np.array([member.start for member in mission.team()])
    assert (terrain.slope_at(starts) <= radians(40)).all()


def test_kinds() -> None:
    text = '[fleet]\nkind = "rover"\n[[agents]]\nid = 2\nkind = "multirotor"\n'
    team = config.parse(AREA + text, overrides={"vehicles": 2}).team()
    assert [(member.kind, member.altitude_m) for member in team] == [
        ("rover", 0.0),
        ("multirotor", 40.0),
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('file = "level.npy"', "terrain.file: level.npy: an .npy file does not say its spacing"),
        ('file = "holes.npy"\ncell_m = 100', "terrain.file: holes.npy: 1 of 121 heights"),
        ('file = "empty.npy"\ncell_m = 1', "terrain.file: empty.npy: not an .npy file"),
        ('file = "odd.asc"', "terrain.file: odd.asc: header: nrows must be a whole number"),
        ('file = "none.tif"', "terrain.file: none.tif: No such file"),
        ('file = "none.txt"', "terrain.file: none.txt: not an elevation file"),
        ('file = "small.npy"\ncell_m = 100', "terrain.file: reaches from 0, 0, 500, 500"),
        ('file = "level.npy"\ncell_m = 100\nseed = 1', "terrain.seed: is for generated ground"),
        ('file = "level.npy"\ncell_m = 100\nwest_m = 1', "terrain.south_m: is missing"),
        (
            'file = "level.npy"\ncell_m = 100\nwest_m = 5000\nsouth_m = 0',
            "terrain.file: reaches from 5000, 0, 6000, 1000",
        ),
        ('file = "odd.asc"\ncell_m = 5', "terrain.cell_m: is for .npy files"),
        (
            "seed = 7\nsteepest_deg = 85\nalpha_deg = 0\nbeta_deg = 0",
            "vehicles: only 0 more starts fit into the area, on ground no steeper than "
            "terrain.alpha_deg, at a spacing of 50 m, 1 are needed",
        ),
        ("zero_m = 3", "terrain.zero_m: is for a file"),
        ("cell_m = 0.1", "terrain.cell_m: makes more than 4000000 heights"),
        ("beta_deg = 41", "terrain.beta_deg: must be at most alpha_deg = 40"),
        ("steepest_deg = 90", "terrain.steepest_deg: must be < 90"),
        (
            'file = "small.npy"\ncell_m = 100\n[[targets]]\nposition = [600, 600]',
            "targets[0].position: is off the terrain (0 to 500 east, 0 to 500 north)",
        ),
        (
            "seed = 7\nsteepest_deg = 85\n[fleet]\nstarts = [[500, 500]]",
            "fleet.starts[0]: is on a slope of 78.9 degrees, above 40.0",
        ),
        (
            "seed = 7\nsteepest_deg = 85\n[[agents]]\nid = 4\nstart = [500, 500]",
            "agents[0].start: is on a slope",
        ),
    ],
)
def test_what_does_not_fit(tmp_path: Path, text: str, message: str) -> None:
    missing(tmp_path)
    path = write(tmp_path, "[terrain]\n" + text + "\n")
    with pytest.raises(ConfigError) as error:
        config.load(path)
    assert message in str(error.value)
    assert str(error.value).startswith(str(path))
