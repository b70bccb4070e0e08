"""Fly a mission from start to report."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from types import MappingProxyType

import msgspec
from rich.console import Console

from planners.planner import PlannerKind
from uavbridge.bus.security import OPERATOR
from uavbridge.clock import SECOND_US, STEPPED_DATE, to_us, wall_date, wall_s
from uavbridge.config import Mission, to_toml
from uavbridge.config.radio import radio_of
from uavbridge.errors import ConfigError, UavbridgeError
from uavbridge.monitor.progress import ProgressView
from uavbridge.monitor.steady import SteadyConsole
from uavbridge.monitor.web.pages import beside, check_extra
from uavbridge.recording.display import Display
from uavbridge.recording.parts import Rotation
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import MissionRecord, ScoreRecord, known
from uavbridge.report.page import write_report
from uavbridge.report.result import MissionResult
from uavbridge.report.summary import summary_json, summary_text
from uavbridge.runner import assemble
from uavbridge.runner.attach import attach
from uavbridge.runner.earlier import Earlier
from uavbridge.runner.fitness import Attached
from uavbridge.runner.folder import as_flown, prepare, with_ground
from uavbridge.runner.host import AgentHost
from uavbridge.runner.interrupts import interrupts
from uavbridge.runner.judge import Judge
from uavbridge.runner.outcome import Outcome, result_of, versions
from uavbridge.runner.paced import Aside, fly_paced
from uavbridge.runner.snapshot import facts_of, snapshot_of
from uavbridge.runner.stepped import fly_stepped

HOMEWARDS = "all vehicles return; once more (Ctrl-C) stops at once"

_log = logging.getLogger(__name__)


def launch(
    mission: Mission,
    *,
    kind: PlannerKind | None = None,
    web: bool = False,
    adopt_home: bool = False,
    adopt_speed: bool = False,
    earlier: Earlier | None = None,
) -> Outcome:
    """Fly, record, report.

    Args:
        mission: checked, with targets.
        kind: the planner; None: the installed one that the mission names.
        web: serve the mission's page while it flies.
        adopt_home: the origin moves to the home of the first vehicle that has an endpoint.
        adopt_speed: where vehicles have endpoints, fly as fast as their clocks go.
        earlier: what was flown of this mission before; it goes on from there.

    Raises:
        UavbridgeError: it cannot be flown; the message says why.
    """
    console = SteadyConsole(stderr=mission.json)
    aside = _page(mission, console) if web else None
    with attach(
        mission,
        adopt_home=adopt_home,
        adopt_speed=adopt_speed,
        resumes=earlier is not None,
        tell=console.print,
    ) as attached:
        result = fly_and_report(
            attached.mission,
            None,
            kind=kind,
            console=console,
            aside=aside,
            attached=attached.vehicles,
            earlier=earlier,
        )
    good = result.reached_goal and not result.failures
    return Outcome(
        summary=msgspec.json.decode(summary_json(result)),
        text=summary_text(result),
        exit_status=0 if good else 1,
    )


def fly_and_report(
    mission: Mission,
    folder: Path | None,
    *,
    kind: PlannerKind | None = None,
    console: Console | None = None,
    aside: Aside | None = None,
    attached: Mapping[int, Attached] = MappingProxyType({}),
    earlier: Earlier | None = None,
) -> MissionResult:
    """Fly a mission and leave recording, report and summary in a folder; see ``prepare``."""
    folder = prepare(mission, folder) if earlier is None else earlier.folder
    result = fly(
        mission,
        folder=folder,
        kind=kind,
        console=console,
        aside=aside,
        attached=attached,
        earlier=earlier,
    )
    try:
        with _writing(console):
            write_report(result, folder)
    except OSError as fault:
        raise UavbridgeError(f"out: no report in {folder}: {fault.strerror}") from None
    return result


def fly(
    mission: Mission,
    *,
    folder: Path | None,
    kind: PlannerKind | None = None,
    console: Console | None = None,
    aside: Aside | None = None,
    attached: Mapping[int, Attached] = MappingProxyType({}),
    earlier: Earlier | None = None,
) -> MissionResult:
    """Fly a mission; write its recording to ``folder``, unless that is None."""
    planner = assemble.planner_of(mission, kind)
    stepped = mission.clock == "stepped"
    date = STEPPED_DATE if stepped else wall_date()
    began_s = wall_s()
    recorder = Recorder(
        folder,
        mission_name=mission.name,
        epoch_ns=earlier.epoch_ns if earlier else int(date.timestamp()) * SECOND_US * 1000,
        mcap=mission.recording.mcap,
        rotation=_rotation(mission),
        part=earlier.part if earlier else 1,
    )
    display = _display(mission, recorder)
    if emulated := radio_of(mission).words():
        (console.print if console else _log.info)(f"radio emulated: {emulated}")
    flown_us = 0
    with recorder, interrupts(HOMEWARDS) as stop, _view(mission, console) as view:
        recorder.record("mission", 0, _mission_record(mission))

        def progress(t_us: int, judge: Judge, host: AgentHost) -> None:
            nonlocal flown_us
            flown_us = t_us
            if t_us % SECOND_US == 0:
                _record_score(recorder, judge)
                if display:
                    _show(display, t_us, judge, host)
            view(t_us, judge, host)

        if stepped:
            flown = fly_stepped(mission, planner, recorder=recorder, progress=progress, stop=stop)
        else:
            tell = console.print if console else _log.info
            flown = fly_paced(
                mission,
                planner,
                recorder=recorder,
                progress=progress,
                stop=stop,
                tell=tell,
                aside=aside,
                attached=attached,
                earlier=earlier,
            )
        result = result_of(
            flown.judge,
            duration_us=flown_us,
            wall_s=wall_s() - began_s,
            out=str(folder or ""),
            digest=recorder.digest(),
            events=flown.host.events,
            kept=flown.kept,
        )
        recorder.write("summary", flown_us, summary_json(result))
    return result


def _page(mission: Mission, console: Console) -> Aside:
    """The mission's page, in a process of its own beside the flight."""
    if mission.clock == "stepped":
        raise ConfigError("--web: a stepped mission is over at once; watch its recording instead")
    check_extra()
    identity = assemble.identity_of(mission, OPERATOR)
    return lambda router: beside(
        router, mission.name, lambda address: console.print(f"page {address}"), identity
    )


def _mission_record(mission: Mission) -> MissionRecord:
    return MissionRecord(
        to_toml(with_ground(as_flown(mission))), mission.seed, mission.clock, versions()
    )


def _record_score(recorder: Recorder, judge: Judge) -> None:
    last = judge.latest()
    record = ScoreRecord(
        last.coverage, last.entropy, last.uncertainty, last.found, known(last.separation_m)
    )
    recorder.record("score", last.t_us, record)


def _rotation(mission: Mission) -> Rotation:
    kept = mission.recording
    return Rotation(round(kept.part_mb * 1e6), to_us(60.0 * kept.part_min))


def _display(mission: Mission, recorder: Recorder) -> Display | None:
    wanted = mission.recording.mcap and mission.recording.foxglove and recorder.folder is not None
    return Display(recorder, mission) if wanted else None


def _show(display: Display, t_us: int, judge: Judge, host: AgentHost) -> None:
    merged = judge.union.probability, judge.union.seen
    display.second(t_us, judge.reports.values(), merged, judge.declared)
    display.log(host.events[display.logged :])


def _writing(console: Console | None) -> AbstractContextManager[object]:
    """Says that the report is being written, where people watch."""
    return console.status("writing the report") if console is not None else nullcontext()


@contextmanager
def _view(
    mission: Mission, console: Console | None
) -> Iterator[Callable[[int, Judge, AgentHost], None]]:
    """The live view, drawn a few times a second of mission time."""
    if console is None:
        yield lambda _t_us, _judge, _host: None
        return
    with ProgressView(console, facts_of(mission), headless=mission.headless) as shown:
        every_us = to_us(1.0)

        def draw(t_us: int, judge: Judge, host: AgentHost) -> None:
            if t_us % every_us == 0:
                shown.update(snapshot_of(t_us, judge))

        yield draw
