"""Khan's setting as missions: the same grid, sensor, rules and start cells, with vehicles.

What differs beside the flight: agents exchange what missions exchange (every cell
that changed, heard a tick later and told on), a UAV reads a cell on entering it,
range is measured between vehicles and not between cells, and a search that names no
cell is given up before batteries are empty. Vehicles fly in layers, each at a height
of its own, and where two would start in one cell the later one starts in the next free
cell.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from planners.grid import Grid
from planners.types import I64
from uavbridge.config import Mission
from uavbridge.config.tables import (
    Agent,
    Area,
    Belief,
    Fleet,
    Radio,
    Recording,
    Safety,
    Sensor,
    Target,
)
from uavbridge.errors import ConfigError
from uavbridge.experiments.comparison.compare import search
from uavbridge.experiments.comparison.trial import Cell, Trial
from uavbridge.experiments.khan.choices import KhanParams, Scale
from uavbridge.experiments.khan.world import Fates, Luck

MERGE: Mapping[str, str] = {
    "UNC": "uncoordinated",
    "BU": "belief-update",
    "AVG": "average",
    "OGMM": "ogmm",
    "MOGM": "modified-ogmm",
    "SDS": "sensed-data",
    "COUNTS": "counts",
}  # rule: as ``belief.merge`` of a mission file names it

_LOWEST_M = 20.0  # height of the first layer
_LAYER_M, _LAYER_CELLS = 6.0, 0.15  # between layers, the lesser: so that ranges stay level ones
_SAME_SPOT = 0.5  # cells: two UAVs this close are in one cell, more or less
# What missions do their own way.
_FIXED = (
    "v",
    "phase",
    "order",
    "exchange",
    "observer",
    "counted",
    "untouched",
    "history",
    "relay",
    "talk",
    "forget",
)


def mission_of(
    choices: KhanParams,
    scale: Scale,
    rule: str,
    uavs: int,
    range_cells: float,
    seed: int,
    **changes: Any,
) -> Mission:
    """One search as a mission.

    Args:
        choices: the setting.
        scale: of the region.
        rule: one of ``MERGE``.
        uavs: N.
        range_cells: of the radio; 0: about one cell's width.
        seed: of the run; its start cells are those of the run without vehicles.
        changes: further keys of the mission.

    Raises:
        ConfigError: the setting has a choice that missions do not.
    """
    _check(choices)
    area = Area(cell_m=scale.cell_m, columns=choices.columns, rows=choices.rows)
    grid = Grid(0.0, 0.0, scale.cell_m, choices.columns, choices.rows)
    places = grid.centre_of(_starts(choices, uavs, seed))
    target = grid.centre_of(np.array((choices.target_column, choices.target_row)))
    layer_m = min(_LAYER_M, _LAYER_CELLS * scale.cell_m)
    heights = [_LOWEST_M + layer_m * place for place in range(uavs)]
    given: dict[str, Any] = {
        "name": "khan2014",
        "area": area,
        "seed": seed % 2**32,
        "clock": "stepped",
        "planner": "sweep",
        "parameters": {
            "pattern": choices.sweep,
            "entry": "nearest",
            "speed_m_s": scale.speed_m_s,
            "reach_m": scale.cell_m / 6.0,
        },
        "tick": _tick(scale),
        "duration": scale.flight_s,
        "coverage_goal": 0.0,
        "fleet": Fleet(starts=tuple((float(x), float(y)) for x, y in places)),
        "agents": tuple(Agent(id=i + 1, altitude_m=height) for i, height in enumerate(heights)),
        "sensor": Sensor(p=choices.p, q=choices.q),
        "belief": Belief(merge=MERGE[rule], threshold=choices.threshold),
        "targets": (Target(position=(float(target[0]), float(target[1]))),),
        "radio": Radio(range_m=max(range_cells, _SAME_SPOT) * scale.cell_m),
        "safety": Safety(
            separation=False,  # the layers are
            altitude_max_m=max(120.0, heights[-1] + 10.0),
            speed_m_s=max(10.0, scale.speed_m_s),
        ),
        "recording": Recording(mcap=False, tlog=False),
    }
    return Mission(**{**given, **changes})


def fly(
    choices: KhanParams,
    scale: Scale,
    rule: str,
    uavs: int,
    range_cells: float,
    seeds: I64,
    fidelity: str,
) -> Fates:
    """Searches with vehicles, until any cell is named; arguments as of ``mission_of``."""
    missions = [
        mission_of(choices, scale, rule, uavs, range_cells, seed) for seed in seeds.tolist()
    ]
    steps, cell, sent = [], [], []
    for trial in search(missions, fidelity, "named"):
        named = first_named(trial)
        steps.append(scale.step(scale.flight_s if named is None else trial.declared[named]))
        cell.append(-1 if named is None else named[0] * choices.rows + named[1])
        sent.append(trial.curves["bytes_per_agent"][-1] * uavs)
    target = np.full(len(seeds), choices.target)
    return Fates(np.array(steps), np.array(cell), target, np.array(sent))


def first_named(trial: Trial) -> Cell | None:
    """The cell declared first, the first of them by number; None: none was."""
    return min(trial.declared, key=lambda cell: (trial.declared[cell], cell), default=None)


def _tick(scale: Scale) -> float:
    """Three decisions a cell, as many tenths of a second as that takes."""
    return max(1, round(scale.step_s / 3.0 * 10.0)) / 10.0


def _starts(choices: KhanParams, uavs: int, seed: int) -> I64:
    """Start cells (N, 2), no two alike."""
    size = choices.columns * choices.rows
    if uavs > size:
        raise ConfigError(f"{uavs} UAVs need as many cells to start from, not {size}")
    draws = Luck(np.array([seed]), uavs, choices).start[0, :, 0]
    taken: list[int] = []
    for cell in (draws * size).astype(np.int64).tolist():
        while cell in taken:
            cell = (cell + 1) % size
        taken.append(cell)
    return np.stack(np.divmod(np.array(taken), choices.rows), axis=-1)


def _check(choices: KhanParams) -> None:
    """Refuse what missions cannot do."""
    for part in fields(choices):
        if part.name in _FIXED and getattr(choices, part.name) != part.default:
            raise ConfigError(
                f"missions exchange in their own way: {part.name} must stay {part.default}"
            )
