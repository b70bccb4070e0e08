"""A whole mission: what the file says, with all defaults filled in."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from msgspec import Meta

from planners.belief.prior import gaussian_prior
from planners.grid import Grid
from planners.terrain import Terrain
from planners.types import F64, Limits, Scenario
from uavbridge.config import ground as grounds
from uavbridge.config import starts
from uavbridge.config.ground import Ground, Signals
from uavbridge.config.pheromones import PLANNERS, Obstacle, Pheromones
from uavbridge.config.starts import Member
from uavbridge.config.tables import (
    MAX_VEHICLES,
    Agent,
    Area,
    Belief,
    Bus,
    Fleet,
    Home,
    Mavlink,
    Radio,
    Recording,
    Safety,
    Security,
    Sensor,
    Simulator,
    Table,
    Target,
    Wind,
)

DEFAULT_PLANNER = "esustpm"


class Mission(Table, frozen=True):
    """A mission file. Options of ``uavbridge launch`` override the key of the same name."""

    name: Annotated[
        str,
        Meta(
            pattern="^[a-z0-9]+(-[a-z0-9]+)*$",
            max_length=60,
            description="part of every key on the bus: small letters, digits, hyphens",
        ),
    ]
    area: Area
    seed: Annotated[int, Meta(ge=0, le=2**32 - 1, description="of all randomness")] = 1
    planner: Annotated[str, Meta(description="as `uavbridge planners` lists them")] = (
        DEFAULT_PLANNER
    )
    vehicles: Annotated[
        int,
        Meta(
            ge=1,
            le=MAX_VEHICLES,
            description="how many fly; absent: as many as there are starts or agents",
        ),
    ] = 0
    clock: Annotated[
        Literal["paced", "stepped"],
        Meta(description="paced: real time times speed; stepped: lockstep, as fast as it can"),
    ] = "paced"
    speed: Annotated[
        float, Meta(gt=0.0, le=1000.0, description="mission seconds per second (paced)")
    ] = 1.0
    duration: Annotated[float, Meta(gt=0.0, le=86400.0, description="time limit, s")] = 900.0
    out: Annotated[
        str | None, Meta(description="output folder; absent: one under runs/ by name and date")
    ] = None
    headless: Annotated[bool, Meta(description="no live view")] = False
    json: Annotated[bool, Meta(description="print the summary as one JSON document")] = False
    tick: Annotated[
        float, Meta(ge=0.05, le=60.0, description="time between two decisions of an agent, s")
    ] = 1.0
    coverage_goal: Annotated[
        float,
        Meta(
            ge=0.0,
            le=1.0,
            description="share of cells to be seen before all return; not with [signals]",
        ),
    ] = 0.9
    parameters: Annotated[
        dict[str, Any], Meta(description="of the planner, as `uavbridge planners` lists them")
    ] = msgspec.field(default_factory=dict)
    home: Home = Home()
    ground: Ground | None = msgspec.field(default=None, name="terrain")
    fleet: Fleet = Fleet()
    agents: tuple[Agent, ...] = ()
    sensor: Sensor = Sensor()
    signals: Signals | None = None
    belief: Belief = Belief()
    targets: tuple[Target, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    pheromones: Pheromones | None = None
    radio: Radio = Radio()
    safety: Safety = Safety()
    wind: Wind = Wind()
    bus: Bus = Bus()
    security: Security = Security()
    mavlink: Mavlink = Mavlink()
    simulator: Simulator = Simulator()
    recording: Recording = Recording()

    def __post_init__(self) -> None:
        if self.vehicles == 0:
            count = max(len(self.fleet.starts), len(self.agents), 1)
            msgspec.structs.force_setattr(self, "vehicles", count)

    @property
    def grid(self) -> Grid:
        """The search area."""
        area = self.area
        return Grid(area.west_m, area.south_m, area.cell_m, area.columns, area.rows)

    @property
    def limits(self) -> Limits:
        """What planners are told of the limits that the safety filter enforces."""
        safety = self.safety
        return Limits(
            safety.speed_m_s, safety.climb_m_s, safety.altitude_min_m, safety.altitude_max_m
        )

    @property
    def only_flies(self) -> bool:
        """Whether there is nothing to find, and all begin and end in the air."""
        return self.fleet.in_air and not self.targets

    def team(self) -> tuple[Member, ...]:
        """All agents by ascending id, with starts and search altitudes settled.

        Raises:
            ValueError: the area has no room for so many starts.
        """
        return starts.team(self.grid, self.fleet, self.agents, self.vehicles, self._stands())

    def terrain(self) -> Terrain | None:
        """The ground, made or read once; None: level, at the height of home.

        Raises:
            ValueError: its file cannot be read.
        """
        return None if self.ground is None else grounds.terrain(self.ground, self.home, self.grid)

    def _stands(self) -> starts.Stands | None:
        """Which points (k, 2) vehicles may start on; None: all."""
        ground, terrain = self.ground, self.terrain()
        if ground is None or terrain is None:
            return None
        return partial(grounds.stands, terrain, ground)

    def endpoint(self, agent: int) -> str | None:
        """Where the agent's vehicle is found; None: it is simulated."""
        return next((each.endpoint for each in self.agents if each.id == agent), None)

    def apart(self) -> frozenset[int]:
        """Agents that do not fly in the launcher's own process (paced missions only).

        Credentials belong to agents: where they are asked for, each has a process of its own.
        """
        if self.clock == "stepped":
            return frozenset()
        everybody = frozenset(member.id for member in self.team())
        by_themselves = self.bus.agents_per_process or self.security.keys is not None
        return everybody if by_themselves else frozenset(self.bus.remote)

    def target_cells(self) -> tuple[tuple[int, int], ...]:
        """(column, row) of the true targets, each cell once, in the file's order."""
        cells = [self.grid.cell_of(target.position) for target in self.targets]
        return tuple(dict.fromkeys((int(column), int(row)) for column, row in cells))

    def columns(self, *, known: bool) -> F64:
        """No-fly columns (k, 3) x, y, radius in m: those planners know before, or the others."""
        rows = [(*each.position, each.radius_m) for each in self.obstacles if each.known == known]
        return np.array(rows, np.float64).reshape(-1, 3)

    def all_columns(self) -> F64:
        """No-fly columns (k, 3), known before or not."""
        return np.concatenate((self.columns(known=True), self.columns(known=False)))

    def stigmergy(self) -> Pheromones | None:
        """Who keeps the pheromone maps; None: nobody."""
        if self.pheromones is None and self.planner in PLANNERS:
            return Pheromones()
        return self.pheromones

    def prior(self) -> F64:
        """P(target) of each cell (columns, rows) before the search."""
        belief = self.belief
        if not belief.expected:
            return np.full(self.grid.shape, belief.prior)
        return gaussian_prior(
            self.grid,
            [each.position for each in belief.expected],
            belief.sigma_m,
            floor=belief.prior,
            peak=belief.peak,
            weights=[each.weight for each in belief.expected],
        )

    def scenario(self) -> Scenario:
        """What every planner is bound to. Raises ValueError like ``team``."""
        members = self.team()
        return Scenario(
            grid=self.grid,
            team=tuple(member.id for member in members),
            starts=np.array([(*member.start, member.altitude_m) for member in members]),
            tick_s=self.tick,
            limits=self.limits,
            detection_threshold=self.belief.threshold,
            radio_range_m=self.radio.range_m,
            obstacles=self.columns(known=True),
        )

    def for_agents(self) -> Mission:
        """The mission as an agent may know it: without targets, and columns yet to be seen."""
        known = tuple(each for each in self.obstacles if each.known)
        return msgspec.structs.replace(self, targets=(), obstacles=known)

    def plain(self) -> dict[str, Any]:
        """As dicts, lists and scalars, without what is None, as a TOML file would hold it."""
        plain: dict[str, Any] = _without_none(msgspec.to_builtins(self))
        return plain


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_none(part) for key, part in value.items() if part is not None}
    if isinstance(value, list | tuple):
        return [_without_none(part) for part in value]
    return value
