"""Where a mission leaves its files."""

from __future__ import annotations

from pathlib import Path

import pytest

from uavbridge import config
from uavbridge.config import Mission
from uavbridge.errors import ConfigError
from uavbridge.runner.folder import prepare

SMALL = 'name = "small"\n[area]\ncell_m = 50\ncolumns = 4\nrows = 4\n'


def small(**overrides: object) -> Mission:
    return config.parse(SMALL, "m.toml", overrides)


def test_missions_of_the_same_second_have_folders_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert len({prepare(small()) for _ in range(4)}) == 4


def test_what_an_earlier_flight_left_goes_and_nothing_else(tmp_path: Path) -> None:
    prepare(small(), tmp_path)
    for name in ("mission.mcap", "summary.json", "report.html", "vehicle_1.tlog", "notes.txt"):
        (tmp_path / name).write_text("old")
    prepare(small(), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"mission.toml", "notes.txt"}


def test_the_mission_as_flown_can_be_flown_again_elsewhere(tmp_path: Path) -> None:
    mission = small(out=str(tmp_path), json=True, headless=True, seed=5)
    assert prepare(mission) == tmp_path
    again = config.load(tmp_path / "mission.toml")
    assert again == small(seed=5)


def test_a_mission_of_ones_own_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "mission.toml").write_text(SMALL)
    prepare(small(), tmp_path)
    assert (tmp_path / "mission.toml").read_text() == SMALL
    assert config.load(tmp_path / "mission-as-flown.toml") == small()


@pytest.mark.parametrize("place", ["file", "file/below", "a\0b", "/proc/nowhere"])
def test_a_folder_that_cannot_be_is_told_of_in_one_line(tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match=r"^out: cannot write to "):
        prepare(small(), tmp_path / place)


def test_a_folder_in_the_place_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "mission.mcap").mkdir()
    with pytest.raises(ConfigError, match=r"^out: cannot write to "):
        prepare(small(), tmp_path)


def test_no_folder_at_all_is_a_mistake() -> None:
    with pytest.raises(ConfigError, match="out: is empty"):
        prepare(small(out=""))
