"""``uavbridge experiment``: the papers' tables and figures."""

from __future__ import annotations

import os
import shlex
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from uavbridge.cli.group import echo_json
from uavbridge.errors import ConfigError

_WIDTH = 132  # of tables that no terminal shows


@click.command()
@click.argument("name", required=False)
@click.option("--runs", type=int, metavar="N", help="Runs a case; default: the experiment's.")
@click.option("--seed", type=int, default=1, metavar="S", help="Of all randomness.")
@click.option("--workers", type=int, metavar="W", help="Processes; default: one a core.")
@click.option("--dask", metavar="ADDRESS", help="Spread the runs over this Dask cluster instead.")
@click.option("--fidelity", default="ideal", metavar="ideal|dynamics|mavlink", help="What flies.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="A parameter.")
@click.option("--out", metavar="DIR", help="Write NAME.json, .csv, .png and .md there.")
@click.option("--json", "as_json", is_flag=True, help="Print the rows as JSON.")
def experiment(name: str | None, as_json: bool, **options: Any) -> None:
    """Repeat a table or a figure of a paper: NAME; without it, list them.

    Prints the paper's numbers beside ours. Same seed, same numbers, whatever the workers.
    Exit status: 0 when it ran, 2 for bad input.
    """
    if name is None:
        _list(as_json)
        return
    from rich.console import Console

    from uavbridge.experiments import output, registry, runner, spread

    found = registry.find(name)
    workers = options["workers"] if options["workers"] is not None else os.cpu_count() or 1
    with _progress(name) as progress:
        outcome = runner.run(
            found,
            spread.choose(workers, options["dask"]),
            runs=found.runs if options["runs"] is None else options["runs"],
            seed=options["seed"],
            values=_values(options["settings"]),
            fidelity=options["fidelity"],
            progress=progress,
        )
    if options["out"] is not None:
        _write(outcome, options)
    if as_json:
        echo_json([row.as_data() for row in outcome.rows])
    else:
        console = Console()
        output.show(outcome, console if console.is_terminal else Console(width=_WIDTH))


def _write(outcome: Any, options: dict[str, Any]) -> None:
    from uavbridge.experiments import output

    parts = ["uavbridge", "experiment", outcome.experiment.name]
    parts += ["--runs", str(outcome.runs), "--seed", str(outcome.seed)]
    if outcome.fidelity != "ideal":
        parts += ["--fidelity", outcome.fidelity]
    for setting in options["settings"]:
        parts += ["--set", setting]
    try:
        paths = output.write(outcome, Path(options["out"]), shlex.join(parts))
    except OSError as error:
        raise ConfigError(f"--out {options['out']}: {error.strerror}") from error
    for path in paths:
        click.echo(f"wrote {path}", err=True)


def _list(as_json: bool) -> None:
    from uavbridge.cli import listing
    from uavbridge.experiments import registry

    if as_json:
        echo_json(listing.experiments_as_data(registry.everyone()))
    else:
        listing.show_experiments(registry.everyone())


def _values(settings: Sequence[str]) -> dict[str, Any]:
    """``key=value`` by key; values as TOML spells them, anything else is a text."""
    values = {}
    for setting in settings:
        key, sign, text = setting.partition("=")
        if not sign or not key:
            raise ConfigError(f"--set {setting}: must be KEY=VALUE")
        values[key] = _value(text)
    return values


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


@contextmanager
def _progress(name: str) -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    console = Console(stderr=True)
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task(name, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
