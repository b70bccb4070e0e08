"""``uavbridge record``, ``replay`` and ``report``: recordings made, played, told of."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from uavbridge.cli.command import KEYS, ROUTER, choose_mission, identity_of
from uavbridge.cli.numbers import ABOVE_ZERO, NOT_NEGATIVE
from uavbridge.cli.steps import steps, told
from uavbridge.errors import ConfigError

if TYPE_CHECKING:
    from uavbridge.recording.recorder import Recorder


class _Folder(click.Path):
    """A folder to write to, which must have a name."""

    def convert(
        self,
        value: str | os.PathLike[str],
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> Any:
        if not str(value):
            self.fail("is empty", param, ctx)
        return super().convert(value, param, ctx)


_FOLDER = _Folder(path_type=Path)


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--speed", type=ABOVE_ZERO, default=1.0, show_default=True, help="Times real time.")
@click.option("--listen", metavar="ENDPOINT", default="auto", show_default=True, help="Router's.")
@click.option("--verify", is_flag=True, help="Take every decision again instead, and compare.")
@click.option(
    "--from", "from_s", type=NOT_NEGATIVE, default=0.0, help="Verify from this mission time, s."
)
@click.pass_context
def replay(ctx: click.Context, /, recording: Path, **options: Any) -> None:
    """Play RECORDING (mission.mcap, or its folder) to any monitor, or verify it.

    Exit status of --verify: 0 when every decision is taken again as recorded, 1 when not.
    """
    if options["verify"]:
        from uavbridge.replay.verify import verify

        with steps("verifying") as tell:
            result = verify(recording, from_s=options["from_s"], progress=tell)
        if not result.ok:
            click.echo(result.difference, err=True)
            ctx.exit(1)
        click.echo(f"{result.decisions} decisions taken again, none differs")
        return
    from uavbridge.bus.zenoh_bus import Router, ZenohBus
    from uavbridge.clock import PacedClock
    from uavbridge.replay.play import mission_name, play
    from uavbridge.runner.interrupts import interrupts

    name = mission_name(recording)
    with Router(options["listen"]) as router, ZenohBus(router.endpoint, name) as bus:
        click.echo(f"zenoh router {router.endpoint}, keys uavbridge/{name}/**")
        with interrupts("replay ends") as stop, steps("playing") as tell:
            clock = PacedClock(options["speed"])
            count = play(recording, bus, clock, stop=stop, progress=tell)
    click.echo(f"{count} messages played")


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--out", type=_FOLDER, help="Folder; else the recording's own.")
def report(recording: Path, out: Path | None) -> None:
    """Write report.html and summary.json of RECORDING, also of a flight that was cut short."""
    from uavbridge.report.page import write_report
    from uavbridge.report.recorded import recorded_result
    from uavbridge.report.summary import summary_text

    with steps("reading") as tell:
        result = recorded_result(recording, progress=tell)
    folder = out or Path(result.out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with told() as tell_figure:
            page = write_report(result, folder, lambda name: tell_figure(f"drawing: {name}"))
    except OSError as fault:
        raise ConfigError(f"--out: cannot write to {folder}: {fault.strerror}") from None
    click.echo(summary_text(result))
    click.echo(f"\n{page}")


@click.command()
@click.option("--out", type=_FOLDER, required=True, help="Folder to write to.")
@click.option("--mission", metavar="NAME", help="Which, if more than one flies.")
@click.option("--router", metavar="ENDPOINT", default=ROUTER, show_default=True, help="Of the bus.")
@KEYS
def record(out: Path, mission: str | None, router: str, keys: Path | None) -> None:
    """Join a flying mission and record what its bus carries, until it ends or Ctrl-C."""
    from uavbridge.bus.zenoh_bus import ZenohBus, find_missions
    from uavbridge.replay.record import Joined, Onlooker
    from uavbridge.replay.record import record as write_down
    from uavbridge.runner.interrupts import interrupts

    name = choose_mission(find_missions(router, identity=identity_of(keys)), mission, router)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise ConfigError(f"--out: cannot write to {out}: {fault.strerror}") from None
    with (
        ZenohBus(router, name, identity=identity_of(keys)) as bus,
        interrupts("recording ends") as stop,
    ):
        joined = Joined(bus, stop)
        with _recorder(out, name) as recorder, steps(f"recording {name}") as tell:
            click.echo(f"recording {name} to {out}, Ctrl-C ends it", err=True)
            count = write_down(joined, Onlooker(recorder), stop=stop, progress=tell)
    click.echo(f"{count} messages in {out}")


def _recorder(folder: Path, mission: str) -> Recorder:
    """Of a new recording, or one that goes on with what an earlier recorder left there."""
    from uavbridge.clock import SECOND_US, wall_date
    from uavbridge.recording.parts import begun
    from uavbridge.recording.reader import Recording
    from uavbridge.recording.recorder import BUS, Recorder

    part, epoch_ns = 1, int(wall_date().timestamp()) * SECOND_US * 1000
    if begun(folder):
        before = Recording(folder)
        if not before.from_bus or before.mission_name != mission:
            raise ConfigError(f"--out: {folder} holds a recording of {before.mission_name} already")
        part, epoch_ns = max(before.parts) + 1, before.epoch_ns
    return Recorder(folder, mission_name=mission, epoch_ns=epoch_ns, source=BUS, part=part)
