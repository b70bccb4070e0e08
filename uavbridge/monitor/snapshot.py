"""A mission at one moment, as people watch it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from uavbridge.agent.report import AgentReport
from uavbridge.report.quantity import count, plain


@dataclass(frozen=True, slots=True)
class MissionFacts:
    """What does not change while the mission flies."""

    name: str
    planner: str
    seed: int
    clock: str  # "stepped" or "paced"
    duration_s: float  # time limit
    targets: int
    coverage_goal: float  # share of cells
    separation_limit_m: float = float("nan")
    by_signal: bool = False  # targets are found by their signals: no cells are looked at


@dataclass(frozen=True, slots=True)
class VehicleLine:
    """One agent and its vehicle."""

    id: int
    phase: str  # the agent's
    mode: str  # the autopilot's own name of it
    height_m: float
    battery: float = float("nan")  # 0..1
    neighbours: int = 0  # heard over the radio
    note: str = ""  # the planner's words


def dropped(reports: Iterable[AgentReport]) -> Counter[str]:
    """Frames that the radio did not deliver to anybody, by reason."""
    total = Counter[str]()
    for report in reports:
        total.update(report.dropped)
    return total


def unheard(dropped: Counter[str]) -> str:
    """The same in words; empty: everything was heard."""
    told = ", ".join(f"{count(number)} {plain(why)}" for why, number in dropped.most_common())
    return f"not heard {told}" if told else ""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The mission at mission time ``t_s``; NaN where a number is not known."""

    t_s: float
    coverage: float = 0.0  # share of cells seen by some agent
    entropy: float = float("nan")  # bits, of the union of maps
    declared: int = 0  # true targets
    separation_m: float = float("nan")  # closest airborne pair now
    closest_m: float = float("nan")  # and so far
    frames_sent: int = 0
    bytes_sent: int = 0
    frames_heard: int = 0
    bytes_heard: int = 0
    vehicles: tuple[VehicleLine, ...] = ()
    status: str = ""  # "flying", "goal reached", ...
    alerts: tuple[str, ...] = field(default=())  # failures so far; the newest ones are shown
    dropped: Counter[str] = field(default_factory=Counter)  # frames not heard, by reason
