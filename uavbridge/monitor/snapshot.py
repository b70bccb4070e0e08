"""A mission at one moment, as people watch it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from uavbridge.agent.report import AgentReport, Clocks
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


def rejected(reports: Iterable[AgentReport]) -> Counter[str]:
    """Frames that no honest agent sends, by reason; agents of one process have one count."""
    most = Counter[str]()
    for report in reports:
        most |= Counter(report.rejected)
    return most


def apart(reports: Iterable[AgentReport]) -> str:
    """How far clocks of other machines are off the launcher's; empty: there are none."""
    known = [(r.clocks, r.agent) for r in reports if isinstance(r.clocks, Clocks)]
    if not known:
        return ""
    worst, agent = max(known, key=lambda one: abs(one[0].offset_s) + one[0].error_s)
    dated, other = max(known, key=lambda one: abs(one[0].date_offset_s))
    return (
        f"clocks: agent {agent} {1e3 * worst.offset_s:+.1f} ms (within {1e3 * worst.error_s:.1f}), "
        f"date of agent {other}'s machine {1e3 * dated.date_offset_s:+.0f} ms"
    )


def unheard(dropped: Counter[str], rejected: Counter[str]) -> str:
    """Both in words; empty: everything was heard."""
    told = []
    for what, counts in (("not heard", dropped), ("rejected", rejected)):
        if counts:
            each = [f"{count(number)} {plain(why)}" for why, number in counts.most_common()]
            told.append(f"{what} {', '.join(each)}")
    return "; ".join(told)


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
    rejected: Counter[str] = field(default_factory=Counter)  # that no honest agent sends
    clocks: str = ""  # how far those of other processes are off; empty: there are none
