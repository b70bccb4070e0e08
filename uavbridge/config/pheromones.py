"""``[pheromones]`` and ``[[obstacles]]``: tables of a mission file, and how they fit together."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING, Annotated, Literal

from msgspec import Meta

from planners.pheromone.keeper import Box, KeeperLaw
from planners.pheromone.law import FieldLaw, PathLaw, SpreadLaw
from uavbridge.config.field_error import FieldError, KeyPath
from uavbridge.config.tables import Point, Table
from uavbridge.safety.envelope import Braking

if TYPE_CHECKING:
    from uavbridge.config.mission import Mission

FIRST_PLACE = 1001  # id of the first place agent; those of vehicles are smaller
PLANNERS = ("pheromone", "pheromone-scenario")  # fly with copies when nothing else is said


class Obstacle(Table, frozen=True):
    """A column, from the ground up, that the safety filter keeps vehicles out of."""

    position: Annotated[Point, Meta(description="[x, y] of its axis in m")]
    radius_m: Annotated[float, Meta(gt=0.0, le=1e4, description="of the column")]
    clearance_m: Annotated[float, Meta(ge=0.0, le=1e3, description="room kept to it")] = 3.0
    known: Annotated[
        bool, Meta(description="agents know it before; else they see it, from sensor.sight_m away")
    ] = False


class Failure(Table, frozen=True):
    """A place agent that is out of service for a while, its memory lost."""

    place: Annotated[int, Meta(ge=FIRST_PLACE, description="id of the place agent")]
    from_s: Annotated[float, Meta(ge=0.0, description="mission time")]
    to_s: Annotated[float, Meta(ge=0.0, description="when it is back; absent: never")] = 86400.0


class Pheromones(Table, frozen=True):
    """Who keeps the pheromone maps, and by what law (Shao 2020, Table 1)."""

    form: Annotated[
        Literal["copies", "places"],
        Meta(description="each UAV keeps a copy, merged over the radio; or place agents do"),
    ] = "copies"
    tiles: Annotated[
        tuple[Annotated[int, Meta(ge=1, le=30)], Annotated[int, Meta(ge=1, le=30)]],
        Meta(description="place agents from west to east, and from south to north"),
    ] = (2, 2)
    positions: Annotated[
        tuple[Point, ...],
        Meta(description="[x, y] of the place agents in m, row by row; absent: middle of tiles"),
    ] = ()
    height_m: Annotated[float, Meta(ge=0.0, description="of their antennas")] = 2.0
    remote: Annotated[
        tuple[int, ...], Meta(description="place agents that the launcher does not host")
    ] = ()
    store: Annotated[
        bool, Meta(description="a place agent that comes back has what it stored every 10 s")
    ] = True
    failures: Annotated[
        tuple[Failure, ...], Meta(description="place agents that fail, to try it")
    ] = ()
    step_s: Annotated[float, Meta(ge=0.1, le=600.0, description="time between two updates")] = 1.0
    period: Annotated[
        int, Meta(ge=1, description="T: updates from a visit to a target to its next signal")
    ] = 500
    evaporation: Annotated[float, Meta(ge=0.0, le=1.0, description="E_tau, E_epsilon")] = 0.2
    diffusion: Annotated[float, Meta(ge=0.0, le=1.0, description="G_tau, G_epsilon")] = 0.2
    deposit: Annotated[float, Meta(ge=0.0, description="d_tau, d_epsilon")] = 1.0
    path_initial: Annotated[float, Meta(gt=0.0, description="sigma_0")] = 2.0
    path_least: Annotated[float, Meta(ge=0.0, description="sigma_min")] = 0.1
    path_reach: Annotated[
        float, Meta(ge=0.0, le=20.0, description="D_0, range of influence, cells")
    ] = 4.0
    attenuation: Annotated[float, Meta(gt=0.0, description="Q")] = 1.0
    recovery: Annotated[
        float, Meta(ge=0.0, description="path pheromone that comes back in an update")
    ] = 0.0
    wear: Annotated[
        Literal["falling", "printed"],
        Meta(description="Eq. (7): loss falls with the distance, or grows as printed"),
    ] = "falling"
    sources: Annotated[
        tuple[Point, ...],
        Meta(description="[x, y] in m that always give off target pheromone: the target region"),
    ] = ()
    before: Annotated[
        int, Meta(ge=0, le=5000, description="updates before the mission, for sources to spread")
    ] = 0

    @property
    def law(self) -> FieldLaw:
        """Of the three maps."""
        spread = SpreadLaw(self.evaporation, self.diffusion, self.deposit)
        path = PathLaw(
            self.path_initial,
            self.path_least,
            self.path_reach,
            self.attenuation,
            self.recovery,
            self.wear,
        )
        return FieldLaw(spread, spread, path)


def keeper_law(mission: Mission, table: Pheromones) -> KeeperLaw:
    """What the mission's maps are kept by."""
    cells = [mission.grid.cell_of(point).tolist() for point in table.sources]
    margin = max(6, int(table.path_reach))
    return KeeperLaw(table.law, table.period, margin, tuple((c, r) for c, r in cells))


def tiles(mission: Mission, table: Pheromones) -> dict[int, Box]:
    """The tile of each place agent by its id, row by row from the south-west."""
    across, up = table.tiles
    columns, rows = mission.grid.shape
    wests = [columns * i // across for i in range(across + 1)]
    souths = [rows * i // up for i in range(up + 1)]
    boxes = [
        Box(wests[i], souths[j], wests[i + 1], souths[j + 1])
        for j in range(up)
        for i in range(across)
    ]
    return {FIRST_PLACE + number: box for number, box in enumerate(boxes)}


def check_pheromones(mission: Mission) -> None:
    """Hold both tables against area and team. Raises FieldError."""
    _obstacles(mission)
    table = mission.pheromones
    if table is None:
        return
    if table.tiles[0] > mission.area.columns or table.tiles[1] > mission.area.rows:
        what = "are more than the area has cells"
        raise FieldError(("pheromones", "tiles"), what, list(table.tiles))
    places = tiles(mission, table)
    if table.positions and len(table.positions) != len(places):
        what = f"must be {len(places)}, one a tile"
        raise FieldError(("pheromones", "positions"), what, len(table.positions))
    for index, source in enumerate(table.sources):
        if not mission.grid.contains(source):
            raise FieldError(("pheromones", "sources", index), "is outside the area", list(source))
    named: list[tuple[KeyPath, int]] = [
        (("failures", index, "place"), one.place) for index, one in enumerate(table.failures)
    ]
    named += [(("remote", index), place) for index, place in enumerate(table.remote)]
    for path, place in named:
        if place not in places:
            raise FieldError(("pheromones", *path), "there is no such place agent", place)


def _obstacles(mission: Mission) -> None:
    team = mission.team()
    if mission.obstacles and any(member.kind == "plane" for member in team):
        what = "are kept by vehicles that can stop; there are planes in the team"
        raise FieldError(("obstacles",), what, len(mission.obstacles))
    braking, speed_m_s = Braking(), mission.safety.speed_m_s
    stop_m, sight_m = braking.stopping(speed_m_s), mission.sensor.sight_m
    if any(not each.known for each in mission.obstacles) and sight_m < stop_m:
        what = f"is less than the way to a stop from safety.speed_m_s, {stop_m:.0f} m"
        raise FieldError(("sensor", "sight_m"), what, sight_m)
    for index, obstacle in enumerate(mission.obstacles):
        x, y = obstacle.position
        for member in team:
            apart = hypot(member.start[0] - x, member.start[1] - y)
            if apart <= obstacle.radius_m + obstacle.clearance_m:
                what = f"leaves no room for the start of agent {member.id}"
                raise FieldError(("obstacles", index, "position"), what, [x, y])
