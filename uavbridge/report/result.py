"""What a mission came to, as plain values and arrays.

``uavbridge.run`` hands this back, and the report, ``summary.json`` and the
text at the end are made from it and nothing else. ENU metres in the mission
frame, seconds of mission time; NaN where a number is not known.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from planners.grid import Grid
from planners.terrain import Terrain
from planners.types import F64, I64, Bools
from uavbridge.bus.layers import Layer


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """How the mission went, sampled over time; all arrays (k,)."""

    t_s: F64
    coverage: F64  # share of cells seen by some agent
    entropy: F64  # bits, of the union of maps
    uncertainty: F64  # Liu 2022, one-sided
    declared: I64  # true targets declared so far
    separation_m: F64  # closest airborne pair; NaN with fewer than two in the air

    @staticmethod
    def empty() -> Series:
        """No samples."""
        none = np.zeros(0)
        return Series(none, none, none, none, np.zeros(0, np.int64), none)


@dataclass(frozen=True, slots=True, eq=False)
class Alliances:
    """Suballiances of the mountain search (Zhou 2023), sampled over time."""

    t_s: F64  # (k,)
    members: I64  # (k, targets) on the roster of each target's leader
    first: I64  # (k, targets) of them, who hear the target themselves: class I


@dataclass(frozen=True, slots=True)
class TargetResult:
    """One true target."""

    cell: tuple[int, int]  # (column, row)
    found_at_s: float | None = None  # None: no agent declared its cell, or came to its signal
    by: int | None = None
    position: tuple[float, float] | None = None  # None: somewhere in its cell


@dataclass(frozen=True, slots=True)
class AgentResult:
    """One agent at the end."""

    id: int
    state: str  # "landed", "lost", ...
    distance_m: float = 0.0  # flown
    frames_sent: int = 0
    frames_heard: int = 0
    bytes_sent: int = 0
    bytes_heard: int = 0
    bytes_offered: int = 0  # to its radio
    map_bytes_sent: int = 0  # of what was sent, for the map
    dropped: Mapping[str, int] = field(default_factory=dict)  # frames it did not hear, by reason
    dropped_bytes: Mapping[str, int] = field(default_factory=dict)
    rejected: Mapping[str, int] = field(default_factory=dict)  # impossible frames, by reason
    # Of an agent in a process of its own, less the launcher's, s: mission time, how well that is
    # known, and its machine's date.
    clock_offset_s: float | None = None
    clock_error_s: float | None = None
    date_offset_s: float | None = None


PROCESS = "process"  # kind of events: an agent's process died, or another took over


@dataclass(frozen=True, slots=True)
class Event:
    """Something that people should know of."""

    t_s: float
    text: str
    agent: int | None = None
    kind: str = "said"


@dataclass(frozen=True, slots=True, eq=False)
class MissionResult:
    """One mission, from start to landing."""

    mission: str  # its name
    seed: int
    clock: str  # "stepped" or "paced"
    duration_s: float  # mission time
    wall_s: float
    reached_goal: bool
    grid: Grid
    series: Series = field(default_factory=Series.empty)
    tracks: Mapping[int, F64] = field(default_factory=dict)  # agent: (k, 3)
    belief: F64 | None = None  # (columns, rows) union of the maps at the end; None: not known
    seen: Bools | None = None  # (columns, rows); None: taken as all seen
    by_signal: bool = False  # targets gave signals: no cells were looked at
    terrain: Terrain | None = None  # None: level ground
    climb_rad: float = float("nan")  # beta of the terrain
    alliances: Alliances | None = None
    layers: Mapping[str, Layer] = field(default_factory=dict)  # as they were last
    columns: F64 = field(default_factory=lambda: np.zeros((0, 3)))  # no-fly: x, y, radius in m
    planes: bool = False  # fixed-wing aircraft flew
    agent_beliefs: Mapping[int, F64] = field(default_factory=dict)  # agent: (columns, rows)
    coverage: float = float("nan")
    uncertainty: float = float("nan")
    entropy: float = float("nan")
    targets: tuple[TargetResult, ...] = ()
    false_targets: tuple[tuple[int, int], ...] = ()  # cells
    agents: tuple[AgentResult, ...] = ()
    radio: str = ""  # what was emulated of it; empty: nothing, or not known
    min_separation_m: float = float("nan")  # airborne pairs, all phases
    coverage_goal: float = float("nan")
    separation_limit_m: float = float("nan")
    events: tuple[Event, ...] = ()
    failures: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()  # what is not known, or known another way than usual
    mission_text: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    repeat: str = ""  # the command that flies it again
    digest: str = ""
    out: str = ""  # the output folder
    ticks: int = 0  # control ticks of a paced mission; 0: not known
    late_ticks: int = 0  # of them, those that began more than a tick late, or were left out

    @property
    def found(self) -> int:
        """True targets declared."""
        return sum(target.found_at_s is not None for target in self.targets)
