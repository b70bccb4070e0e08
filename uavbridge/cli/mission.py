"""The mission that several commands take: its file, and options that replace some of its keys."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

if TYPE_CHECKING:
    from uavbridge.config import Mission

Command = TypeVar("Command", bound=Callable[..., Any])

_TABLES = {
    "router": "bus.",
    "agents_per_process": "bus.",
    "signing_keys": "mavlink.",
    "driver": "mavlink.",
}


def _complete_planner(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    from uavbridge.plugins import planners

    return [
        CompletionItem(name, help=kind.summary)
        for name, kind in planners().items()
        if name.startswith(incomplete)
    ]


def overrides(command: Command) -> Command:
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
        click.option(
            "--driver", metavar="uavbridge|mavsdk", help="Of vehicles elsewhere [mavlink.driver]."
        ),
        click.option(
            "--signing-keys", metavar="FILE", help="MAVLink 2 keys [mavlink.signing_keys]."
        ),
    ]
    for option in reversed(options):
        command = option(command)
    return command


def _keys(options: dict[str, Any]) -> dict[str, Any]:
    """Options by the dotted keys of the mission file."""
    return {_TABLES.get(name, "") + name: value for name, value in options.items()}


connecting = click.option(
    "--connect",
    multiple=True,
    metavar="URL",
    help="Vehicle of the next agent, such as udpin:127.0.0.1:14540; again for more.",
)


def load(mission: str | None, connect: tuple[str, ...], options: dict[str, Any]) -> Mission:
    """The mission of the command line.

    Args:
        mission: path of its file; None: the built-in example.
        connect: URLs of vehicles for its agents, in order.
        options: those of ``overrides``.

    Raises:
        ConfigError: something of it is wrong.
    """
    from uavbridge import config
    from uavbridge.config.connect import connect as connected

    keys = _keys(options)
    if mission is None and connect and keys["vehicles"] is None:
        keys["vehicles"] = len(connect)
    return connected(config.load(mission, keys), connect)


def as_resumed(mission: Mission, options: dict[str, Any]) -> Mission:
    """A recorded mission, with options that change how it is shown."""
    from msgspec.structs import replace

    shown = {key: options[key] for key in ("headless", "json") if options[key] is not None}
    return replace(mission, **shown)
