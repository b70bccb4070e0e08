"""The commands. Each imports what it needs when it runs, so that ``--help`` comes at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
from click.shell_completion import get_completion_class

from uavbridge.cli.command import command
from uavbridge.cli.doctor import doctor
from uavbridge.cli.experiments import compare, experiment
from uavbridge.cli.group import Group, echo_json, set_up_logging
from uavbridge.cli.mission import as_resumed, connecting, load, overrides
from uavbridge.cli.monitor import monitor
from uavbridge.cli.processes import agent, keys, router
from uavbridge.cli.replay import record, replay, report
from uavbridge.errors import BusError, ConfigError, LinkError

_MISSION = click.Path(dir_okay=True)  # config.load tells what is wrong with it


@click.group(cls=Group)
@click.version_option(package_name="uavbridge", prog_name="uavbridge")
@click.option("-v", "--verbose", count=True, help="Tell more on standard error; twice: everything.")
def main(verbose: int) -> None:
    """Fly a swarm of UAVs in search missions, simulated or real, over MAVLink."""
    set_up_logging(verbose)


@main.command()
@click.argument("mission", type=_MISSION, required=False)
@overrides
@click.option("--out", metavar="DIR", help="Output folder.")
@click.option("--headless", is_flag=True, default=None, help="No live view.")
@click.option("--json", is_flag=True, default=None, help="Print the summary as JSON.")
@click.option("--web", is_flag=True, help="Serve a page to watch it on.")
@connecting
@click.option(
    "--resume", metavar="DIR", help="Go on with the mission of a bridge that died, recorded in DIR."
)
@click.pass_context
def launch(
    ctx: click.Context,
    /,
    mission: str | None,
    web: bool,
    connect: tuple[str, ...],
    resume: str | None,
    **options: Any,
) -> None:
    """Fly MISSION: a TOML file, or a mission of the package by name, as zhou2023-rovers.

    Without it the built-in example, liu2022, is flown.
    The vehicles are simulated, but for those that --connect or the mission's endpoints name.
    Without MISSION, as many fly as there are --connect, and the first one's home is the origin.

    Options replace the keys of the same name in the file. Exit status: 0 when the mission
    reached its goal, 1 when not, 2 for bad input.
    """
    earlier = None
    if resume is not None:
        if mission is not None or connect or options["out"] is not None:
            raise ConfigError("--resume: the recording has its own mission, vehicles and folder")
        from uavbridge.runner.earlier import read_earlier

        earlier = read_earlier(Path(resume))
        loaded = as_resumed(earlier.mission, options)
    else:
        loaded = load(mission, connect, options)
    from uavbridge.runner.launch import launch as fly  # late: it takes a second to import

    try:
        outcome = fly(
            loaded,
            web=web,
            adopt_home=mission is None and bool(connect),
            adopt_speed=options["speed"] is None and earlier is None,
            earlier=earlier,
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
@overrides
@click.option("--json", "as_json", is_flag=True, help="Print what was understood as JSON.")
def check(mission: str | None, as_json: bool, **options: Any) -> None:
    """Say what MISSION means, or what is wrong with it, without flying.

    Exit status: 0 when it can be flown, 2 when not.
    """
    from uavbridge.check import probe, understood

    loaded = load(mission, (), options)
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


main.add_command(doctor)
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
    from sim_vehicles.command_line import main as simulate

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
