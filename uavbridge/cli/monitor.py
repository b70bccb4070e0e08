"""``uavbridge monitor``: watch a mission that flies, here or elsewhere."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from uavbridge.agent.orders import Verb
from uavbridge.cli.command import KEYS, ROUTER, choose_mission, identity_of
from uavbridge.cli.steps import steps
from uavbridge.errors import ConfigError

if TYPE_CHECKING:
    from uavbridge.bus.api import Bus
    from uavbridge.monitor.choice import Send
    from uavbridge.monitor.watch import MissionWatch


@click.command()
@click.argument("recording", type=click.Path(path_type=Path), required=False)
@click.option("--web", is_flag=True, help="In the browser; prints the page's address.")
@click.option("--port", type=int, default=8000, show_default=True, help="Of the page; 0: any.")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address of the page.")
@click.option("--token", envvar="UAVBRIDGE_TOKEN", metavar="T", help="Asked of who opens the page.")
@click.option("--mission", metavar="NAME", help="Which, if more than one flies.")
@click.option("--router", metavar="ENDPOINT", default=ROUTER, show_default=True, help="Of the bus.")
@KEYS
def monitor(recording: Path | None, **options: Any) -> None:
    """Watch a flying mission in the terminal: agents, merged map, events; keys give orders.

    It only listens, so it may join and leave at any time. With --web in the browser, and there
    a RECORDING (mission.mcap, or its folder) too.
    """
    if options["web"]:
        _in_browser(recording, options)
        return
    if recording is not None:
        raise ConfigError("RECORDING: only with --web; in the terminal, uavbridge replay plays it")
    from rich.console import Console

    from uavbridge.bus.zenoh_bus import ZenohBus, find_missions
    from uavbridge.monitor.terminal import run

    router, identity = options["router"], identity_of(options["keys"])
    mission = choose_mission(find_missions(router, identity=identity), options["mission"], router)
    with ZenohBus(router, mission, identity=identity) as bus:
        run(bus, lambda watch: _sender(bus, watch), Console())


def _sender(bus: Bus, watch: MissionWatch) -> Send:
    from uavbridge.command import send_order

    def send(verb: Verb, agent: int | None) -> str:
        there = sorted(one.id for one in watch.agents.values() if one.alive is not False)
        replies = send_order(
            bus,
            verb,
            agents=tuple(there) if agent is None else (agent,),
            everyone=agent is None,
            name=os.urandom(8).hex(),
            timeout_s=2.0,
        )
        refused = [f"agent {r.agent}: {r.reason}" for r in replies if not r.ok]
        done = f"{verb.value}: {len(replies) - len(refused)} of {len(replies)} done"
        took_s = max((reply.took_s for reply in replies), default=0.0)
        return "; ".join([f"{done} in {took_s:.2f} s", *refused])

    return send


def _in_browser(recording: Path | None, options: dict[str, Any]) -> None:
    from uavbridge.bus.zenoh_bus import find_missions
    from uavbridge.monitor.replayed import Player
    from uavbridge.monitor.web.pages import Place, check_extra, serve_live, serve_recording

    place = Place(options["host"], options["port"], options["token"])

    def ready(address: str) -> None:
        click.echo(f"{address}  (Ctrl-C ends)")

    if recording is not None:
        check_extra()
        with steps("reading") as tell:
            player = Player(recording, tell)
        serve_recording(player, place, ready)
        return
    router, identity = options["router"], identity_of(options["keys"])
    mission = choose_mission(find_missions(router, identity=identity), options["mission"], router)
    serve_live(router, mission, place, ready, identity=identity)
