"""``uavbridge command``: orders to a mission that flies."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import click

from uavbridge.agent.orders import Verb
from uavbridge.bus.security import Identity
from uavbridge.bus.wire import Vector
from uavbridge.cli.group import echo_json
from uavbridge.cli.numbers import ABOVE_ZERO
from uavbridge.errors import BusError, ConfigError

ROUTER = "tcp/127.0.0.1:7447"
KEYS = click.option(
    "--keys", type=click.Path(path_type=Path), metavar="DIR", help="Identity, where one is asked."
)


def identity_of(folder: Path | None) -> Identity | None:
    """The identity in a folder that ``uavbridge keys new`` made."""
    return None if folder is None else Identity(folder)


def choose_mission(found: dict[str, list[int]], name: str | None, router: str) -> str:
    """The mission that is meant.

    Raises:
        BusError: there is none, not that one, or more than one to choose from.
    """
    known = ", ".join(sorted(found)) or "none"
    if name is not None:
        if name not in found:
            raise BusError(f"mission {name!r} is not at {router}; flying there: {known}")
        return name
    if len(found) != 1:
        raise BusError(f"which mission? flying at {router}: {known} (--mission NAME)")
    return next(iter(found))


def _point(text: str | None) -> Vector | None:
    if text is None:
        return None
    try:
        parts = [float(part) for part in text.split(",")]
    except ValueError:
        parts = []
    if len(parts) not in (2, 3) or not all(map(math.isfinite, parts)):
        raise ConfigError(f"--to: X,Y or X,Y,HEIGHT in metres, not {text!r}")
    x, y, *height = parts
    return x, y, height[0] if height else math.nan


@click.command()
@click.argument("verb", type=click.Choice([verb.value for verb in Verb]))
@click.option("--agent", type=int, metavar="N", help="One agent; without it all.")
@click.option("--to", metavar="X,Y[,Z]", help="Where goto goes to: m east, north and above home.")
@click.option("--mission", metavar="NAME", help="Which, if more than one flies.")
@click.option("--router", metavar="ENDPOINT", default=ROUTER, show_default=True, help="Of the bus.")
@KEYS
@click.option("--timeout", type=ABOVE_ZERO, default=5.0, show_default=True, help="For answers, s.")
@click.option("--json", "as_json", is_flag=True, help="Print the answers as JSON.")
@click.pass_context
def command(ctx: click.Context, /, verb: str, **options: Any) -> None:
    """Tell the agents of a flying mission what to do, and what came of it.

    \b
    pause     stand still in the air           resume    search on
    goto      fly to a point and stand still   rtl       fly home and land
    hold      the autopilot's own hold; the agent lets go of the vehicle
    takeover  take a vehicle back that was held or that somebody took
    land      land here                        abort     everybody lands, the mission ends

    Exit status: 0 when every agent obeyed, 1 when one refused or did not answer, 2 for bad input.
    """  # noqa: D301 - \b is click's
    from uavbridge.bus.zenoh_bus import ZenohBus, find_missions
    from uavbridge.command import send_order

    order, position, router = Verb(verb), _point(options["to"]), options["router"]
    if (order is Verb.GOTO) != (position is not None):
        raise ConfigError("--to: goto needs it, and nothing else takes it")
    identity = identity_of(options["keys"])
    found = find_missions(router, identity=identity)
    mission = choose_mission(found, options["mission"], router)
    agent = options["agent"]
    if agent is not None and agent not in found[mission]:
        raise BusError(f"agent {agent} is not there; flying in {mission}: {found[mission]}")
    with ZenohBus(router, mission, identity=identity) as bus:
        replies = send_order(
            bus,
            order,
            agents=tuple(found[mission]) if agent is None else (agent,),
            everyone=agent is None,
            name=os.urandom(8).hex(),
            position=position,
            timeout_s=options["timeout"],
        )
    if options["as_json"]:
        echo_json(replies)
    else:
        for reply in replies:
            result = "done" if reply.ok else reply.reason
            click.echo(f"agent {reply.agent:3d}  {verb}: {result} ({reply.took_s:.2f} s)")
    ctx.exit(0 if all(reply.ok for reply in replies) else 1)
