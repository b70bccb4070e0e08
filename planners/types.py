"""What a planner is told and what it answers: plain frozen values.

SI units and radians; local ENU metres with the origin at the mission's home;
yaw from east, counter-clockwise. Points in time are integer microseconds since
mission start, durations are float seconds.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from planners.grid import Grid
from planners.terrain import Terrain

F64: TypeAlias = npt.NDArray[np.float64]
I64: TypeAlias = npt.NDArray[np.int64]
Bools: TypeAlias = npt.NDArray[np.bool_]

MICROSECONDS = 1_000_000


def _vector() -> F64:
    return np.zeros(3)


def _no_columns() -> F64:
    return np.zeros((0, 3))


@dataclass(frozen=True, slots=True)
class Limits:
    """What the vehicles of a mission may do; the safety filter holds them to it."""

    speed_m_s: float = 10.0
    climb_m_s: float = 3.0
    altitude_min_m: float = 15.0
    altitude_max_m: float = 120.0


@dataclass(frozen=True, slots=True, eq=False)
class Scenario:
    """What every agent knows before take-off; the same for the whole mission."""

    grid: Grid
    team: tuple[int, ...]  # agent ids, ascending
    starts: F64  # (len(team), 3) ENU m, in the order of team; z = search altitude
    tick_s: float  # time between two decisions
    limits: Limits = field(default_factory=Limits)
    detection_threshold: float = 0.95  # theta: a cell above it is declared
    radio_range_m: float = float("inf")
    obstacles: F64 = field(default_factory=_no_columns)  # (k, 3) x, y, radius m: known columns

    def index(self, agent: int) -> int:
        """Place of ``agent`` in the team, from 0. Raises ValueError for a stranger."""
        return self.team.index(agent)


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """Those heard over the radio, one a row, ascending id."""

    ids: I64  # (k,)
    position: F64  # (k, 3) ENU m, as last heard
    velocity: F64  # (k, 3) m/s
    age_s: F64  # (k,) time since it was sent
    payloads: tuple[bytes, ...] = ()  # planner payload of each

    @staticmethod
    def none() -> Neighbours:
        """Nobody heard."""
        return Neighbours(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))

    def __len__(self) -> int:
        return len(self.ids)


@dataclass(frozen=True, slots=True)
class Reading:
    """One look of the own payload sensor at one cell."""

    t_us: int
    cell: tuple[int, int]  # (column, row)
    detected: bool


@dataclass(frozen=True, slots=True)
class Signal:
    """What the own receiver heard of one target: no bearing, only how strong."""

    t_us: int
    target: int  # which; targets tell themselves apart
    strength: float
    arrived: bool  # so near that the target counts as found


@dataclass(frozen=True, slots=True)
class Answer:
    """What came back for an earlier ``Ask``."""

    key: str
    data: bytes
    age_s: float


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """All that one agent may know at one tick, and nothing else."""

    t_us: int
    tick: int  # decisions since the search began, from 0
    agent: int
    position: F64  # (3,) ENU m
    velocity: F64  # (3,) m/s
    heading_rad: float
    neighbours: Neighbours
    belief: F64  # (columns, rows) own map: P(target in cell)
    seen: Bools  # (columns, rows) observed by somebody, as far as this agent knows
    readings: tuple[Reading, ...] = ()  # own, since the last tick
    answers: tuple[Answer, ...] = ()
    signals: tuple[Signal, ...] = ()  # own, since the last tick
    terrain: Terrain | None = None  # ground in sensing range; None: not known, taken as level
    obstacles: F64 = field(default_factory=_no_columns)  # (k, 3) x, y, radius m: seen so far


@dataclass(frozen=True, slots=True, eq=False)
class GoTo:
    """Fly to a point and stay there."""

    position: F64  # (3,) ENU m
    yaw_rad: float | None = None
    speed_m_s: float | None = None  # None: the mission's limit


@dataclass(frozen=True, slots=True, eq=False)
class FlyVelocity:
    """Hold a velocity until the next tick; height is kept when its third part is 0."""

    velocity: F64 = field(default_factory=_vector)  # (3,) m/s ENU
    yaw_rad: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FlySegment:
    """Follow the straight line from start to end, then stay at the end."""

    start: F64  # (3,) ENU m
    end: F64  # (3,) ENU m
    speed_m_s: float | None = None


Setpoint: TypeAlias = GoTo | FlyVelocity | FlySegment


@dataclass(frozen=True, slots=True)
class Ask:
    """A question to a place agent or another service of the environment."""

    key: str
    data: bytes = b""


@dataclass(frozen=True, slots=True, eq=False)
class Edit:
    """A change of one named layer of the own grid map, beside the belief."""

    layer: str
    cells: I64  # (k, 2) column, row
    values: F64  # (k,)


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """What the planner wants until its next tick."""

    setpoint: Setpoint
    payload: bytes = b""  # rides on the beacon of the next frame
    edits: tuple[Edit, ...] = ()
    asks: tuple[Ask, ...] = ()
    note: str = ""  # the planner's state in its own words, for people
