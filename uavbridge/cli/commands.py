"""The commands. Each imports what it needs when it runs, so that ``--help`` comes at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem, get_completion_class

from uavbridge.cli.command import command
from uavbridge.cli.experiments import compare, experiment
from uavbridge.cli.group import Group, echo_json, set_up_logging
from uavbridge.cli.monitor import monitor
from uavbridge.cli.processes import agent, keys, router
from uavbridge.cli.replay import record, replay, report
from uavbridge.errors import BusError, LinkError

if TYPE_CHECKING:
    from uavbridge.config import Mission

Command = TypeVar("Command", bound=Callable[..., Any])

_MISSION = click.Path(dir_okay=True)  # config.load tells what is wrong with it


_TABLES = {"router": "bus.", "agents_per_process": "bus."}


def _complete_planner(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    from uavbridge.plugins import planners

    return [
        CompletionItem(name, help=kind.summary)
        for name, kind in planners().items()
        if name.startswith(incomplete)
    ]


def _overrides(command: Command) -> Command:
    """Options that replace the mission file's keys of the same name."""
    options = [
        click.option("--vehicles", type=int, metavar="N", help="How many fly."),
        click.option(
            "--planner", metavar="NAME", help="Who decides.", shell_complete=_complete_planner
        ),
        click.option("--seed", type=int, metavar="S", help="Of all randomness."),
        click.option("--speed", type=float, metavar="X", help="Mission seconds per second."),
        click.option("--duration", type=float, metavar="S", help="Time limit in mission seconds."),
        click.option("--clock", metavar="paced|stepped", help="Real time, or lockstep."),
        click.option("--router", metavar="ENDPOINT", help="External zenoh router [bus.router]."),
        click.option(
            "--agents-per-process",
            type=int,
            metavar="K",
            help="Agents in child processes [bus.agents_per_process].",
        ),
    ]
    for option in reversed(options):
        command = option(command)
    return command


def _keys(options: dict[str, Any]) -> dict[str, Any]:
    """Options by the dotted keys of the mission file."""
    return {_TABLES.get(name, "") + name: value for name, value in options.items()}


_connect = click.option(
    "--connect",
    multiple=True,
    metavar="URL",
    help="Vehicle of the next agent, such as udpin:127.0.0.1:14540; again for more.",
)


def _load(mission: str | None, connect: tuple[str, ...], options: dict[str, Any]) -> Mission:
    """The mission of the command line."""
    from uavbridge import config
    from uavbridge.config.connect import connect as connected

    keys = _keys(options)
    if mission is None and connect and keys["vehicles"] is None:
        keys["vehicles"] = len(connect)
    return connected(config.load(mission, keys), connect)


@click.group(cls=Group)
@click.version_option(package_name="uavbridge", prog_name="uavbridge")
@click.option("-v", "--verbose", count=True, help="Tell more on standard error; twice: everything.")
def main(verbose: int) -> None:
    """Fly a swarm of UAVs in search missions, simulated or real, over MAVLink."""
    set_up_logging(verbose)


@main.command()
@click.argument("mission", type=_MISSION, required=False)
@_overrides
@click.option("--out", metavar="DIR", help="Output folder.")
@click.option("--headless", is_flag=True, default=None, help="No live view.")
@click.option("--json", is_flag=True, default=None, help="Print the summary as JSON.")
@click.option("--web", is_flag=True, help="Serve a page to watch it on.")
@_connect
@click.pass_context
def launch(
    ctx: click.Context, /, mission: str | None, web: bool, connect: tuple[str, ...], **options: Any
) -> None:
    """Fly MISSION: a TOML file, or a mission of the package by name, as zhou2023-rovers.

    Without it the built-in example, liu2022, is flown.
    The vehicles are simulated, but for those that --connect or the mission's endpoints name.
    Without MISSION, as many fly as there are --connect, and the first one's home is the origin.

    Options replace the keys of the same name in the file. Exit status: 0 when the mission
    reached its goal, 1 when not, 2 for bad input.
    """
    loaded = _load(mission, connect, options)
    from uavbridge.runner.launch import launch as fly  # late: it takes a second to import

    try:
        outcome = fly(
            loaded,
            web=web,
            adopt_home=mission is None and bool(connect),
            adopt_speed=options["speed"] is None,
        )
    except (BusError, LinkError) as error:
        raise error.at(mission or "built-in example") from None
    if loaded.json:
        echo_json(outcome.summary)
    else:
        click.echo(outcome.text)
    ctx.exit(outcome.exit_status)


@main.command()
@click.argument("mission", type=_MISSION, required=False)
@_overrides
@click.option("--json", "as_json", is_flag=True, help="Print what was understood as JSON.")
def check(mission: str | None, as_json: bool, **options: Any) -> None:
    """Say what MISSION means, or what is wrong with it, without flying.

    Exit status: 0 when it can be flown, 2 when not.
    """
    from uavbridge import config
    from uavbridge.check import probe, understood

    loaded = config.load(mission, _keys(options))
    probe(loaded, mission or "built-in example")
    facts = understood(loaded)
    if as_json:
        echo_json(facts)
    else:
        click.echo("\n".join(facts.lines()))


@main.command()
@click.option("--json", "as_json", is_flag=True, help="Print them as JSON.")
def planners(as_json: bool) -> None:
    """List the installed planners with their parameters, units and defaults."""
    from uavbridge import plugins
    from uavbridge.cli import listing

    found = plugins.planners()
    if as_json:
        echo_json(listing.as_data(found))
    else:
        listing.show(found)


main.add_command(agent)
main.add_command(router)
main.add_command(keys)
main.add_command(monitor)
main.add_command(command)
main.add_command(record)
main.add_command(replay)
main.add_command(report)
main.add_command(experiment)
main.add_command(compare)


@main.command(
    context_settings={"ignore_unknown_options": True, "help_option_names": []},
    add_help_option=False,
)
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def sim(arguments: tuple[str, ...]) -> None:
    """Run the vehicle simulator alone, as `sim-vehicles` does (see `uavbridge sim --help`)."""
    from sim_vehicles.__main__ import main as simulate

    simulate(list(arguments), prog_name="uavbridge sim")


@main.command()
def schema() -> None:
    """Print the JSON schema of mission files, for editors."""
    from uavbridge.config import json_schema

    echo_json(json_schema())


@main.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def completion(shell: str) -> None:
    """Print the completion script of a SHELL.

    For bash: uavbridge completion bash > ~/.local/share/bash-completion/completions/uavbridge
    """
    kind = get_completion_class(shell)
    if kind is None:
        raise click.BadParameter(shell, param_hint="shell")
    click.echo(kind(main, {}, "uavbridge", "_UAVBRIDGE_COMPLETE").source())
