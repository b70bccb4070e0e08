"""Read mission files: TOML, overrides, and every error as one line of ``ConfigError``."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from importlib.resources.abc import Traversable
from os import PathLike
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from planners.planner import PlannerKind
from uavbridge import plugins
from uavbridge.config import rules
from uavbridge.config.convert import convert
from uavbridge.config.field_error import FieldError, dotted, line_of
from uavbridge.config.mission import DEFAULT_PLANNER, Mission
from uavbridge.errors import ConfigError

EXAMPLE = "liu2022"
_LARGEST_FILE = 1_000_000  # characters


def load(
    path: str | PathLike[str] | None = None,
    overrides: Mapping[str, object] | None = None,
    *,
    planners: Mapping[str, PlannerKind] | None = None,
) -> Mission:
    """Read and check a mission file.

    Args:
        path: of the file, or the name of a mission of the package (``packaged``) where there is
            no such file; None: the built-in example.
        overrides: values that replace the file's, by dotted key (``vehicles``,
            ``bus.router``); None values change nothing. Another planner than the file's takes
            none of the file's [parameters].
        planners: that may be named; None: all that are installed.

    Raises:
        ConfigError: the file cannot be read, or something in it is wrong.
    """
    ours = packaged()
    name = EXAMPLE if path is None else str(path)
    file = Path(name)
    if path is None or (name in ours and not file.exists()):
        text = ours[name].read_text(encoding="utf-8")
        folder = Path(str(ours[name])).parent  # of the files beside it, in an unpacked package
        return _parsed(text, f"{name}.toml", overrides, planners, folder)
    return _parsed(_read(file), name, overrides, planners, file.parent)


def packaged() -> dict[str, Traversable]:
    """The missions that come with the package, by name."""
    found = (files("uavbridge") / "missions").iterdir()
    missions = {file.name: file for file in found if file.name.endswith(".toml")}
    return {name.removesuffix(".toml"): missions[name] for name in sorted(missions)}


def parse(
    text: str,
    name: str = "mission",
    overrides: Mapping[str, object] | None = None,
    *,
    planners: Mapping[str, PlannerKind] | None = None,
) -> Mission:
    """Like ``load`` for the text of a mission file; ``name`` stands for it in messages."""
    return _parsed(text, name, overrides, planners, Path())


def _parsed(
    text: str,
    name: str,
    overrides: Mapping[str, object] | None,
    planners: Mapping[str, PlannerKind] | None,
    folder: Path,
) -> Mission:
    given = {key: value for key, value in (overrides or {}).items() if value is not None}
    data = _decode(text, name)
    try:
        _override(data, given)
        mission = placed(convert(data), folder)
        rules.check(mission, plugins.planners() if planners is None else planners)
    except FieldError as error:
        raise ConfigError(_located(error, text, name, given)) from None
    return mission


def override(
    mission: Mission,
    changes: Mapping[str, object],
    *,
    planners: Mapping[str, PlannerKind] | None = None,
) -> Mission:
    """A mission with some keys replaced (dotted names, as in ``load``), checked again.

    Raises:
        ConfigError: a change does not fit.
    """
    data = mission.plain()
    try:
        _override(data, changes)
        changed = convert(data)
        rules.check(changed, plugins.planners() if planners is None else planners)
    except FieldError as error:
        raise ConfigError(f"{dotted(error.path)}: {error}") from None
    return changed


def _read(path: Path) -> str:
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not UTF-8 text (byte {error.start})") from None
    except FileNotFoundError:
        hint = "" if path.suffix else f"; missions of the package: {', '.join(packaged())}"
        raise ConfigError(f"{path}: no such mission file{hint}") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ConfigError(f"{path}: cannot be read: {reason}") from None
    if len(text) > _LARGEST_FILE:
        raise ConfigError(f"{path}: is too large for a mission file")
    return text


def placed(mission: Mission, folder: Path) -> Mission:
    """With whole paths of files that it names, so that it can be flown from anywhere.

    Args:
        mission: as its text has it.
        folder: that the text was in.

    Raises:
        FieldError: that makes no path.
    """
    ground, security = mission.ground, mission.security
    if ground is not None and ground.file is not None:
        file = _whole(folder, ground.file, ("terrain", "file"))
        mission = replace(mission, ground=replace(ground, file=file))
    if security.keys is not None:
        keys = _whole(folder, security.keys, ("security", "keys"))
        mission = replace(mission, security=replace(security, keys=keys))
    return mission


def _whole(folder: Path, path: str, key: tuple[str, ...]) -> str:
    try:
        return str((folder / path).resolve())
    except (OSError, ValueError, RuntimeError) as error:
        raise FieldError(key, str(error), path) from None


def _decode(text: str, name: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ConfigError(f"{name}: is not valid TOML: nested too deep") from None
    except ValueError as error:  # TOMLDecodeError, and int()'s own on endless digits
        reason = str(error)
        raise ConfigError(f"{name}: is not valid TOML: {reason[0].lower()}{reason[1:]}") from None


def _override(data: dict[str, Any], overrides: Mapping[str, object]) -> None:
    """Set the keys in place."""
    planner = overrides.get("planner")
    if planner is not None and planner != data.get("planner", DEFAULT_PLANNER):
        data.pop("parameters", None)
    for key, value in overrides.items():
        *tables, last = key.split(".")
        table: Any = data
        for name in tables:
            table = table.setdefault(name, {})
            if not isinstance(table, dict):
                raise FieldError((name,), "must be a table", table)
        table[last] = value


def _located(error: FieldError, text: str, name: str, given: Mapping[str, object]) -> str:
    key = dotted(error.path)
    if key in given:
        return f"--{error.path[-1]}: {error}"
    line = line_of(text, error.path)
    return f"{name if line is None else f'{name}:{line}'}: {key or 'mission'}: {error}"
