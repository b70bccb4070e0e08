"""``uavbridge experiment``: the papers' tables and figures."""

from __future__ import annotations

import os
import shlex
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from uavbridge.cli.group import echo_json
from uavbridge.cli.steps import told
from uavbridge.errors import ConfigError

if TYPE_CHECKING:
    from uavbridge.experiments.experiment import Experiment, Outcome

Command = TypeVar("Command", bound=Callable[..., Any])

_WIDTH = 132  # of tables that no terminal shows


def _spread_options(command: Command) -> Command:
    """Options of everything that runs many times."""
    options = [
        click.option("--runs", type=int, metavar="N", help="Runs a case; default: its own."),
        click.option("--seed", type=int, default=1, metavar="S", help="Of all randomness."),
        click.option("--workers", type=int, metavar="W", help="Processes; default: one a core."),
        click.option("--dask", metavar="ADDRESS", help="Spread over this Dask cluster instead."),
        click.option(
            "--fidelity", default="ideal", metavar="ideal|dynamics|mavlink", help="What flies."
        ),
        click.option("--out", metavar="DIR", help="Write NAME.json, .csv, .png and .md there."),
        click.option("--json", "as_json", is_flag=True, help="Print the rows as JSON."),
    ]
    for option in reversed(options):
        command = option(command)
    return command


@click.command()
@click.argument("name", required=False)
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="A parameter.")
@_spread_options
def experiment(name: str | None, as_json: bool, **options: Any) -> None:
    """Repeat a table or a figure of a paper: NAME; without it, list them.

    Prints the paper's numbers beside ours. Same seed, same numbers, whatever the workers.
    Exit status: 0 when it ran, 2 for bad input.
    """
    if name is None:
        _list(as_json)
        return
    from uavbridge.experiments import registry

    parts = ["uavbridge", "experiment", name]
    for setting in options["settings"]:
        parts += ["--set", setting]
    found = registry.find(name)
    _run(found, _values(found, options["settings"]), parts, as_json, options)


@click.command()
@click.option("--planner", "planners", required=True, metavar="A,B,..", help="Planners, by commas.")
@click.option("--mission", metavar="FILE", help="Default: the built-in example.")
@click.option("--duration", type=float, metavar="S", help="Time limit, instead of the mission's.")
@_spread_options
def compare(
    planners: str, mission: str | None, duration: float | None, as_json: bool, **options: Any
) -> None:
    """Put planners, installed ones of others included, on one mission with equal seeds.

    Prints each planner's figures with 95 % intervals, and the differences to the first planner,
    seed by seed. Exit status: 0 when it ran, 2 for bad input.
    """
    from uavbridge.experiments.comparison.compare import EXPERIMENT

    values: dict[str, Any] = {"planners": planners}
    parts = ["uavbridge", "compare", "--planner", planners]
    if mission is not None:
        values["mission"] = mission
        parts += ["--mission", mission]
    if duration is not None:
        values["duration"] = duration
        parts += ["--duration", f"{duration:g}"]
    _run(EXPERIMENT, values, parts, as_json, options)


def _run(
    experiment: Experiment,
    values: dict[str, Any],
    command: list[str],
    as_json: bool,
    options: dict[str, Any],
) -> None:
    """Run, write and show."""
    from rich.console import Console

    from uavbridge.experiments import output, runner, spread

    workers = options["workers"] if options["workers"] is not None else os.cpu_count() or 1
    usual = experiment.usual_runs(options["fidelity"])
    runs = usual if options["runs"] is None else options["runs"]
    written: list[Path] = []
    with _progress(experiment.name) as progress:
        outcome = runner.run(
            experiment,
            spread.choose(workers, options["dask"]),
            runs=runs,
            seed=options["seed"],
            values=values,
            fidelity=options["fidelity"],
            progress=progress,
        )
        if options["out"] is not None:
            written = _write(outcome, command, Path(options["out"]))
    for path in written:
        click.echo(f"wrote {path}", err=True)
    if as_json:
        echo_json([row.as_data() for row in outcome.rows])
    else:
        console = Console()
        output.show(outcome, console if console.is_terminal else Console(width=_WIDTH))


def _write(outcome: Outcome, command: list[str], folder: Path) -> list[Path]:
    from uavbridge.experiments import output

    parts = [*command, "--runs", str(outcome.runs), "--seed", str(outcome.seed)]
    if outcome.fidelity != "ideal":
        parts += ["--fidelity", outcome.fidelity]
    try:
        return output.write(outcome, folder, shlex.join(parts))
    except OSError as error:
        raise ConfigError(f"--out {folder}: {error.strerror}") from error


def _list(as_json: bool) -> None:
    from uavbridge.cli import listing
    from uavbridge.experiments import registry

    if as_json:
        echo_json(listing.experiments_as_data(registry.everyone()))
    else:
        listing.show_experiments(registry.everyone())


def _values(experiment: Experiment, settings: Sequence[str]) -> dict[str, Any]:
    """``key=value`` by key; values as TOML spells them, anything else is a text.

    What must be a text is one, though it reads like a number: ``ranges=6``.
    """
    from planners.registry import described

    texts = {one.name for one in described(experiment.params) if one.kind is str}
    values = {}
    for setting in settings:
        key, sign, text = setting.partition("=")
        if not sign or not key:
            raise ConfigError(f"--set {setting}: must be KEY=VALUE")
        value = _value(text)
        values[key] = text if key in texts and not isinstance(value, str) else value
    return values


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


@contextmanager
def _progress(name: str) -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error; where it is no terminal, a line now and then."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        with told() as tell:
            yield lambda done, total: tell(f"{name}: {done} of {total} runs")
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task(name, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
