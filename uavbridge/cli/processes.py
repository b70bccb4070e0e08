"""``uavbridge agent`` and ``uavbridge router``: parts of a mission in processes of their own."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from uavbridge.bus.security import LAUNCHER, Identity, agent_name, place_name
from uavbridge.cli.command import KEYS, ROUTER, identity_of
from uavbridge.errors import ConfigError

if TYPE_CHECKING:
    from uavbridge.config import Mission


@click.command()
@click.argument("mission", type=click.Path(allow_dash=True))
@click.option("--id", "ids", type=int, multiple=True, help="Agent; may be repeated.")
@click.option(
    "--place", "place", type=int, multiple=True, help="Place agent instead; may be repeated."
)
@click.option(
    "--store", type=click.Path(path_type=Path), help="Folder where place agents keep their tiles."
)
@click.option("--router", metavar="ENDPOINT", default=ROUTER, show_default=True, help="Of the bus.")
@click.option("--connect", multiple=True, metavar="URL", help="Vehicles, in the order of --id.")
@click.option("--out", type=click.Path(path_type=Path), help="Folder for the recording.")
@KEYS
@click.option("--wait", type=float, default=60.0, show_default=True, help="For the launcher, s.")
@click.pass_context
def agent(
    ctx: click.Context,
    mission: str,
    ids: tuple[int, ...],
    place: tuple[int, ...],
    store: Path | None,
    router: str,
    connect: tuple[str, ...],
    out: Path | None,
    keys: Path | None,
    wait: float,
) -> None:
    """Fly single agents of MISSION (a TOML file; -: standard input), on a machine of their own.

    Or have single place agents of it keep their tiles of the pheromone maps (--place), until
    Ctrl-C. The launcher of the mission counts on them by its keys bus.remote and
    pheromones.remote. They may be started before it or after. Exit status: 0 when all landed,
    1 when something went wrong, 2 for bad input.
    """
    from uavbridge import config

    loaded = (
        config.parse(sys.stdin.read(), "standard input") if mission == "-" else config.load(mission)
    )
    if place:
        _keep(loaded, ids, place, store, router, keys, wait)
        return
    if not ids:
        raise ConfigError("--id or --place must be given")
    team = loaded.scenario().team
    for number in ids:
        if number not in team:
            raise ConfigError(f"--id: {number} is not in the team ({team[0]} to {team[-1]})")
    if len(set(ids)) < len(ids):
        raise ConfigError("--id: the same agent twice")
    identity = identity_of(keys)
    _own_identity(identity, [agent_name(number) for number in ids], "--id")
    if len(connect) > len(ids):
        raise ConfigError(f"--connect: {len(connect)} vehicles for {len(ids)} agents")
    if out is not None:
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as fault:
            raise ConfigError(f"--out: cannot write to {out}: {fault.strerror}") from None
    from uavbridge.runner.assemble import planner_of
    from uavbridge.runner.elsewhere import fly_elsewhere
    from uavbridge.runner.interrupts import interrupts

    with interrupts("these agents return; once more (Ctrl-C) stops at once") as stop:
        failures = fly_elsewhere(
            loaded,
            sorted(ids),
            planner_of,
            router=router,
            endpoints=dict(zip(ids, connect, strict=False)),
            folder=out,
            identity=identity,
            wait_s=wait,
            stop=stop,
            tell=lambda text: click.echo(text),
        )
    for failure in failures:
        click.echo(failure, err=True)
    ctx.exit(1 if failures else 0)


def _own_identity(identity: Identity | None, names: Sequence[str], option: str) -> None:
    """Credentials are one part's: nobody gets far with those of another."""
    if identity is None or identity.whose == LAUNCHER:
        return
    if len(names) > 1:
        raise ConfigError(f"{option}: one in each process where --keys says who it is")
    if identity.whose not in (None, names[0]):
        raise ConfigError(f"--keys: {identity.folder} is {identity.whose}'s, not {names[0]}'s")


def _keep(
    mission: Mission,
    ids: tuple[int, ...],
    places: tuple[int, ...],
    store: Path | None,
    router: str,
    keys: Path | None,
    wait: float,
) -> None:
    """Place agents alone."""
    from uavbridge.config.pheromones import tiles
    from uavbridge.runner.interrupts import interrupts
    from uavbridge.runner.keeping import keep_alone

    if ids:
        raise ConfigError("--place: not together with --id")
    table = mission.stigmergy()
    if table is None or table.form != "places":
        raise ConfigError('--place: the mission has no place agents (pheromones.form = "places")')
    known = tiles(mission, table)
    for number in places:
        if number not in known:
            raise ConfigError(f"--place: there is no {number} ({min(known)} to {max(known)})")
    identity = identity_of(keys)
    _own_identity(identity, [place_name(number) for number in sorted(set(places))], "--place")
    with interrupts("the place agents end") as stop:
        keep_alone(
            mission,
            sorted(set(places)),
            router=router,
            store=store,
            identity=identity,
            wait_s=wait,
            stop=stop,
            tell=click.echo,
        )


@click.command()
@click.option("--listen", metavar="ENDPOINT", default="auto", show_default=True, help="Its own.")
@click.option("--connect", multiple=True, metavar="ENDPOINT", help="Another router to link to.")
@KEYS
@click.option("--lingers", is_flag=True, hidden=True)
def router(listen: str, connect: tuple[str, ...], keys: Path | None, lingers: bool) -> None:
    """Run a zenoh router for missions, until Ctrl-C; prints its endpoint.

    With --keys it takes only sessions with an identity of the same mission, lets each do what is
    its own, and prints whom it refused.
    """
    from uavbridge.runner.interrupts import interrupts
    from uavbridge.runner.router import route

    with interrupts("the router ends") as stop:
        route(
            listen,
            connect,
            identity=identity_of(keys),
            lingers=lingers,
            stop=stop,
            ready=click.echo,
        )


@click.group()
def keys() -> None:
    """Make a mission's certificates."""


@keys.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--mission", type=click.Path(), help="Mission file; else the built-in example.")
@click.option("--host", "hosts", multiple=True, metavar="NAME", help="Of the router; may repeat.")
@click.option("--days", type=float, default=30.0, show_default=True, help="Good for so long.")
def new(folder: Path, mission: str | None, hosts: tuple[str, ...], days: float) -> None:
    """Make FOLDER: a certificate authority, and an identity for each part of a mission.

    Each machine gets the sub-folders of those who live there, and no others.
    """
    from uavbridge import config
    from uavbridge.config.pheromones import tiles

    loaded = config.load(mission)
    table = loaded.stigmergy()
    places = () if table is None or table.form != "places" else tuple(tiles(loaded, table))
    try:
        from uavbridge.keys import make
    except ModuleNotFoundError:
        raise ConfigError("keys: install the extra: pip install 'uavbridge[keys]'") from None

    team = loaded.scenario().team
    made = make(folder, loaded.name, team, places=places, hosts=hosts, days=days)
    click.echo(f"{len(made)} identities in {folder}: {', '.join(path.name for path in made)}")
