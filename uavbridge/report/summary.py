"""The results in short: the JSON document of ``--json``, and a screen of text."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from textwrap import wrap

import msgspec
from msgspec import Struct

from uavbridge.report.quantity import count, data_size, duration, number, plain
from uavbridge.report.result import PROCESS, AgentResult, Event, MissionResult

_WIDTH = 80
_LISTED = 4  # targets, false targets and failures that the screen names one by one


class TargetSummary(Struct, frozen=True):
    """A true target; null where nobody declared it."""

    cell: tuple[int, int]
    found_at_s: float | None
    by: int | None


class AgentSummary(Struct, frozen=True):
    """An agent at the end."""

    id: int
    state: str
    distance_m: float
    frames_sent: int
    frames_heard: int
    bytes_sent: int
    bytes_heard: int
    # What summaries of older recordings lack has a default.
    bytes_offered: int = 0
    map_bytes_sent: int = 0
    dropped: dict[str, int] = {}  # frames, by reason
    dropped_bytes: dict[str, int] = {}
    rejected: dict[str, int] = {}
    # Of a process of its own, less the launcher's: mission time, its error, the machine's date.
    clock_offset_s: float | None = None
    clock_error_s: float | None = None
    date_offset_s: float | None = None


class Death(Struct, frozen=True):
    """A process of an agent's that died; ``back_s``: when another took over."""

    agent: int
    t_s: float
    back_s: float | None


class Summary(Struct, frozen=True, kw_only=True):
    """``summary.json``: numbers that are not known are null."""

    mission: str
    seed: int
    clock: str
    duration_s: float
    wall_s: float
    coverage: float | None
    uncertainty: float | None
    entropy: float | None
    targets: list[TargetSummary]
    false_targets: list[tuple[int, int]]
    agents: list[AgentSummary]
    min_separation_m: float | None
    failures: list[str]
    deaths: list[Death] = []
    digest: str
    out: str
    radio: str = ""  # what was emulated of it
    ticks: int = 0  # control ticks in real time; 0: stepped, or not known
    late_ticks: int = 0  # that began more than a tick late, or were left out


def summarise(result: MissionResult) -> Summary:
    """The document of ``--json``."""
    return Summary(
        mission=_valid(result.mission),
        seed=result.seed,
        clock=result.clock,
        duration_s=result.duration_s,
        wall_s=round(result.wall_s, 3),
        coverage=_finite(result.coverage),
        uncertainty=_finite(result.uncertainty),
        entropy=_finite(result.entropy),
        targets=[TargetSummary(t.cell, t.found_at_s, t.by) for t in result.targets],
        false_targets=list(result.false_targets),
        agents=[_agent(agent) for agent in result.agents],
        min_separation_m=_finite(result.min_separation_m),
        failures=[_valid(text) for text in result.failures],
        deaths=_deaths(result.events),
        digest=result.digest,
        out=_valid(result.out),
        radio=_valid(result.radio),
        ticks=result.ticks,
        late_ticks=result.late_ticks,
    )


def _deaths(events: Iterable[Event]) -> list[Death]:
    deaths: dict[int, list[Death]] = {}
    for event in events:
        if event.kind != PROCESS or event.agent is None:
            continue
        known = deaths.setdefault(event.agent, [])
        if known and known[-1].back_s is None:
            known[-1] = Death(event.agent, known[-1].t_s, event.t_s)
        else:
            known.append(Death(event.agent, event.t_s, None))
    return sorted((death for each in deaths.values() for death in each), key=lambda d: d.t_s)


def summary_json(result: MissionResult) -> bytes:
    """``summary.json``: one indented document with a newline at its end."""
    return msgspec.json.format(msgspec.json.encode(summarise(result)), indent=2) + b"\n"


def summary_text(result: MissionResult) -> str:
    """At most 24 lines of at most 80 columns for the terminal."""
    verdict = "goal reached" if result.reached_goal else "goal NOT reached"
    wall = result.wall_s
    speed = f" in {wall:.1f} s ({result.duration_s / wall:.1f}x)" if wall > 0 else ""
    goal = "" if math.isnan(result.coverage_goal) else f", goal {result.coverage_goal:.0%}"
    limit = (
        ""
        if math.isnan(result.separation_limit_m)
        else f", limit {number(result.separation_limit_m, 'm')}"
    )
    flown = sum(agent.distance_m for agent in result.agents)
    lines = [
        f"{plain(result.mission)}: {verdict}",
        "",
        _row("mission time", f"{duration(result.duration_s)}{speed}"),
        _row("seed, clock", f"{result.seed}, {result.clock}{_kept(result)}"),
        *([] if result.by_signal else _map_rows(result, goal)),
        *_target_rows(result),
        _row("closest pair", number(result.min_separation_m, "m") + limit),
        _row("agents", _states(result)),
        _row("flown", f"{flown / 1000:.1f} km"),
        _row("radio", _radio(result)),
        *(_wide("emulated", result.radio) if result.radio else ()),
        *_lost(result),
        *(_listing("notes", _wrapped(result.notes)) if result.notes else ()),
        *_listing("failures", [plain(text) for text in result.failures]),
        _row("digest", result.digest or "-"),
    ]
    cut = [line[:_WIDTH].rstrip() for line in lines]
    # People copy the path, so it is never cut.
    return "\n".join([*cut, _row("output", plain(result.out) or "-")])


def _map_rows(result: MissionResult, goal: str) -> list[str]:
    return [
        _row("coverage", f"{number(result.coverage * 100, '%')}{goal}"),
        _row("entropy", f"{number(result.entropy, 'bits')}, one-sided {_short(result)}"),
    ]


def _kept(result: MissionResult) -> str:
    """How many control ticks came late, where time was real."""
    share = result.late_ticks / result.ticks if result.ticks else 0.0
    return f", {share:.1%} of {count(result.ticks)} ticks late" if result.ticks else ""


def _valid(text: str) -> str:
    """The text without halves of characters, which JSON in UTF-8 can not hold."""
    return text.encode(errors="replace").decode()


def _short(result: MissionResult) -> str:
    return number(result.uncertainty, "")


def _target_rows(result: MissionResult) -> list[str]:
    total = len(result.targets)
    false = f", {len(result.false_targets)} false" if result.false_targets else ""
    word = "found" if result.by_signal else "declared"
    rows = [_row("targets", f"{result.found} of {total} {word}{false}")]
    for target in result.targets[:_LISTED]:
        if target.found_at_s is None:
            fate = "not found"
        else:
            by = "" if target.by is None else f" by agent {target.by}"
            fate = f"{word} at {duration(target.found_at_s)}{by}"
        rows.append(_row("", f"cell {target.cell[0]},{target.cell[1]} {fate}"))
    if total > _LISTED:
        rows.append(_row("", f"and {total - _LISTED} more"))
    return rows


def _wide(name: str, text: str) -> list[str]:
    """A row of as many lines as it takes."""
    lines = _wrapped([text])
    return [_row(name if place == 0 else "", line) for place, line in enumerate(lines)]


def _wrapped(texts: Iterable[str]) -> list[str]:
    """The texts in lines that fit beside the names."""
    room = _WIDTH - len(_row("", ""))
    return [line for text in texts for line in wrap(plain(text), room)]


def _listing(name: str, texts: list[str]) -> list[str]:
    if not texts:
        return [_row(name, "none")]
    rows = [_row(name if place == 0 else "", text) for place, text in enumerate(texts[:_LISTED])]
    if len(texts) > _LISTED:
        rows.append(_row("", f"and {len(texts) - _LISTED} more"))
    return rows


def _states(result: MissionResult) -> str:
    states = Counter(plain(agent.state) for agent in result.agents)
    return ", ".join(f"{total} {state}" for state, total in states.most_common()) or "none"


def _radio(result: MissionResult) -> str:
    agents = result.agents
    sent, heard = sum(a.frames_sent for a in agents), sum(a.frames_heard for a in agents)
    sent_bytes = data_size(sum(a.bytes_sent for a in agents))
    heard_bytes = data_size(sum(a.bytes_heard for a in agents))
    return f"{count(sent)} frames sent ({sent_bytes}), {count(heard)} heard ({heard_bytes})"


def _lost(result: MissionResult) -> list[str]:
    """What the radio did not deliver, and what nobody was to hear; nothing where there is none."""
    dropped, rejected = Counter[str](), Counter[str]()
    for agent in result.agents:
        dropped.update(agent.dropped)
        rejected |= Counter(agent.rejected)  # agents of one process have one count
    rows = []
    for name, counts in (("not heard", dropped), ("rejected", rejected)):
        if counts:
            told = ", ".join(f"{count(n)} {plain(why)}" for why, n in counts.most_common())
            rows += _wide(name, told)
    return rows


def _row(name: str, text: str) -> str:
    return f"  {name:<13} {text}"


def _agent(agent: AgentResult) -> AgentSummary:
    return AgentSummary(
        id=agent.id,
        state=agent.state,
        distance_m=_finite(agent.distance_m) or 0.0,
        frames_sent=agent.frames_sent,
        frames_heard=agent.frames_heard,
        bytes_sent=agent.bytes_sent,
        bytes_heard=agent.bytes_heard,
        bytes_offered=agent.bytes_offered,
        map_bytes_sent=agent.map_bytes_sent,
        dropped=dict(agent.dropped),
        dropped_bytes=dict(agent.dropped_bytes),
        rejected=dict(agent.rejected),
        clock_offset_s=agent.clock_offset_s,
        clock_error_s=agent.clock_error_s,
        date_offset_s=agent.date_offset_s,
    )


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
